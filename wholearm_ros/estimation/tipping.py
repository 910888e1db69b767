"""How hard an object that lies between the fingers may be pressed before it leaves the palm with a
vertex.
"""

from itertools import product
from typing import NamedTuple

import numpy as np

from wholearm_ros.estimation.squeeze import Resting
from wholearm_ros.kernels import geometry
from wholearm_ros.mechanics.contacts import gap_table
from wholearm_ros.mechanics.quasistatic import build_quasistatics
from wholearm_ros.mechanics.world import World
from wholearm_ros.model.configuration import POSE, SIZE
from wholearm_ros.model.hand import LEFT, RIGHT

NEARLY = 5e-4  # [m] a feature as near as this counts as touching: tilted by so little, it does
ALONG, HELD, CLOSING = 0, 2, 3  # row of a wrench; columns of the fingers' contacts


class Doubt(NamedTuple):
    """outline [m]: by which either end of the edge that carries the object may be nearer to the
    centroid than is believed; friction: coefficient of what slides.
    """

    outline: float
    friction: float


NO_DOUBT = Doubt(0.0, 0.0)
DOUBT = Doubt(0.001, 0.10)  # as at perturbation level 2
LESS_DOUBT = Doubt(0.0005, 0.05)  # as at perturbation level 1


def tipping_torque(
    world: World,
    resting: Resting,
    held: int,
    q: np.ndarray,
    doubt: Doubt = NO_DOUBT,
    alone: bool = True,
) -> float:
    """[N m] of the closing finger, beyond its own weight, above which the object squeezed at q (5,)
    leaves the palm with a vertex while it slides; infinite where none does, zero where the object
    does not even lie.

    Where a finger touches, or nearly touches, with two features, as in a state of five contacts,
    the better one counts: an object that tips on the other one closes both and stays.

    doubt: how far object and hand may be from what is believed; alone: whether the closing finger
    also pushes the object by itself, until the held one stops it.
    """
    n = len(world.obj)
    palm = [
        int(geometry.pair_code(geometry.VERTEX_EDGE, geometry.PALM, resting.segment, k))
        for k in (resting.edge, (resting.edge + 1) % n)
    ]
    gaps, codes = gap_table(world, q)
    near = [int(code) for code in codes[np.abs(gaps) < NEARLY]]
    touching = [[c for c in near if geometry.pair_body(c) == 1 + side] for side in (LEFT, RIGHT)]
    pairs = product(touching[held], touching[1 - held])
    pressed = [_pressed(world, resting, (*palm, *pair), q, doubt.outline) for pair in pairs]
    return max(
        (
            abs(float(one.lever[1 - held])) * one.tipping_force(doubt.friction, alone)
            for one in pressed
        ),
        default=0.0,
    )


class Pressed(NamedTuple):
    """An object upon two palm contacts, between the held and the closing finger, in that order.

    normals, tangents: (3, 4) wrenches of unit forces: along the palm [N], across it [N], about the
    centroid [N m]; load: (3,) its weight; height [m] of the centroid; lever: (2,) [m] of the
    closing finger's contact about either axis.
    """

    normals: np.ndarray
    tangents: np.ndarray
    load: np.ndarray
    height: float
    lever: np.ndarray

    def tipping_force(self, friction: float, alone: bool) -> float:
        """[N] of the closing finger above which a palm contact opens, in whichever direction the
        object slides along the palm and past the fingers.
        """
        pushes = float(np.sign(self.normals[ALONG, HELD]))
        least = np.inf
        if alone:
            least = self._sliding_force()
        for drags in product((-friction, friction), repeat=2) if friction else [(0.0, 0.0)]:
            least = min(least, self._limit(pushes, friction, drags, False))
            if alone:
                least = min(least, self._limit(-pushes, friction, drags, True))
        return least

    def _limit(
        self, motion: float, friction: float, drags: tuple[float, ...], led_away: bool
    ) -> float:
        """The same, sliding along the palm in direction `motion` (±1), the fingers' friction
        `drags` along their tangents.

        The palm's two forces and the held finger's balance any force of the closing one; the least
        is none, or, when the object is led away, what overcomes the palm's friction.
        """
        wrenches = self.normals.copy()
        wrenches[:, :2] -= motion * friction * np.array([[1.0], [0.0], [self.height]])
        wrenches[:, 2:] += self.tangents[:, 2:] * drags
        try:
            still, by_force = np.linalg.solve(
                wrenches[:, :3], -np.column_stack([self.load, wrenches[:, CLOSING]])
            ).T
        except np.linalg.LinAlgError:
            return 0.0
        if by_force[2] <= 0.0:
            return 0.0  # both fingers push the same way
        least = max(0.0, -still[2] / by_force[2]) if led_away else 0.0
        palm = still[:2] + least * by_force[:2]
        if (palm < 0.0).any():
            return 0.0
        lifted = by_force[:2] < 0.0
        return float((still[:2][lifted] / -by_force[:2][lifted]).min()) if lifted.any() else np.inf

    def _sliding_force(self) -> float:
        """[N] above which it tips while it slides ahead of the closing finger alone, unhindered.

        Newton's law along the palm leaves two equations, across it and of moments, for the two
        forces of the palm.
        """
        rows = self.normals[1:]
        try:
            still = np.linalg.solve(rows[:, :2], -self.load[1:])
            pushed = np.linalg.solve(rows[:, :2], -rows[:, CLOSING])
        except np.linalg.LinAlgError:
            return 0.0
        lifted = pushed < 0.0
        if (still < 0.0).any():
            return 0.0
        return float(np.min(still[lifted] / -pushed[lifted])) if lifted.any() else np.inf


def _pressed(
    world: World, resting: Resting, pairs: tuple[int, ...], q: np.ndarray, outline: float
) -> Pressed:
    """With both palm contacts (the first two) nearer to the centroid by `outline` [m] each."""
    statics = build_quasistatics(world, pairs, q)
    rows = np.empty((len(pairs), SIZE))
    geometry.tangent_rows(world, np.asarray(pairs, np.int64), q, rows)
    along, across = resting.along, np.array([-resting.along[1], resting.along[0]])
    axes = np.zeros((3, 3))
    axes[0, :2], axes[1, :2], axes[2, 2] = along, across, 1.0
    normals, tangents = axes @ statics.G_n, axes @ rows[:, POSE].T
    normals[2, :2] -= outline * np.sign(normals[2, :2] - normals[2, :2].mean())
    return Pressed(normals, tangents, axes @ statics.g_O, resting.height, statics.J_n[CLOSING])
