"""The hand as URDF: palm, both fingers and their joints, made from the scenario."""

from collections.abc import Iterator
from itertools import pairwise
from math import atan2
from xml.sax.saxutils import quoteattr

import numpy as np

from wholearm_ros.model.finger_shape import FingerShape, Rectangle
from wholearm_ros.model.hand import JOINT_NAMES, SIDES, Finger
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.union import below
from wholearm_ros.ros.interface.channels import FINGER_FRAMES, NAMESPACE, PALM_FRAME, frame_in

THICKNESS = 0.02  # [m] across the plane, for show
SLICES = 12  # of a part of a finger that is no rectangle
MAX_SPEED = 20.0  # [rad/s]


def urdf(scenario: Scenario, ros2_control: str = '', namespace: str = NAMESPACE) -> str:
    """x right, y up in the support plane, z towards the onlooker: the joints turn about z.

    ros2_control: a tag of that name, as `topic_system` makes one; namespace: of the hand, which its
    links are named after; its joints are not, `joint_states` names them.
    """
    palm, *fingers = (frame_in(namespace, frame) for frame in (PALM_FRAME, *FINGER_FRAMES))
    parts = [
        '<?xml version="1.0"?>',
        f'<robot name={quoteattr(scenario.name or "wholearm")}>',
        f'<link name="{palm}">',
        *_palm_slabs(scenario),
        '</link>',
    ]
    for side, joint, frame in zip(SIDES, JOINT_NAMES, fingers):
        parts += _finger(getattr(scenario.hand, side), joint, palm, frame)
    return '\n'.join([*parts, *([ros2_control] if ros2_control else []), '</robot>', ''])


def topic_system(namespace: str) -> str:
    """The ros2_control tag for our stand-in in `namespace`, spoken to by JointStateTopicSystem.

    For drives of your own replace the plugin. Both joints need the effort command interface: the
    plugin leaves out the effort of a joint without, and then nothing tells whose the others are.
    """
    interfaces = [
        '<command_interface name="effort"/>',
        *(f'<state_interface name="{kind}"/>' for kind in ('position', 'velocity', 'effort')),
    ]
    return '\n'.join(
        [
            '<ros2_control name="wholearm" type="system">',
            '<hardware>',
            '<plugin>joint_state_topic_hardware_interface/JointStateTopicSystem</plugin>',
            f'<param name="joint_commands_topic">{namespace}/joint_commands</param>',
            f'<param name="joint_states_topic">{namespace}/joint_states</param>',
            '<!-- Always send: a constant torque that goes silent ends as a hold. -->',
            '<param name="trigger_joint_command_threshold">-1</param>',
            '</hardware>',
            *(
                line
                for joint in JOINT_NAMES
                for line in (f'<joint name="{joint}">', *interfaces, '</joint>')
            ),
            '</ros2_control>',
        ]
    )


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


def _finger(finger: Finger, joint: str, palm: str, frame: str) -> list[str]:
    low, high = finger.angle_limits
    x, y = finger.shape.centre
    across = finger.inertia_about_centre
    return [
        f'<link name="{frame}">',
        f'<inertial><origin xyz="{x:.6g} {y:.6g} 0"/><mass value="{finger.mass:.6g}"/>'
        f'<inertia ixx="1e-5" iyy="{across:.6g}" izz="{across:.6g}" ixy="0" ixz="0" iyz="0"/>'
        '</inertial>',
        *(_finger_box(*box) for box in _boxes(finger.shape)),
        '</link>',
        f'<joint name="{joint}" type="revolute">'
        f'<parent link="{palm}"/><child link="{frame}"/>'
        f'<origin xyz="{finger.axis[0]:.6g} {finger.axis[1]:.6g} 0"/><axis xyz="0 0 1"/>'
        f'<limit lower="{low:.6g}" upper="{high:.6g}" effort="{finger.torque_limit:.6g}" '
        f'velocity="{MAX_SPEED}"/>'
        '</joint>',
    ]


def _boxes(shape: FingerShape) -> Iterator[tuple[float, float, float, float]]:
    """low x, high x, low y, high y [m] of boxes that fill a finger: URDF has no polygons.

    A part that is no rectangle is cut into SLICES across x, each as wide as in its middle.
    """
    if isinstance(shape, Rectangle):
        yield 0.0, shape.length, -shape.half_width, shape.half_width
        return
    for part in shape.parts:
        cuts = np.linspace(part[:, 0].min(), part[:, 0].max(), SLICES + 1)
        for low, high in pairwise(cuts):
            middle = below(part, np.array([1.0, 0.0]), (low + high) / 2)
            rim = middle[middle[:, 0] >= (low + high) / 2 - 1e-12, 1]
            yield low, high, rim.min(), rim.max()


def _finger_box(left: float, right: float, low: float, high: float) -> str:
    return _box(
        f'{(left + right) / 2:.6g} {(low + high) / 2:.6g} 0',
        0.0,
        f'{right - left:.6g} {high - low:.6g} {THICKNESS:.6g}',
        '0.2 0.4 0.8 1',
    )


def _box(xyz: str, yaw: float, size: str, colour: str) -> str:
    shape = f'<origin xyz="{xyz}" rpy="0 0 {yaw:.6g}"/><geometry><box size="{size}"/></geometry>'
    name = 'colour_' + colour.replace(' ', '_')
    return (
        f'<visual>{shape}<material name="{name}"><color rgba="{colour}"/></material></visual>'
        f'<collision>{shape}</collision>'
    )
