"""Single kernels against their plain NumPy twins, on the same configurations, with the same answers."""

import numpy as np
import plain
from numba import njit
from timing import row, seconds

from wholearm_ros.kernels import arc_tracing, geometry, statics
from wholearm_ros.mechanics.contacts import four_contact_subsets, gap_table
from wholearm_ros.planning.new_subgoal import new_subgoal
from wholearm_ros.planning.problem import build_problem

BATCH, REPEATS = 300, 15
NUDGE = 0.01  # [m, rad] off the manifold, for the projection to take back


# Loops of compiled code, so that a kernel is called as other kernels call it; each round is another configuration.
@njit
def _gap_tables(world, qs, gaps, codes):
    for i in range(len(qs)):
        geometry.gap_table(world, qs[i], gaps[i], codes)


@njit
def _torque_ranges(rows, loads, limits, finger, ends):
    forces = np.empty((4, 2))
    for i in range(len(rows)):
        ends[i, 0], ends[i, 1], _ = statics.torque_interval(
            rows[i], loads[i], limits, finger, forces
        )


@njit
def _projections(world, codes, qs, hold):
    manifold, good = arc_tracing.new_manifold(world, codes), 0
    for i in range(len(qs)):
        good += arc_tracing.project(world, manifold, qs[i], hold)
    return good


def bench_kernels(scenario, batch: int = BATCH, repeats: int = REPEATS) -> dict:
    """name → row, on configurations along the arcs that leave the start of `scenario`.

    Raises AssertionError when a kernel and its twin differ.
    """
    task = build_problem(scenario)
    world, cases = task.world, list(_arcs(task))
    drawn = np.random.default_rng(0).integers(len(cases), size=batch)
    codes, expansion = max(cases, key=lambda case: len(case[1].arcs[0].configurations))
    qs = np.array([cases[k][1].arcs[0].configurations[-1] for k in drawn])
    return {
        'kernel.gap_table': _gap_table(world, qs, repeats),
        'kernel.torque_range': _torque_range(world, codes, expansion, batch, repeats),
        'kernel.projection': _projection(world, codes, expansion, batch, repeats),
        'kernel.one_arc': _arc(task, cases, repeats),
    }


def _arcs(task):
    """(codes, expansion) of all arcs from the start, one way and the other, that lead anywhere."""
    for pairs in four_contact_subsets(task.pairs):
        for side in (0, 1):
            for direction in (1.0, -1.0):
                for found in new_subgoal(
                    task, task.start, pairs, direction * np.eye(5)[3 + side], side
                ):
                    if found.arcs and len(found.arcs[0].configurations) > 3:
                        yield np.array(pairs), found


def _gap_table(world, qs, repeats):
    gaps = np.empty((len(qs), len(gap_table(world, qs[0])[0])))
    codes = np.empty(gaps.shape[1], dtype=np.int64)

    def compiled():
        _gap_tables(world, qs, gaps, codes)

    compiled()
    np.testing.assert_allclose(gaps, [plain.gap_table(world, q) for q in qs], atol=1e-12)
    return _row(compiled, lambda: [plain.gap_table(world, q) for q in qs], len(qs), repeats)


def _along(expansion, batch):
    """(batch, 5) configurations of the first arc, again and again."""
    return np.resize(expansion.arcs[0].configurations, (batch, 5))


def _torque_range(world, codes, expansion, batch, repeats):
    qs = _along(expansion, batch)
    rows = np.array([plain.rows_and_gaps(world, codes, q)[0] for q in qs])
    loads, ends = np.array([plain.load_at(world, q) for q in qs]), np.empty((batch, 2))

    def compiled():
        _torque_ranges(rows, loads, world.torque_limits, 0, ends)

    def obvious():
        return [plain.torque_range(r, load, world.torque_limits, 3) for r, load in zip(rows, loads)]

    compiled()
    full = ends[:, 0] < ends[:, 1]
    np.testing.assert_allclose(ends[full], np.array(obvious())[full], atol=1e-8)
    return _row(compiled, obvious, batch, repeats)


def _projection(world, codes, expansion, batch, repeats):
    hold = np.eye(5)[3]
    off = (
        _along(expansion, batch)
        + NUDGE * np.random.default_rng(1).uniform(-1, 1, (batch, 5)) * world.scale
    )

    def compiled():
        assert _projections(world, codes, off.copy(), hold) == batch

    def obvious():
        return [plain.project(world, codes, q, hold) for q in off]

    compiled()
    here = off.copy()
    _projections(world, codes, here, hold)
    np.testing.assert_allclose(here, obvious(), atol=1e-8)
    return _row(compiled, obvious, batch, repeats)


def _arc(task, cases, repeats):
    """One expansion as the search asks for it, events located, against steps of a degree along as much of it."""
    asked = [
        (codes, np.eye(5)[3 + side] * direction, side)
        for codes in {tuple(c.tolist()): c for c, _ in cases}.values()
        for side in (0, 1)
        for direction in (1.0, -1.0)
    ]

    def compiled():
        for codes, toward, side in asked:
            new_subgoal(task, task.start, tuple(codes), toward, side)

    def obvious():
        for codes, toward, side in asked:
            for found in new_subgoal(task, task.start, tuple(codes), toward, side)[:1]:
                for arc in found.arcs:
                    if len(arc.configurations) > 1:
                        plain.follow_arc(
                            task.world,
                            np.array(arc.pairs),
                            arc.configurations[0],
                            arc.tangents[0],
                            arc.length(task.world.scale),
                        )

    return _row(compiled, obvious, len(asked), repeats)


def _row(compiled, obvious, size, repeats) -> dict:
    """Microseconds a call."""
    compiled(), obvious()
    return row(
        np.array(seconds(compiled, repeats)) / size,
        1e6,
        'µs',
        np.array(seconds(obvious, max(3, repeats // 5))) / size,
    )
