"""Mirror images (x → −x) of configurations, contact names, plans and trajectories: clockwise tasks
come out of these.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.contacts import pair_from_name, pair_name
from wholearm_ros.model.modes import DYNAMIC
from wholearm_ros.model.motion_primitive import MotionPrimitive
from wholearm_ros.model.plan import ContactPlan, Leg
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.trajectory import ManipulationTrajectory


def mirror_configurations(q: np.ndarray) -> np.ndarray:
    """(…, 5) → (…, 5): left and right finger change places."""
    x, y, rotation, left, right = np.moveaxis(np.asarray(q), -1, 0)
    return np.stack([-x, y, -rotation, np.pi - right, np.pi - left], axis=-1)


def mirror_contacts(names: Sequence[str], scenario: Scenario) -> tuple[str, ...]:
    """Names of the mirrored pairs, of a scenario with as many vertices."""
    n, p = len(scenario.object.polygon.vertices), len(scenario.palm.vertices)
    return tuple(pair_name(_mirror_pair(pair_from_name(name), n, p)) for name in names)


def mirror_plan(plan: ContactPlan, scenario: Scenario) -> ContactPlan:
    """The plan for `scenario`, of which plan.scenario is the mirror image."""
    subgoals = tuple(
        replace(
            s,
            configuration=mirror_configurations(s.configuration),
            direction=-s.direction,
            contacts=mirror_contacts(s.contacts, scenario),
        )
        for s in plan.subgoals
    )
    legs = tuple(
        replace(
            leg,
            configurations=mirror_configurations(leg.configurations),
            contacts=mirror_contacts(leg.contacts, scenario),
            action=_mirrored_action(leg),
        )
        for leg in plan.legs
    )
    return replace(plan, scenario=scenario, subgoals=subgoals, legs=legs)


def _mirrored_action(leg: Leg) -> dict[str, Any]:
    """What a leg says of its execution names front and rear finger, which mirroring keeps."""
    if leg.mode != DYNAMIC:
        return leg.action
    return MotionPrimitive.from_dict(leg.action).mirrored().to_dict()


def mirror_trajectory(t: ManipulationTrajectory, scenario: Scenario) -> ManipulationTrajectory:
    """The trajectory for `scenario`, made for its mirror image."""
    segments = tuple(
        replace(
            s, velocity_finger=1 - s.velocity_finger, contacts=mirror_contacts(s.contacts, scenario)
        )
        for s in t.segments
    )
    return replace(
        t,
        angles=np.pi - t.angles[:, ::-1],
        velocities=-t.velocities[:, ::-1],
        efforts=-t.efforts[:, ::-1],
        torque_ranges=-t.torque_ranges[:, ::-1],
        poses=t.poses * [-1.0, 1.0, -1.0],
        segments=segments,
    )


def _mirror_pair(code: int, n: int, p: int) -> int:
    kind, body = int(geometry.pair_kind(code)), int(geometry.pair_body(code))
    hand, feature = int(geometry.pair_hand_feature(code)), int(geometry.pair_object_feature(code))
    if body == geometry.PALM:
        hand = p - 2 - hand if kind == geometry.VERTEX_EDGE else p - 1 - hand
    else:
        body = geometry.LEFT_FINGER + geometry.RIGHT_FINGER - body
    feature = (-feature) % n if kind == geometry.VERTEX_EDGE else n - 1 - feature
    return int(geometry.pair_code(kind, body, hand, feature))
