"""Who may open the page: its address, its origin, and the token where other machines may ask."""

import ipaddress
import secrets
from dataclasses import dataclass, field
from urllib.parse import urlsplit

from wholearm_ros.errors import WholeArmError

LOOPBACK = '127.0.0.1'
LOCAL_NAMES = ('127.0.0.1', 'localhost', '::1')
COOKIE = 'wholearm_console'
MOST_SESSIONS = 256  # of browsers that showed the token


@dataclass(frozen=True)
class Access:
    """address: on which the server listens; token: that a browser has to show once, '' for none;
    sessions: of those that did.
    """

    address: str
    token: str = ''
    sessions: dict[str, None] = field(default_factory=dict)

    def host_allowed(self, host: str) -> bool:
        """Whether the header `Host` is one of ours: on the loopback a foreign name that leads here
        is a page that pretends (DNS rebinding).
        """
        name = urlsplit(f'//{host}').hostname
        return bool(name) and (name in LOCAL_NAMES or not is_loopback(self.address))

    def origin_allowed(self, origin: str | None, host: str) -> bool:
        """Whether a request comes from our own page, or from no page at all."""
        return origin is None or origin in (f'http://{host}', f'https://{host}')

    def log_in(self, token: str) -> str | None:
        """A new session for whoever knows the token; compared in constant time."""
        if not self.token or not secrets.compare_digest(token.encode(), self.token.encode()):
            return None
        while len(self.sessions) >= MOST_SESSIONS:
            self.sessions.pop(next(iter(self.sessions)))
        session = secrets.token_urlsafe(32)
        self.sessions[session] = None
        return session

    def known(self, session: str | None) -> bool:
        """Whether the request may go on: no token is asked for, or the session showed it."""
        if not self.token:
            return True
        given = (session or '').encode()
        return any(secrets.compare_digest(given, own.encode()) for own in self.sessions)


def is_loopback(address: str) -> bool:
    """Whether only this machine reaches an address; raises ValueError of what is none."""
    return ipaddress.ip_address(address).is_loopback


def make_access(address: str, with_token: bool) -> Access:
    """Raises WholeArmError for another address than the loopback's without a token."""
    try:
        needs_token = not is_loopback(address)
    except ValueError as error:
        raise WholeArmError(
            f'--address: got {address!r}; allowed: an IP address, {LOOPBACK} for this machine only'
        ) from error
    if needs_token and not with_token:
        raise WholeArmError(
            f'--address {address}: other machines could command the hand; '
            f'allowed: together with --token, or {LOOPBACK}'
        )
    return Access(address, secrets.token_urlsafe(24) if with_token else '')
