"""The hand in MuJoCo: planar rigid bodies and two motors. The only file that imports mujoco.

The support plane's (x, y) is MuJoCo's (x, y) and gravity pulls along -y. The object's one body has
two slides and a hinge: planar exactly. No joint has damping, friction or a motor of MuJoCo's own.

In the plane two convex polygons touch at a vertex of one and an edge of the other, so that is what
collides here: a sphere of CORNER_RADIUS at every vertex of the object against the exact boxes of
fingers and palm, and one at every corner of fingers and palm against the exact prism of the object.
Parts of fingers that are no boxes are exact prisms, too.
MuJoCo's own contacts of box and prism are not used: for nearly parallel faces their normals are up
to 89 mrad off.
"""

from collections.abc import Iterable, Mapping

import mujoco
import numpy as np

from wholearm_ros.model.configuration import JOINTS, POSE, SIZE
from wholearm_ros.model.finger_shape import FingerShape, Rectangle
from wholearm_ros.model.hand import SIDES, Finger
from wholearm_ros.model.perturbation import NOMINAL, Perturbation
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.simulation.actuation import Drives, Encoders
from wholearm_ros.simulation.collision_shapes import PALM_DEPTH, palm_slabs
from wholearm_ros.simulation.contact_point import ContactPoint

PHYSICS_RATE = 4000.0  # [Hz] at least
CORNER_RADIUS = 1e-6  # [m] of the spheres that stand for vertices
# [m] of the distance of a corner from a prism. At MuJoCo's own, as large as the corners, a corner
# on a face was at times pushed off along the normal of no face at all.
CCD_TOLERANCE = 1e-10
HALF_DEPTH = 0.05  # [m] of every body across the plane; it carries no physics
# Contacts and end stops. `solref`: the shortest time constant that MuJoCo allows, in steps, and a
# damping ratio: the larger, the less of an impact's penetration comes back as speed. `solimp`: the
# stiffest that MuJoCo allows, at every depth.
TIME_CONSTANT_STEPS, DAMPING_RATIO, IMPEDANCE = 2.0, 4.0, 0.9999
# Friction. MuJoCo's cone makes a sliding contact rise by μ · (sliding speed) · (contact's time
# constant / this one): nothing when this one is long; but sliding also takes this long to come to
# its end.
FRICTION_TIME_CONSTANT = 0.01  # [s]
# Of friction over that of the normal: the larger, the less a sticking contact creeps.
FRICTION_IMPEDANCE = 100.0


class MuJoCoHand:
    """See HandBackend; `scenario` is the truth, with the perturbation applied.

    largest_penetration [m]: the deepest that a contact was found since the reset.
    """

    def __init__(
        self, scenario: Scenario, rate: float = 1000.0, perturbation: Perturbation | None = None
    ) -> None:
        perturbation = perturbation or NOMINAL
        self.scenario = perturbation.applied(scenario)
        self.period = 1.0 / rate
        self._substeps = max(1, int(np.ceil(PHYSICS_RATE / rate - 1e-9)))
        dt = self.period / self._substeps
        self._model = mujoco.MjModel.from_xml_string(
            model_text(self.scenario, perturbation.friction, dt)
        )
        self._data = mujoco.MjData(self._model)
        self._drives = Drives(self.scenario, perturbation, dt)
        self._encoders = Encoders(perturbation)
        self.reset(np.zeros(SIZE))

    def reset(self, configuration: np.ndarray) -> None:
        """At rest at `configuration` (5,) [m, m, rad, rad, rad]."""
        mujoco.mj_resetData(self._model, self._data)
        self._data.qpos[:] = configuration
        mujoco.mj_forward(self._model, self._data)
        self.time, self.largest_penetration = 0.0, 0.0
        self._drives.reset(self._data.qpos[JOINTS])
        self._encoders.reset()
        self._reading = self._encoders.read(self._data.qpos[JOINTS], self._data.qvel[JOINTS])

    def step(self, efforts: np.ndarray | None) -> None:
        """One period under motor torques (2,) [N m]; None: the fingers are held."""
        data = self._data
        for _ in range(self._substeps):
            angles, velocities = data.qpos[JOINTS], data.qvel[JOINTS]
            data.qfrc_applied[JOINTS] = self._drives.torques(efforts, angles, velocities)
            mujoco.mj_step(self._model, data)
            if data.ncon:
                self.largest_penetration = max(
                    self.largest_penetration, -float(data.contact.dist.min())
                )
        self.time += self.period
        self._reading = self._encoders.read(data.qpos[JOINTS], data.qvel[JOINTS])

    def joints(self) -> tuple[np.ndarray, np.ndarray]:
        """Measured angles (2,) [rad] and velocities (2,) [rad/s]."""
        return self._reading

    def efforts(self) -> np.ndarray:
        """(2,) [N m]: what the drives were last asked for."""
        return self._drives.asked

    def object_pose(self) -> np.ndarray:
        """(3,) [m, m, rad], the truth."""
        return np.array(self._data.qpos[POSE])

    def object_velocity(self) -> np.ndarray:
        """(3,) [m/s, m/s, rad/s], the truth."""
        return np.array(self._data.qvel[POSE])

    def contacts(self) -> list[ContactPoint]:
        """Those that carried a force in the last physics step, at the places where it began."""
        found, wrench = [], np.zeros(6)
        for k, contact in enumerate(self._data.contact[: self._data.ncon]):
            mujoco.mj_contactForce(self._model, self._data, k, wrench)
            bodies = [self._model.body(self._model.geom_bodyid[g]).name for g in contact.geom]
            towards = 1.0 if bodies[1] == 'object' else -1.0  # its normal is from the first geom
            found.append(
                ContactPoint(
                    bodies[0] if bodies[1] == 'object' else bodies[1],
                    contact.pos[:2].copy(),
                    towards * contact.frame[:2],
                    float(contact.dist),
                    float(wrench[0]),
                )
            )
        return found

    def disconnect(self) -> None:
        """Does nothing: there is nothing to free."""


# ---------------------------------------------------------------------- the model, as MuJoCo's XML
def model_text(scenario: Scenario, friction: float, dt: float) -> str:
    """MJCF of the scenario; dt [s]: the physics step.

    Contacts are frictionless (condim 1) when `friction` is 0.
    """
    thing = scenario.object
    outline = thing.polygon.vertices_about_centroid
    shapes = {side: getattr(scenario.hand, side).shape for side in SIDES}
    prisms = [_prism('prism', outline)] + [
        _prism(f'{side}_part{k}', part)
        for side, shape in shapes.items()
        if not isinstance(shape, Rectangle)
        for k, part in enumerate(shape.parts)
    ]
    solref = f'{TIME_CONSTANT_STEPS * dt} {DAMPING_RATIO}'
    solimp = f'{IMPEDANCE} {IMPEDANCE} 0.001 0.5 2'
    return f"""
<mujoco model="wholearm">
  <compiler angle="radian"/>
  <option timestep="{dt}" gravity="{_numbers([scenario.gravity.pull])} 0" integrator="Euler"
          cone="elliptic" impratio="{FRICTION_IMPEDANCE}"
          solver="Newton" jacobian="dense" iterations="100" tolerance="1e-12"
          ccd_tolerance="{CCD_TOLERANCE}">
    <flag multiccd="disable"/>
  </option>
  <default>
    <geom contype="0" conaffinity="0"/>
    <joint solreflimit="{solref}" solimplimit="{solimp}"
           solreffriction="{solref}" solimpfriction="{solimp}"/>
    <pair condim="{3 if friction else 1}" friction="{friction} {friction} 0 0 0"
          solref="{solref}" solreffriction="{FRICTION_TIME_CONSTANT} 1" solimp="{solimp}"/>
  </default>
  <asset>{''.join(prisms)}</asset>
  <worldbody>
    <body name="object">
      <joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 1 0"/>
      <joint type="hinge" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="{thing.mass}" diaginertia="{_numbers([[thing.inertia] * 3])}"/>
      <geom name="prism" type="mesh" mesh="prism"/>{_spheres('object', outline)}
    </body>
    {_palm(scenario)}{_finger('left', scenario.hand.left)}{_finger('right', scenario.hand.right)}
  </worldbody>
  <contact>{_pairs(len(outline), len(scenario.palm.vertices), shapes)}
  </contact>
</mujoco>"""


def _palm(scenario: Scenario) -> str:
    """A box under each segment, a corner at each vertex; a body without joints does not move."""
    boxes = []
    for k, (a_down, _, b, a) in enumerate(palm_slabs(scenario.palm)):
        centre, along = (a_down + b) / 2, b - a
        boxes.append(
            f"""
      <geom name="palm_box{k}" type="box" pos="{_numbers([[*centre, 0.0]])}"
            euler="0 0 {np.arctan2(along[1], along[0])}"
            size="{np.linalg.norm(along) / 2} {PALM_DEPTH / 2} {HALF_DEPTH}"/>"""
        )
    return f"""
    <body name="palm">{''.join(boxes)}{_spheres('palm', scenario.palm.vertices)}
    </body>"""


def _finger(name: str, finger: Finger) -> str:
    """Its inertia, about its centre, holds the rotor's."""
    x, y = finger.shape.centre
    parts = ''.join(_part(name, k, finger.shape) for k in range(len(finger.shape.parts)))
    return f"""
    <body name="{name}" pos="{_numbers([[*finger.axis, 0.0]])}">
      <joint type="hinge" axis="0 0 1" limited="true" range="{_numbers([finger.angle_limits])}"
             frictionloss="{finger.joint_friction}"/>
      <inertial pos="{_numbers([[x, y]])} 0" mass="{finger.mass}"
                diaginertia="{_numbers([[finger.inertia_about_centre] * 3])}"/>{parts}
      {_spheres(name, _corners(finger.shape))}
    </body>"""


def _part(name: str, k: int, shape: FingerShape) -> str:
    if isinstance(shape, Rectangle):
        half = shape.length / 2
        return f"""
      <geom name="{name}_part{k}" type="box" pos="{half} 0 0"
            size="{half} {shape.half_width} {HALF_DEPTH}"/>"""
    return f"""
      <geom name="{name}_part{k}" type="mesh" mesh="{name}_part{k}"/>"""


def _corners(shape: FingerShape) -> np.ndarray:
    """(c, 2) [m] where a finger can touch an edge of the object, or another part can."""
    return np.vstack(shape.parts)


def _prism(name: str, polygon: np.ndarray) -> str:
    corners = [(x, y, side) for x, y in polygon for side in (-HALF_DEPTH, HALF_DEPTH)]
    return f'<mesh name="{name}" vertex="{_numbers(corners)}"/>'


def _spheres(body: str, points: np.ndarray) -> str:
    return ''.join(
        f"""
      <geom name="{body}_corner{k}" type="sphere" size="{CORNER_RADIUS}"
            pos="{_numbers([[*p, 0.0]])}"/>"""
        for k, p in enumerate(points)
    )


def _pairs(object_vertices: int, palm_vertices: int, shapes: Mapping[str, FingerShape]) -> str:
    """Who meets whom: the object's vertices the solids of the hand, its corners the prism."""
    solids = [f'palm_box{k}' for k in range(palm_vertices - 1)]
    corners = [('prism', f'palm_corner{k}') for k in range(palm_vertices)]
    for side, shape in shapes.items():
        solids += [f'{side}_part{k}' for k in range(len(shape.parts))]
        corners += [('prism', f'{side}_corner{k}') for k in range(len(_corners(shape)))]
    vertices = [(f'object_corner{i}', solid) for i in range(object_vertices) for solid in solids]
    return ''.join(f'<pair geom1="{a}" geom2="{b}"/>' for a, b in vertices + corners)


def _numbers(rows: Iterable[Iterable[float]]) -> str:
    return ' '.join(repr(float(value)) for row in rows for value in row)
