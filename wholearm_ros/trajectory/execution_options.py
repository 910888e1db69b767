"""The choices of Phase 2: what a plan document's `execution` holds."""

from dataclasses import asdict, dataclass, fields
from typing import Any

from wholearm_ros.errors import DocumentError
from wholearm_ros.model.choices import Transition
from wholearm_ros.model.modes import DWELL, DYNAMIC
from wholearm_ros.model.plan import Leg

# The front finger is the one towards which the object turns: left when counter-clockwise.
AUTO, FRONT, REAR = Transition.auto.value, 'front', 'rear'


@dataclass(frozen=True)
class ExecutionOptions:
    """How Phase 2 executes a plan.

    torque_margin, caging_torque, extra_torque: τ_margin, τ_caging (an upper bound) and τ_extra of
    the paper [N m]; range_fraction: share of the torque range that the margin may use;
    transition: DWELL or DYNAMIC, where ranges do not overlap; dynamic_lead, dynamic_hold: how long
    before the transition the extra torque begins, and how long it is held after it [s];
    velocity_finger: FRONT or REAR for the whole plan, or AUTO (III-B.4, leg by leg);
    caging_finger: FRONT or REAR, which is velocity-controlled in a caging descent;
    holding_torque: with which the torque finger holds the object at the goal [N m];
    stops: whether the hand stops at every node of the route, also where it could move on;
    speed, acceleration: limits of every joint [rad/s, rad/s²]; slew: rate limit of the torque
    [N m/s]; settle: pause after a dwell [s]; period: of the samples [s].
    """

    torque_margin: float = 0.5
    range_fraction: float = 0.5
    caging_torque: float = 0.1
    extra_torque: float = 2.0
    transition: str = DWELL
    dynamic_lead: float = 0.08
    dynamic_hold: float = 0.04
    velocity_finger: str = AUTO
    caging_finger: str = FRONT
    holding_torque: float = 0.25
    stops: bool = False
    speed: float = 1.5
    acceleration: float = 12.0
    slew: float = 20.0
    settle: float = 0.06
    period: float = 0.004

    def to_dict(self) -> dict[str, Any]:
        """The fields by name, for documents."""
        return asdict(self)

    def of_leg(self, leg: Leg) -> 'ExecutionOptions':
        """For a leg: its `action` says what differs from the rest of the plan.

        Raises as `from_dict` does.
        """
        if leg.mode == DYNAMIC or not leg.action:
            return self
        return ExecutionOptions.from_dict({**self.to_dict(), **leg.action})

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> 'ExecutionOptions':
        """Raises DocumentError for an unknown name or a wrong kind of value."""
        known = {f.name: type(f.default) for f in fields(cls)}
        for name, value in values.items():
            if name not in known:
                raise DocumentError(f'execution: unknown key {name!r}; allowed: {", ".join(known)}')
            if not isinstance(value, known[name]) and not (
                known[name] is float and isinstance(value, int)
            ):
                raise DocumentError(
                    f'execution: {name} is {value!r}; allowed: a {known[name].__name__}'
                )
        options = cls(**values)
        for name, allowed in (
            ('transition', (DWELL, DYNAMIC)),
            ('velocity_finger', (AUTO, FRONT, REAR)),
            ('caging_finger', (FRONT, REAR)),
        ):
            if getattr(options, name) not in allowed:
                got = getattr(options, name)
                raise DocumentError(f'execution: {name} is {got!r}; allowed: {", ".join(allowed)}')
        return options
