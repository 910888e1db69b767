"""The hand in PyBullet: planar rigid bodies, two motors. The only file that imports pybullet.

The support plane's (x, y) is PyBullet's (X, Z), so a counter-clockwise turn is one about -Y. The
object is the last link of a chain of two prismatic joints and a revolute one, the first two links
without mass: planar exactly, and nothing else holds it. No joint has a motor constraint, damping or
friction.

PyBullet's world is enlarged SCALE times (lengths; forces, torques and inertias accordingly). Convex
hulls carry a collision margin of 1 mm that rounds their corners; enlarged, it is 0.1 mm of the real
object, and so is the inset that puts contacts at the true faces.
"""

import os
import sys
from functools import partial
from typing import Any, NamedTuple, Optional

import numpy as np

from wholearm_ros.errors import HardwareError
from wholearm_ros.model.hand import SIDES
from wholearm_ros.model.perturbation import NOMINAL, Perturbation
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.simulation.actuation import Drives, Encoders
from wholearm_ros.simulation.collision_shapes import inset, palm_slabs
from wholearm_ros.simulation.contact_point import ContactPoint, merged
from wholearm_ros.simulation.suppress_stderr import suppress_stderr

with suppress_stderr():  # it prints its build time when imported
    import pybullet

SCALE = 10.0  # PyBullet lengths a metre
MARGIN = 0.001  # collision margin of a convex hull, PyBullet lengths
# [Hz] at least; at 1000 contacts in a wedge sink in by a millimetre, and impacts come late.
PHYSICS_RATE = 2000.0
ITERATIONS = 100  # of the contact solver a step; 50 and a direct solver give the same motion
BREAKING = 0.005  # distance at which a kept contact point, and its old normal, is dropped
# Half depths across the plane, PyBullet lengths; they carry no physics. The object is thinner than
# BREAKING: a contact found anywhere across it takes the place of the one that was kept. Else one
# stays, with the normal of when it was found.
OBJECT_DEPTH, HAND_DEPTH = 0.002, 0.2
OBJECT_GROUP, HAND_GROUP = 1, 2  # the object meets the hand; fingers and palm do not meet
_CCW = (0.0, -1.0, 0.0)
_ROTATION = 2  # link of the object that carries its body
_NO_SHAPE = -1
_NO_TURN = (0.0, 0.0, 0.0, 1.0)  # quaternion


class _Link(NamedTuple):
    """A link of a chain, in PyBullet lengths. kind, axis: of the joint that it hangs on."""

    kind: int
    axis: tuple[float, float, float]
    parent: int  # 0 is the base
    mass: float = 0.0
    shape: int = _NO_SHAPE
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of mass, in its frame


class _World:
    """PyBullet's functions, each in the world `client`."""

    def __init__(self, client: int) -> None:
        self.client = client

    def __getattr__(self, name: str) -> Any:
        return partial(getattr(pybullet, name), physicsClientId=self.client)


class PyBulletHand:
    """See HandBackend; `scenario` is the truth, with the perturbation applied."""

    def __init__(
        self,
        scenario: Scenario,
        rate: float = 1000.0,
        perturbation: Optional[Perturbation] = None,
        view: bool = False,
    ) -> None:
        """scenario: as planned. Raises HardwareError when there is no further world."""
        perturbation = perturbation or NOMINAL
        self.scenario = perturbation.applied(scenario)
        self.period = 1.0 / rate
        substeps = max(1, int(np.ceil(PHYSICS_RATE / rate - 1e-9)))
        self._substeps = substeps
        self._bullet: Any = _connected(view)
        self._engine(self.period / substeps)
        self._object = self._make_object()
        self._fingers = self._make_fingers()
        self._palm = self._make_palm()
        self._set_contact_laws(perturbation.friction)
        self._drives = Drives(self.scenario, perturbation, self.period / substeps)
        self._encoders = Encoders(perturbation)
        self.time = 0.0
        self._truth = self._reading = self._true_joints()

    def reset(self, configuration: np.ndarray) -> None:
        """At rest at `configuration` (5,) [m, m, rad, rad, rad]."""
        x, y, turn, left, right = (float(v) for v in configuration)
        for joint, value in enumerate((x * SCALE, y * SCALE, turn)):
            self._bullet.resetJointState(self._object, joint, value, 0.0)
        for joint, value in zip(self._joints, (left, right)):
            self._bullet.resetJointState(self._fingers, joint, value, 0.0)
        self._bullet.performCollisionDetection()
        self.time = 0.0
        self._truth = self._true_joints()
        self._drives.reset(self._truth[0])
        self._encoders.reset()
        self._reading = self._encoders.read(*self._truth)

    def step(self, efforts: Optional[np.ndarray]) -> None:
        """One period under motor torques (2,) [N m]; None: the fingers are held."""
        for _ in range(self._substeps):
            torques = self._drives.torques(efforts, *self._truth) * SCALE**2
            self._bullet.setJointMotorControlArray(
                self._fingers, self._joints, pybullet.TORQUE_CONTROL, forces=torques.tolist()
            )
            self._bullet.stepSimulation()
            self._truth = self._true_joints()
        self.time += self.period
        self._reading = self._encoders.read(*self._truth)

    def joints(self) -> tuple[np.ndarray, np.ndarray]:
        """Measured angles (2,) [rad] and velocities (2,) [rad/s]."""
        return self._reading

    def efforts(self) -> np.ndarray:
        """(2,) [N m]: what the drives were last asked for."""
        return self._drives.asked

    def object_pose(self) -> np.ndarray:
        """(3,) [m, m, rad], the truth."""
        return self._object_joints(0)

    def object_velocity(self) -> np.ndarray:
        """(3,) [m/s, m/s, rad/s], the truth."""
        return self._object_joints(1)

    def contacts(self) -> list[ContactPoint]:
        """The object's contacts; both ends of a line of contact across the plane as one."""
        found = []
        for point in self._bullet.getContactPoints(bodyA=self._object):
            if point[2] == self._object:
                continue
            other = 'palm' if point[2] != self._fingers else SIDES[self._sides[point[4]]]
            where = np.array([point[5][0], point[5][2]]) / SCALE
            normal = np.array([point[7][0], point[7][2]])
            found.append(ContactPoint(other, where, normal, point[8] / SCALE, point[9] / SCALE))
        return merged(found)

    def disconnect(self) -> None:
        """Frees PyBullet's world; may be called twice."""
        if self._bullet is not None:
            self._bullet.disconnect()
            self._bullet = None

    def _object_joints(self, part: int) -> np.ndarray:
        """(3,): positions (part 0) or velocities (part 1) along x, y and about the centroid."""
        x, y, turn = (s[part] for s in self._bullet.getJointStates(self._object, [0, 1, 2]))
        return np.array([x / SCALE, y / SCALE, turn])

    def _true_joints(self) -> tuple[np.ndarray, np.ndarray]:
        left, right = self._bullet.getJointStates(self._fingers, self._joints)
        return np.array([left[0], right[0]]), np.array([left[1], right[1]])

    def _engine(self, dt: float) -> None:
        x, y = self.scenario.gravity.pull * SCALE
        self._bullet.setGravity(x, 0.0, y)
        self._bullet.setPhysicsEngineParameter(
            fixedTimeStep=dt,
            numSolverIterations=ITERATIONS,
            numSubSteps=0,
            contactBreakingThreshold=BREAKING,
            deterministicOverlappingPairs=1,
        )

    def _prism(self, polygon: np.ndarray, depth: float) -> int:
        flat = inset(np.asarray(polygon) * SCALE, MARGIN)
        corners = [[x, side, z] for x, z in flat for side in (-depth, depth)]
        return int(self._bullet.createCollisionShape(pybullet.GEOM_MESH, vertices=corners))

    def _make_object(self) -> int:
        thing = self.scenario.object
        shape = self._prism(thing.polygon.vertices_about_centroid, OBJECT_DEPTH)
        body = self._chain(
            [
                _Link(pybullet.JOINT_PRISMATIC, (1.0, 0.0, 0.0), parent=0),
                _Link(pybullet.JOINT_PRISMATIC, (0.0, 0.0, 1.0), parent=1),
                _Link(pybullet.JOINT_REVOLUTE, _CCW, parent=2, mass=thing.mass, shape=shape),
            ]
        )
        self._set_inertia(body, _ROTATION, thing.inertia)
        return body

    def _make_fingers(self) -> int:
        """Both fingers are links of one body; further parts are fixed to them, without mass."""
        fingers = (self.scenario.hand.left, self.scenario.hand.right)
        links: list[_Link] = []
        self._sides: list[int] = []  # LEFT or RIGHT of each link
        self._joints: list[int] = []  # left then right: the link that turns
        for side, f in enumerate(fingers):
            x, y = f.shape.centre * SCALE
            self._joints.append(len(links))
            links.append(
                _Link(
                    pybullet.JOINT_REVOLUTE,
                    _CCW,
                    parent=0,
                    mass=f.mass,
                    shape=self._prism(f.shape.parts[0], HAND_DEPTH),
                    position=(f.axis[0] * SCALE, 0.0, f.axis[1] * SCALE),
                    centre=(x, 0.0, y),
                )
            )
            for part in f.shape.parts[1:]:
                shape, parent = self._prism(part, HAND_DEPTH), self._joints[side] + 1
                links.append(_Link(pybullet.JOINT_FIXED, _CCW, parent, shape=shape))
            self._sides += [side] * len(f.shape.parts)
        body = self._chain(links)
        for joint, f in zip(self._joints, fingers):
            self._set_inertia(body, joint, f.inertia_about_centre)
            low, high = f.angle_limits
            self._bullet.changeDynamics(body, joint, jointLowerLimit=low, jointUpperLimit=high)
        return body

    def _make_palm(self) -> list[int]:
        shapes = [self._prism(slab, HAND_DEPTH) for slab in palm_slabs(self.scenario.palm)]
        return [self._bullet.createMultiBody(0.0, shape) for shape in shapes]

    def _chain(self, links: list[_Link]) -> int:
        """A body whose base is fixed to the world."""
        n = len(links)
        body = self._bullet.createMultiBody(
            baseMass=0.0,
            linkMasses=[link.mass for link in links],
            linkCollisionShapeIndices=[link.shape for link in links],
            linkVisualShapeIndices=[_NO_SHAPE] * n,
            linkPositions=[link.position for link in links],
            linkOrientations=[_NO_TURN] * n,
            linkInertialFramePositions=[link.centre for link in links],
            linkInertialFrameOrientations=[_NO_TURN] * n,
            linkParentIndices=[link.parent for link in links],
            linkJointTypes=[link.kind for link in links],
            linkJointAxis=[link.axis for link in links],
        )
        return int(body)

    def _set_inertia(self, body: int, link: int, inertia: float) -> None:
        """inertia [kg m²] about the link's centre, across the plane; the others never act."""
        diagonal = [inertia * SCALE**2] * 3
        self._bullet.changeDynamics(body, link, localInertiaDiagonal=diagonal)

    def _set_contact_laws(self, friction: float) -> None:
        """Friction of a pair is the product of both; no restitution, no damping anywhere."""
        laws = dict.fromkeys(
            ('restitution', 'linearDamping', 'angularDamping', 'jointDamping'), 0.0
        )
        for body in [self._object, self._fingers, *self._palm]:
            of_object = body == self._object
            own = friction if of_object else 1.0
            groups = (OBJECT_GROUP, HAND_GROUP) if of_object else (HAND_GROUP, OBJECT_GROUP)
            for link in range(-1, self._bullet.getNumJoints(body)):
                self._bullet.changeDynamics(body, link, lateralFriction=own, **laws)
                self._bullet.setCollisionFilterGroupMask(body, link, *groups)
                if link >= 0:
                    kind, force = pybullet.VELOCITY_CONTROL, 0.0  # a motor that brakes is friction
                    if body == self._fingers and link in self._joints:
                        force = self.scenario.hand[self._sides[link]].joint_friction * SCALE**2
                    self._bullet.setJointMotorControl2(body, link, kind, force=force)


def _connected(view: bool) -> _World:
    """A world of its own, refused where PyBullet would end the process: no screen for a window."""
    if view and sys.platform.startswith('linux') and not os.environ.get('DISPLAY'):
        raise HardwareError(
            'view: got no screen (DISPLAY is not set); allowed: a machine with a screen, or no view'
        )
    client = pybullet.connect(pybullet.GUI if view else pybullet.DIRECT)
    if client < 0:
        raise HardwareError(
            'PyBullet gives no further world (it has a limit for one process); '
            'allowed: disconnect hands that are not used any more'
        )
    return _World(client)
