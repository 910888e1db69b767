"""Who of the clients may command: one at a time."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Control:
    """holder: the number of the client that has control, None for nobody."""

    holder: int | None = None

    def asked(self, client: int, take: bool = False) -> 'tuple[Control, str]':
        """After a client has asked; the reason for a refusal, '' when it has control now.

        take: from whoever has it, which its page has confirmed.
        """
        if self.holder in (None, client) or take:
            return Control(client), ''
        return (
            self,
            f'client {self.holder} has control; allowed: take it over, after a confirmation',
        )

    def released(self, client: int) -> 'Control':
        """After a client has given control up, or has gone."""
        return Control() if self.holder == client else self

    def refusal(self, client: int) -> str:
        """Why a client may not command; '' when it may."""
        if self.holder == client:
            return ''
        who = 'nobody' if self.holder is None else f'client {self.holder}'
        return f'this page has no control ({who} has); allowed: ask for it first. Stop always works'
