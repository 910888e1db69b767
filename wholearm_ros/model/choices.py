"""What a person may choose on the command line, and what its exit codes say. Imports nothing: --help is quick."""

from enum import Enum

OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130


class Search(str, Enum):
    best = 'best'
    random = 'random'


class Transition(str, Enum):
    auto = 'auto'
    dwell = 'dwell'
    dynamic = 'dynamic'


class Backend(str, Enum):
    pybullet = 'pybullet'
    mujoco = 'mujoco'
    planar = 'planar'
