"""What a user may choose, each enumeration once. Imports nothing, so that --help is quick."""

from enum import Enum


def values(choices: type[Enum]) -> tuple[str, ...]:
    """What may be chosen, as text."""
    return tuple(choice.value for choice in choices)


class Search(str, Enum):
    """How Phase 1 searches: widest torque margins first, or at random as in the paper."""

    best = 'best'
    random = 'random'


class Transition(str, Enum):
    """How to cross between torque ranges that do not overlap."""

    auto = 'auto'
    dwell = 'dwell'
    dynamic = 'dynamic'


class Backend(str, Enum):
    """Physics of the simulated hand, in order of preference."""

    pybullet = 'pybullet'
    mujoco = 'mujoco'
    planar = 'planar'


class Hardware(str, Enum):
    """What the hand is: simulated by one of the backends, one that is there, or drives under
    ros2_control.
    """

    pybullet = 'pybullet'
    mujoco = 'mujoco'
    planar = 'planar'
    none = 'none'
    ros2_control = 'ros2_control'


class Pacing(str, Enum):
    """Clock of the ROS graph: the wall clock, or simulated time that waits for every command."""

    realtime = 'realtime'
    lockstep = 'lockstep'


class CommandStamps(str, Enum):
    """What the stamps of joint commands are: of the joint states they answer, or their sender's."""

    answered = 'answered'
    arrival = 'arrival'


class Storage(str, Enum):
    """File format of a bag."""

    mcap = 'mcap'
    sqlite3 = 'sqlite3'
