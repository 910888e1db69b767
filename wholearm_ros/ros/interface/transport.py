"""The transport of every process of the graph: UDP on the loopback, unless the user says otherwise.

Two things must hold by default. No publish of the loop may wait: Fast DDS's shared memory makes the
first message to each new participant wait for the health check of its port, up to a second
(docs/ros.md). And nobody on the network may reach the drives. A Fast DDS profile does both. It is
chosen by environment variables, which the middleware reads when a process makes its first node: so
`choose_transport` must be called before, and the processes started later follow.
"""

import os
from collections.abc import MutableMapping
from pathlib import Path

PROFILES = Path(__file__).parent / 'profiles'
LOOPBACK, NETWORK = str(PROFILES / 'loopback.xml'), str(PROFILES / 'network.xml')

PROFILE = 'FASTRTPS_DEFAULT_PROFILES_FILE'
DISCOVERY = 'ROS_AUTOMATIC_DISCOVERY_RANGE'
LOCALHOST_ONLY = 'ROS_LOCALHOST_ONLY'  # the older name, which still overrides the new one
MIDDLEWARE = 'RMW_IMPLEMENTATION'
CHOSEN_BY_USER = (PROFILE, 'FASTDDS_DEFAULT_PROFILES_FILE', 'FASTDDS_BUILTIN_TRANSPORTS')
OPEN = ('SUBNET', 'SYSTEM_DEFAULT')


def choose_transport(
    environment: MutableMapping[str, str] = os.environ, network: bool = False
) -> str:
    """Set the environment of this process, and so of those it starts; a line that says the choice.

    network: other machines may take part, as they may when ROS_AUTOMATIC_DISCOVERY_RANGE is SUBNET
    or SYSTEM_DEFAULT. Nothing that the user chose is replaced: a profile
    (FASTRTPS_DEFAULT_PROFILES_FILE), built-in transports (FASTDDS_BUILTIN_TRANSPORTS, where DEFAULT
    gives Fast DDS's own) or another middleware (RMW_IMPLEMENTATION).
    """
    if network and environment.get(DISCOVERY) not in OPEN:
        environment[DISCOVERY] = 'SUBNET'
    theirs = _choice_of_the_user(environment)
    if theirs:
        environment[DISCOVERY] = environment.get(DISCOVERY) or 'LOCALHOST'
        return f'transport: as {theirs} says; discovery: {environment[DISCOVERY]}'
    inherited = environment.get(PROFILE) == LOOPBACK and not network
    if environment.get(DISCOVERY) in OPEN and not inherited:
        environment[PROFILE] = NETWORK
        return (
            'transport: UDP on every interface; '
            'other machines can take part, and command the drives'
        )
    environment[PROFILE] = LOOPBACK
    environment.pop(LOCALHOST_ONLY, None)
    if environment.get(DISCOVERY) != 'OFF':
        # LOCALHOST would add shared memory and a socket on every interface to the profile's
        # transport.
        environment[DISCOVERY] = 'SYSTEM_DEFAULT'
    return 'transport: loopback UDP; this machine only'


def _choice_of_the_user(environment: MutableMapping[str, str]) -> str:
    """The variable by which the user chose the transport, with its value; or nothing."""
    for name in CHOSEN_BY_USER:
        value = environment.get(name)
        if value and value not in (LOOPBACK, NETWORK):
            return f'{name}={value}'
    middleware = environment.get(MIDDLEWARE, '')
    return f'{MIDDLEWARE}={middleware}' if middleware and 'fastrtps' not in middleware else ''
