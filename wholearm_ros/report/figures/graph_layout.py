"""Where the subgoals of a contact-state transition graph are drawn: columns by depth, the route
along the top row.
"""

from collections import Counter, deque
from collections.abc import Collection
from dataclasses import dataclass
from typing import Optional

from wholearm_ros.model.plan import X_END, ContactPlan, Y

LIMIT = 60  # subgoals drawn; of larger graphs the route with its neighbourhood


@dataclass(frozen=True)
class GraphLayout:
    """cells: subgoal number → (column, row); edges: (number, number, on the route); hidden: number
    → subgoals that were left out behind it; merged: subgoals not drawn because they share a
    configuration with one that is.
    """

    cells: dict[int, tuple[int, int]]
    edges: tuple[tuple[int, int, bool], ...]
    route: tuple[int, ...]
    hidden: dict[int, int]
    merged: int

    @property
    def columns(self) -> int:
        """How many there are."""
        return 1 + max((c for c, _ in self.cells.values()), default=0)

    @property
    def rows(self) -> int:
        """How many there are."""
        return 1 + max((r for _, r in self.cells.values()), default=0)


def lay_out(plan: ContactPlan, limit: int = LIMIT) -> GraphLayout:
    """As in the paper's Figure 6: X_start and X_through are drawn; an X_end and its Y are not,
    where a start follows.
    """
    parents = {s.number: s.parent for s in plan.subgoals}
    shown = _drawn(plan, parents)
    up = {n: _nearest(parents, parents[n], shown) for n in shown}
    children = _children(up)
    route = tuple(n for n in plan.path if n in shown)
    kept = _nearest_to_route(up, children, route, limit)
    hidden = Counter(_nearest(up, n, kept) for n in shown if n not in kept)
    hidden.pop(None, None)
    cells = _place(_children({n: up[n] for n in kept}), set(route))
    on_route = set(zip(route, route[1:]))
    edges = tuple((up[n], n, (up[n], n) in on_route) for n in sorted(kept) if up[n] is not None)
    return GraphLayout(cells, edges, route, dict(hidden), len(plan.subgoals) - len(shown))


def _drawn(plan: ContactPlan, parents: dict[int, Optional[int]]) -> set:
    kinds = {s.number: s.kind for s in plan.subgoals}
    followed = {p for p in parents.values() if p is not None}
    before_y = {
        parents[n] for n, kind in kinds.items() if kind == Y and kinds.get(parents[n]) == X_END
    }
    return {
        n for n, kind in kinds.items() if n not in before_y and not (kind == Y and n in followed)
    }


def _nearest(
    parents: dict[int, Optional[int]], number: Optional[int], shown: Collection[int]
) -> Optional[int]:
    """The first of `number` and its ancestors that is shown, or None."""
    while number is not None and number not in shown:
        number = parents[number]
    return number


def _children(parents: dict[int, Optional[int]]) -> dict[int, list[int]]:
    children = {None: []}
    for number in sorted(parents):
        children.setdefault(number, [])
        children.setdefault(parents[number], []).append(number)
    return children


def _nearest_to_route(
    up: dict[int, Optional[int]],
    children: dict[Optional[int], list[int]],
    route: Collection[int],
    limit: int,
) -> set:
    kept, queue = set(), deque(route or children[None][:1])
    while queue and (len(kept) < limit or queue[0] in route):
        number = queue.popleft()
        if number in kept:
            continue
        if up[number] is None or up[number] in kept:
            kept.add(number)
            queue.extend(children[number])
    return kept


def _place(
    children: dict[Optional[int], list[int]], route: Collection[int]
) -> dict[int, tuple[int, int]]:
    cells, free = {}, Counter()

    def place(number: Optional[int], column: int, row: int) -> int:
        row = max(row, free[column])
        free[column] = row + 1
        cells[number] = (column, row)
        return row

    stack = [(n, 0, 0) for n in reversed(children[None])]
    while stack:
        number, column, row = stack.pop()
        row = place(number, column, row)
        following = sorted(children[number], key=lambda n: (n not in route, n))
        stack.extend((n, column + 1, row) for n in reversed(following))
    return cells
