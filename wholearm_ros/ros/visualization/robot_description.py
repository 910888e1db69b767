"""The hand as URDF: palm, both fingers and their joints, made from the scenario."""

from collections.abc import Iterator
from math import atan2
from xml.sax.saxutils import quoteattr

from wholearm_ros.model.hand import JOINT_NAMES, SIDES, Finger
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.ros.interface.channels import FINGER_FRAMES, PALM_FRAME

THICKNESS = 0.02  # [m] across the plane, for show
MAX_SPEED = 20.0  # [rad/s]


def urdf(scenario: Scenario) -> str:
    """x right, y up in the support plane, z towards the onlooker: the joints turn about z."""
    parts = [
        '<?xml version="1.0"?>',
        f'<robot name={quoteattr(scenario.name or "wholearm")}>',
        f'<link name="{PALM_FRAME}">',
        *_palm_slabs(scenario),
        '</link>',
    ]
    for side, joint, frame in zip(SIDES, JOINT_NAMES, FINGER_FRAMES):
        parts += _finger(getattr(scenario.hand, side), joint, frame)
    return '\n'.join([*parts, '</robot>', ''])


def _palm_slabs(scenario: Scenario) -> Iterator[str]:
    vertices = scenario.palm.vertices
    for a, b in zip(vertices[:-1], vertices[1:]):
        along = b - a
        length = float((along @ along) ** 0.5)
        normal = [-along[1] / length, along[0] / length]
        x, y = (a + b) / 2 - [normal[0] * 0.005, normal[1] * 0.005]
        yield _box(
            f'{x:.6g} {y:.6g} 0',
            atan2(along[1], along[0]),
            f'{length:.6g} 0.01 {2 * THICKNESS:.6g}',
            '0.6 0.6 0.6 1',
        )


def _finger(finger: Finger, joint: str, frame: str) -> list[str]:
    low, high = finger.angle_limits
    centre = finger.length / 2
    across = finger.inertia - finger.mass * centre**2
    return [
        f'<link name="{frame}">',
        f'<inertial><origin xyz="{centre:.6g} 0 0"/><mass value="{finger.mass:.6g}"/>'
        f'<inertia ixx="1e-5" iyy="{across:.6g}" izz="{across:.6g}" ixy="0" ixz="0" iyz="0"/>'
        '</inertial>',
        _box(
            f'{centre:.6g} 0 0',
            0.0,
            f'{finger.length:.6g} {2 * finger.half_width:.6g} {THICKNESS:.6g}',
            '0.2 0.4 0.8 1',
        ),
        '</link>',
        f'<joint name="{joint}" type="revolute">'
        f'<parent link="{PALM_FRAME}"/><child link="{frame}"/>'
        f'<origin xyz="{finger.axis[0]:.6g} {finger.axis[1]:.6g} 0"/><axis xyz="0 0 1"/>'
        f'<limit lower="{low:.6g}" upper="{high:.6g}" effort="{finger.torque_limit:.6g}" '
        f'velocity="{MAX_SPEED}"/>'
        '</joint>',
    ]


def _box(xyz: str, yaw: float, size: str, colour: str) -> str:
    shape = f'<origin xyz="{xyz}" rpy="0 0 {yaw:.6g}"/><geometry><box size="{size}"/></geometry>'
    name = 'colour_' + colour.replace(' ', '_')
    return (
        f'<visual>{shape}<material name="{name}"><color rgba="{colour}"/></material></visual>'
        f'<collision>{shape}</collision>'
    )
