"""A subscription of a topic that never pauses: silence while somebody publishes is told, and the
subscription is made anew.
"""

from collections.abc import Callable
from typing import Any

from rclpy.subscription import Subscription

LOOK_PERIOD = 1.0  # [s] between two looks
PATIENCE = 5  # looks without a message before the first renewal
MOST_PATIENCE = 60  # each renewal that did not help doubles it, up to so many


class SteadySubscription:
    """Of `topic`, made by `subscribe(callback)`, which is given what `callback` shall hear.

    Silence is counted in looks, not in seconds: a process that was stopped takes what has come
    before it looks again. silent: for how many looks nothing was heard though a publisher is
    matched; deaf: whether the subscription was renewed since the last message; renewals: how often
    in all.
    """

    def __init__(
        self,
        topic: str,
        callback: Callable[[Any], None],
        subscribe: Callable[[Callable[[Any], None]], Subscription],
        unsubscribe: Callable[[Subscription], Any],
    ) -> None:
        self.topic, self._callback = topic, callback
        self._subscribe, self._unsubscribe = subscribe, unsubscribe
        self._heard, self._patience = False, PATIENCE
        self.silent, self.deaf, self.renewals = 0, False, 0
        self._subscription = subscribe(self._hear)

    def _hear(self, message: Any) -> None:
        self._heard = True
        self._callback(message)

    def look(self) -> str:
        """Renews what was silent for too long; a line for the log about what has changed, or ''."""
        publishers = self._subscription.get_publisher_count()
        if self._heard or not publishers:
            told = f'{self.topic}: heard again' if self._heard and self.deaf else ''
            self._heard, self.silent, self.deaf, self._patience = False, 0, False, PATIENCE
            return told
        self.silent += 1
        if self.silent % self._patience:
            return ''
        self._unsubscribe(self._subscription)
        self._subscription = self._subscribe(self._hear)
        self._patience = min(2 * self._patience, MOST_PATIENCE)
        self.deaf, self.renewals = True, self.renewals + 1
        return (
            f'{self.topic}: nothing heard for {self.silent * LOOK_PERIOD:.0f} s though '
            f'{publishers} publish it; subscribed anew'
        )

    @property
    def problem(self) -> str:
        """For /diagnostics; '' when something is heard, or nobody publishes."""
        seconds = self.silent * LOOK_PERIOD
        return f'{self.topic}: nothing heard for {seconds:.0f} s' if self.deaf else ''
