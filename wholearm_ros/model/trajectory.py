"""A manipulation trajectory: what both fingers shall do over time, in which mode, and why it is
expected to work.
"""

import json
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from wholearm_ros.errors import DocumentError
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.band import Band
from wholearm_ros.model.hand import JOINT_NAMES, SIDES
from wholearm_ros.model.interpolation import hermite
from wholearm_ros.model.modes import PLANNED_MODES
from wholearm_ros.model.probe import Probe

FORMAT = 'wholearm-trajectory/2'
READABLE = ('wholearm-trajectory/1', FORMAT)  # the first has no probe


@dataclass(frozen=True)
class Segment:
    """A stretch of time [s] in one mode, one contact state and one assignment of control modes
    (III-B.4).

    contacts: names of the closed contact pairs; velocity_finger: LEFT or RIGHT, the other one is
    torque-controlled; degree_of_constraint, conditioning: of that assignment and (second) of the
    opposite one.
    """

    start: float
    end: float
    mode: str
    velocity_finger: int
    contacts: tuple[str, ...] = ()
    degree_of_constraint: tuple[int, ...] = ()
    conditioning: tuple[float, ...] = ()

    @property
    def torque_finger(self) -> int:
        """LEFT or RIGHT: the other one."""
        return 1 - self.velocity_finger

    def to_dict(self) -> dict[str, Any]:
        """For documents."""
        return {
            'start': self.start,
            'end': self.end,
            'mode': self.mode,
            'velocity_finger': SIDES[self.velocity_finger],
            'contacts': list(self.contacts),
            'degree_of_constraint': list(self.degree_of_constraint),
            'conditioning': list(self.conditioning),
        }

    @classmethod
    def from_dict(cls, d: dict[str, Any]) -> 'Segment':
        """Raises one of DAMAGES of `plan.py` when something is missing or of the wrong kind."""
        return cls(
            float(d['start']),
            float(d['end']),
            d['mode'],
            SIDES.index(d['velocity_finger']),
            tuple(d['contacts']),
            tuple(d['degree_of_constraint']),
            tuple(d['conditioning']),
        )


@dataclass(frozen=True)
class Sample:
    """The trajectory at one instant: angles, velocities, efforts are (2,) [rad, rad/s, N m], left
    then right.
    """

    segment: Segment
    angles: np.ndarray
    velocities: np.ndarray
    efforts: np.ndarray


@dataclass(frozen=True, eq=False)
class ManipulationTrajectory:
    """Sampled every `period` [s] from t = 0.

    angles, velocities, efforts: (m, 2) [rad, rad/s, N m], left then right; the effort of the
    velocity-controlled finger is its equilibrium torque (feed-forward), that of the
    torque-controlled finger its command. torque_ranges: (m, 2) [N m], (τ_min, τ_max) of the
    torque-controlled finger, NaN where there is none. poses: (m, 3) planned object pose, centroid
    [m] and rotation [rad]. segments: in order, without gaps, from 0 to the last sample's time.
    probe: the motion that feels what came of it, None for none. band: of the finger angles in the
    rollouts that ended at the goal, None when it is not known.
    courses, strayed: (k, r, 2) [rad] of the plan, see ContactPlan; no part of the document.
    """

    plan_id: str
    period: float
    angles: np.ndarray
    velocities: np.ndarray
    efforts: np.ndarray
    torque_ranges: np.ndarray
    poses: np.ndarray
    segments: tuple[Segment, ...]
    transitions: tuple[dict[str, Any], ...] = ()
    verification: dict[str, Any] | None = None
    notes: dict[str, Any] = field(default_factory=dict)
    probe: Probe | None = None
    band: Band | None = None
    courses: np.ndarray | None = None
    strayed: np.ndarray | None = None

    def __post_init__(self) -> None:
        for name, width in (('angles', 2), ('velocities', 2), ('efforts', 2), ('poses', 3)):
            object.__setattr__(self, name, readonly(getattr(self, name), (-1, width)))
        ranges = np.array(self.torque_ranges, dtype=float).reshape(-1, 2)
        ranges.setflags(write=False)
        object.__setattr__(self, 'torque_ranges', ranges)

    @property
    def times(self) -> np.ndarray:
        """(m,) times of the samples [s]."""
        times: np.ndarray = self.period * np.arange(len(self.angles))
        return times

    @property
    def duration(self) -> float:
        """Time of the last sample [s]."""
        return self.period * (len(self.angles) - 1)

    def segment_at(self, t: float) -> Segment:
        """The segment in which `t` [s] lies; the first before 0, the last after the end."""
        for segment in self.segments:
            if t < segment.end:
                return segment
        return self.segments[-1]

    def sample(self, t: float) -> Sample:
        """The setpoints at `t` [s], held at both ends: angles by cubic Hermite, the rest linear."""
        last = len(self.angles) - 1
        s = min(max(t / self.period, 0.0), float(last))
        i = min(int(s), last - 1)
        u = s - i
        v0, v1 = self.velocities[i], self.velocities[i + 1]
        angles = hermite(self.angles[i], self.angles[i + 1], v0, v1, self.period, u)
        held = t < 0.0 or t > self.duration
        velocities = np.zeros(2) if held else (1 - u) * v0 + u * v1
        efforts = (1 - u) * self.efforts[i] + u * self.efforts[i + 1]
        return Sample(self.segment_at(t), angles, velocities, efforts)

    def time_in_modes(self) -> dict[str, float]:
        """Seconds in each mode."""
        total = dict.fromkeys(PLANNED_MODES, 0.0)
        for s in self.segments:
            total[s.mode] += s.end - s.start
        return total

    def to_json(self) -> str:
        """The document `wholearm-trajectory/2`."""
        return json.dumps(
            {
                'format': FORMAT,
                'plan_id': self.plan_id,
                'joint_names': list(JOINT_NAMES),
                'period': self.period,
                'angles': self.angles.tolist(),
                'velocities': self.velocities.tolist(),
                'efforts': self.efforts.tolist(),
                'torque_ranges': [
                    [None if np.isnan(v) else v for v in row] for row in self.torque_ranges.tolist()
                ],
                'poses': self.poses.tolist(),
                'segments': [segment.to_dict() for segment in self.segments],
                'transitions': list(self.transitions),
                'verification': self.verification,
                'notes': self.notes,
                'probe': None if self.probe is None else self.probe.to_dict(),
                **({} if self.band is None else {'band': self.band.to_dict()}),
            },
            separators=(',', ':'),
            allow_nan=False,
        )

    @classmethod
    def from_json(cls, text: str) -> 'ManipulationTrajectory':
        """Raises DocumentError when `text` is damaged, of another format, or inconsistent in
        itself.
        """
        try:
            d = json.loads(text)
            if d.get('format') not in READABLE:
                raise DocumentError(
                    f'trajectory document: format is {d.get("format")!r}; allowed: {READABLE}'
                )
            segments = tuple(map(Segment.from_dict, d['segments']))
            ranges = np.array(
                [[np.nan if v is None else float(v) for v in row] for row in d['torque_ranges']]
            )
            result = cls(
                d['plan_id'],
                float(d['period']),
                d['angles'],
                d['velocities'],
                d['efforts'],
                ranges,
                d['poses'],
                segments,
                tuple(d['transitions']),
                d['verification'],
                d['notes'],
                None
                if d['format'] != FORMAT or d['probe'] is None
                else Probe.from_dict(d['probe']),
                None if d.get('band') is None else Band.from_dict(d['band']),
            )
        except DocumentError:
            raise
        except (
            ValueError,
            OverflowError,
            TypeError,
            KeyError,
            AttributeError,
            RecursionError,
        ) as error:
            raise DocumentError(
                f'trajectory document is damaged: {type(error).__name__}: {error}'
            ) from error
        result._check()
        return result

    def _check(self) -> None:
        m = len(self.angles)
        if not (
            isinstance(self.plan_id, str)
            and np.isfinite(self.period)
            and self.period > 0.0
            and m >= 2
            and {len(self.velocities), len(self.efforts), len(self.torque_ranges), len(self.poses)}
            == {m}
        ):
            raise DocumentError(
                'trajectory document: needs period > 0 and at least two samples, the same '
                'number everywhere'
            )
        ends = [0.0]
        for s in self.segments:
            if s.mode not in PLANNED_MODES or abs(s.start - ends[-1]) > 1e-9 or not s.end > s.start:
                raise DocumentError(
                    f'trajectory document: segment {s.mode!r} from {s.start} to {s.end}; '
                    f'allowed: one of {PLANNED_MODES}, following on the one before'
                )
            ends.append(s.end)
        if len(ends) < 2 or abs(ends[-1] - self.duration) > 1e-6:
            raise DocumentError(
                f'trajectory document: segments end at {ends[-1]}, samples at {self.duration}'
            )
