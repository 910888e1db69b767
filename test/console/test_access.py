"""Who may open the page: addresses, names, origins, tokens."""

import pytest

from wholearm_ros.console.access import MOST_SESSIONS, make_access
from wholearm_ros.errors import WholeArmError


@pytest.mark.parametrize('address', ['0.0.0.0', '192.168.1.5', '::'])
def test_another_address_needs_a_token(address):
    with pytest.raises(WholeArmError, match='--token'):
        make_access(address, with_token=False)
    assert len(make_access(address, with_token=True).token) >= 24


def test_a_name_is_no_address():
    with pytest.raises(WholeArmError, match='allowed: an IP address'):
        make_access('everywhere', with_token=True)


def test_on_the_loopback_only_its_own_names_and_origin_are_served():
    access = make_access('127.0.0.1', with_token=False)
    assert access.host_allowed('127.0.0.1:8470') and access.host_allowed('localhost:8470')
    assert access.host_allowed('[::1]:8470')
    assert not access.host_allowed('evil.example:8470') and not access.host_allowed('')
    assert access.origin_allowed('http://localhost:8470', 'localhost:8470')
    assert access.origin_allowed(None, 'localhost:8470')  # no page asked
    for origin in ('http://evil.example', 'http://localhost:9999', 'null', ''):
        assert not access.origin_allowed(origin, 'localhost:8470')


def test_a_session_is_given_for_the_token_only_and_they_do_not_pile_up():
    access = make_access('0.0.0.0', with_token=True)
    assert access.log_in('') is None and access.log_in(access.token[:-1]) is None
    assert access.log_in('ä') is None
    assert not access.known(None) and not access.known('') and not access.known('ä')
    first = access.log_in(access.token)
    assert access.known(first) and first != access.token
    for _ in range(MOST_SESSIONS):
        last = access.log_in(access.token)
    assert len(access.sessions) == MOST_SESSIONS
    assert access.known(last) and not access.known(first)
