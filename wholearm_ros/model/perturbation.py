"""Perturbations: how the true object, friction, motors and encoders differ from nominal."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from wholearm_ros.errors import ScenarioError
from wholearm_ros.model.arrays import readonly
from wholearm_ros.model.hand_errors import HandErrors, draw_hand_errors
from wholearm_ros.model.polygon import Polygon
from wholearm_ros.model.scenario import ManipulatedObject, Scenario

# At level 1; each is multiplied by the level.
MASS_SHARE = 0.05  # mass is off by up to this share
VERTEX_OFFSET = 0.0005  # [m] each coordinate of each vertex is off by up to this
MAX_FRICTION = 0.05  # coefficient of friction of the object against everything
MAX_DELAY = 0.003  # [s] from a command to the motor
TORQUE_SHARE = 0.03  # each motor's torque is off by up to this share
ENCODER_NOISE = 0.0002  # [rad] standard deviation of an angle reading
VELOCITY_NOISE = 0.02  # [rad/s] likewise of a velocity reading: a filtered derivative of the angle
MIN_TURN = 1e-3  # sine of the smallest turn that a perturbed polygon must keep at each vertex
MAX_TRIES = 1000
MAX_HALVINGS = 60


@dataclass(frozen=True, eq=False)
class Perturbation:
    """mass_factor; vertex_offsets: (n, 2) [m] or None; friction; actuation_delay [s];
    torque_factors: (2,), left then right; encoder_noise [rad], velocity_noise [rad/s]: standard
    deviations; noise_seed: of the readings; hand: the errors of the hand.
    """

    mass_factor: float = 1.0
    vertex_offsets: np.ndarray | None = None
    friction: float = 0.0
    actuation_delay: float = 0.0
    torque_factors: np.ndarray = field(default_factory=lambda: np.ones(2))
    encoder_noise: float = 0.0
    velocity_noise: float = 0.0
    noise_seed: int = 0
    hand: HandErrors = field(default_factory=HandErrors)

    def __post_init__(self) -> None:
        object.__setattr__(self, 'torque_factors', readonly(self.torque_factors, (2,)))
        if self.vertex_offsets is not None:
            object.__setattr__(self, 'vertex_offsets', readonly(self.vertex_offsets, (-1, 2)))

    def applied(self, scenario: Scenario) -> Scenario:
        """The true scenario: perturbed mass, shape and hand."""
        vertices = scenario.object.polygon.vertices
        if self.vertex_offsets is not None:
            vertices = vertices + self.vertex_offsets
        thing = ManipulatedObject(Polygon(vertices), scenario.object.mass * self.mass_factor)
        return self.hand.applied(replace(scenario, object=thing))

    def reseeded(self, seed: int) -> 'Perturbation':
        """The same perturbation with other encoder noise."""
        return replace(self, noise_seed=self.noise_seed + seed)

    def to_dict(self) -> dict[str, Any]:
        """For documents."""
        offsets = None if self.vertex_offsets is None else self.vertex_offsets.tolist()
        return {
            'mass_factor': self.mass_factor,
            'vertex_offsets': offsets,
            'friction': self.friction,
            'actuation_delay': self.actuation_delay,
            'torque_factors': self.torque_factors.tolist(),
            'encoder_noise': self.encoder_noise,
            'velocity_noise': self.velocity_noise,
            'noise_seed': self.noise_seed,
            'hand': self.hand.to_dict(),
        }

    @classmethod
    def from_dict(cls, told: dict[str, Any]) -> 'Perturbation':
        """The inverse of `to_dict`; raises TypeError or ValueError for anything else."""
        return cls(**{**told, 'hand': HandErrors(**told.get('hand', {}))})


NOMINAL = Perturbation()


def draw_perturbation(
    rng: np.random.Generator, level: float, scenario: Scenario, hand_errors: float = 0.0
) -> Perturbation:
    """One draw at `level` (0 is nominal, 1 as in the constants above), reproducible from the state
    of `rng`; the errors of the hand are drawn beside it, at the level `hand_errors`.

    Raises ScenarioError when no offsets keep the polygon convex.
    """
    drawn = NOMINAL if level == 0.0 else _draw_others(rng, level, scenario)
    if hand_errors == 0.0:
        return drawn
    return replace(drawn, hand=draw_hand_errors(rng.spawn(1)[0], hand_errors))


def _draw_others(rng: np.random.Generator, level: float, scenario: Scenario) -> Perturbation:
    """Of the object, its friction, the motors and the encoders' noise."""
    return Perturbation(
        mass_factor=1.0 + level * MASS_SHARE * rng.uniform(-1.0, 1.0),
        vertex_offsets=_draw_offsets(rng, level * VERTEX_OFFSET, scenario.object.polygon.vertices),
        friction=level * MAX_FRICTION * rng.uniform(),
        actuation_delay=level * MAX_DELAY * rng.uniform(),
        torque_factors=1.0 + level * TORQUE_SHARE * rng.uniform(-1.0, 1.0, size=2),
        encoder_noise=level * ENCODER_NOISE,
        velocity_noise=level * VELOCITY_NOISE,
        noise_seed=int(rng.integers(2**31)),
    )


def numbered_perturbation(
    level: float, number: int, scenario: Scenario, hand_errors: float = 0.0
) -> Perturbation:
    """The draw of that number at these levels, always the same."""
    return draw_perturbation(np.random.default_rng(number), level, scenario, hand_errors)


def _draw_offsets(rng: np.random.Generator, size: float, vertices: np.ndarray) -> np.ndarray:
    """(n, 2) [m], drawn again until the polygon stays convex. Where edges are so short, or corners
    so flat, that hardly any draw keeps it convex, the last draw is halved until it does.
    """
    for _ in range(MAX_TRIES):
        offsets = size * rng.uniform(-1.0, 1.0, size=vertices.shape)
        if _stays_convex(vertices + offsets):
            return offsets
    for _ in range(MAX_HALVINGS):
        offsets = 0.5 * offsets
        if _stays_convex(vertices + offsets):
            return offsets
    raise ScenarioError(
        'object.vertices: no offsets found that keep the polygon convex; '
        'allowed: a convex polygon with a corner at every vertex'
    )


def _stays_convex(vertices: np.ndarray) -> bool:
    edges = np.roll(vertices, -1, axis=0) - vertices
    following = np.roll(edges, -1, axis=0)
    cross = edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0]
    lengths = np.linalg.norm(edges, axis=1)
    return bool(np.all(cross > MIN_TURN * lengths * np.roll(lengths, -1)))
