"""Which of the pages may command: one at a time."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Control:
    """holder: the number of the page that has control, None for nobody."""

    holder: int | None = None

    def asked(self, page: int, take: bool = False) -> 'tuple[Control, str]':
        """After a page has asked; the reason for a refusal, '' when it has control now.

        take: from whoever has it, which its page has confirmed.
        """
        if self.holder in (None, page) or take:
            return Control(page), ''
        return (
            self,
            f'page {self.holder} has control; allowed: take it over, after a confirmation',
        )

    def released(self, page: int) -> 'Control':
        """After a page has given control up, or has gone."""
        return Control() if self.holder == page else self

    def refusal(self, page: int) -> str:
        """Why a page may not command; '' when it may."""
        if self.holder == page:
            return ''
        who = 'nobody' if self.holder is None else f'page {self.holder}'
        return f'this page has no control ({who} has); allowed: ask for it first. Stop always works'
