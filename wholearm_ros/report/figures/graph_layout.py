"""Where the subgoals of a contact-state transition graph are drawn: columns by depth, the route
along the top row.
"""

from collections import Counter, deque
from collections.abc import Collection
from dataclasses import dataclass

from wholearm_ros.model.plan import X_END, ContactPlan, Y

LIMIT = 60  # subgoals drawn; of larger graphs the route with its neighbourhood

Parents = dict[int, int | None]  # None: of the first one
Children = dict[int | None, list[int]]


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
    behind = (_nearest(up, n, kept) for n in shown if n not in kept)
    hidden = Counter(n for n in behind if n is not None)
    cells = _place(_children({n: up[n] for n in kept}), set(route))
    on_route = set(zip(route, route[1:]))
    edges = tuple(
        (before, n, (before, n) in on_route) for n in sorted(kept) if (before := up[n]) is not None
    )
    return GraphLayout(cells, edges, route, dict(hidden), len(plan.subgoals) - len(shown))


def _drawn(plan: ContactPlan, parents: Parents) -> set[int]:
    """Numbers of the subgoals that are drawn."""
    kinds = {s.number: s.kind for s in plan.subgoals}
    followed = {p for p in parents.values() if p is not None}
    before_y = {
        p for n, p in parents.items() if kinds[n] == Y and p is not None and kinds.get(p) == X_END
    }
    return {
        n for n, kind in kinds.items() if n not in before_y and not (kind == Y and n in followed)
    }


def _nearest(parents: Parents, number: int | None, shown: Collection[int]) -> int | None:
    """The first of `number` and its ancestors that is shown, or None."""
    while number is not None and number not in shown:
        number = parents[number]
    return number


def _children(parents: Parents) -> Children:
    """Of each subgoal, and of None those without a parent, in the order of their numbers."""
    children: Children = {None: []}
    for number in sorted(parents):
        children.setdefault(number, [])
        children.setdefault(parents[number], []).append(number)
    return children


def _nearest_to_route(
    up: Parents, children: Children, route: Collection[int], limit: int
) -> set[int]:
    """The route and at most so many subgoals, breadth first from it."""
    kept: set[int] = set()
    queue = deque(route or children[None][:1])
    while queue and (len(kept) < limit or queue[0] in route):
        number = queue.popleft()
        if number in kept:
            continue
        if up[number] is None or up[number] in kept:
            kept.add(number)
            queue.extend(children[number])
    return kept


def _place(children: Children, route: Collection[int]) -> dict[int, tuple[int, int]]:
    """(column, row) of each: a column behind its parent's, not above it, and below those that were
    placed in its column before.
    """
    cells: dict[int, tuple[int, int]] = {}
    free: Counter[int] = Counter()  # row of each column from which on nothing has been placed
    stack = [(n, 0, 0) for n in reversed(children[None])]
    while stack:
        number, column, row = stack.pop()
        row = max(row, free[column])
        free[column], cells[number] = row + 1, (column, row)
        following = sorted(children[number], key=lambda n: (n not in route, n))
        stack.extend((n, column + 1, row) for n in reversed(following))
    return cells
