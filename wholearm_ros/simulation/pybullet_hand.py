"""The hand's stand-in in PyBullet: planar rigid bodies, two motors, joint readings. The only file that imports pybullet.

The support plane's (x, y) is PyBullet's (X, Z), so a counter-clockwise turn is one about -Y. The object is the last
link of a chain of two prismatic joints and a revolute one, the first two links without mass: planar exactly, and
nothing else holds it. No joint has a motor constraint, damping or friction.

PyBullet's world is enlarged SCALE times (lengths; forces, torques and inertias accordingly). Convex hulls carry a
collision margin of 1 mm that rounds their corners; enlarged, it is 0.1 mm of the real object, and so is the inset that
puts contacts at the true faces.
"""

import os
import sys
from typing import List, Optional, Tuple

import numpy as np

from wholearm_ros.errors import HardwareError
from wholearm_ros.model.hand import SIDES
from wholearm_ros.model.perturbation import NOMINAL, Perturbation
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.simulation.actuation import Drives, Encoders
from wholearm_ros.simulation.collision_shapes import finger_rectangle, inset, palm_slabs
from wholearm_ros.simulation.hand import ContactPoint
from wholearm_ros.simulation.suppress_stderr import quiet_stderr

with quiet_stderr():  # it prints its build time when imported
    import pybullet

SCALE = 10.0  # PyBullet lengths a metre
MARGIN = 0.001  # collision margin of a convex hull, PyBullet lengths
PHYSICS_RATE = 2000.0  # [Hz] at least; at 1000 contacts in a wedge sink in by a millimetre, and impacts come late
ITERATIONS = 100  # of the contact solver a step; 50 and a direct solver give the same motion
BREAKING = 0.005  # distance at which a kept contact point, and its old normal, is dropped, PyBullet lengths
# Half depths across the plane, PyBullet lengths; they carry no physics. The object is thinner than BREAKING: a contact found
# anywhere across it takes the place of the one that was kept. Else one stays, with the normal of when it was found.
OBJECT_DEPTH, HAND_DEPTH = 0.002, 0.2
OBJECT_GROUP, HAND_GROUP = (
    1,
    2,
)  # the object meets the hand; fingers and palm do not meet each other
_IDENTITY = [0.0, 0.0, 0.0, 1.0]
_CCW = [0.0, -1.0, 0.0]
_ROTATION = 2  # link of the object that carries its body


class PyBulletHand:
    """See HandBackend. scenario: as told to the planner; the truth, with the perturbation applied, is `.scenario`."""

    def __init__(
        self,
        scenario: Scenario,
        rate: float = 1000.0,
        perturbation: Optional[Perturbation] = None,
        view: bool = False,
    ):
        perturbation = perturbation or NOMINAL
        self.scenario = perturbation.applied(scenario)
        self.period = 1.0 / rate
        self._substeps = max(1, int(np.ceil(PHYSICS_RATE / rate - 1e-9)))
        self._client = _connected(view)
        self._engine(self.period / self._substeps)
        self._object = self._make_object()
        self._fingers = self._make_fingers()
        self._palm = self._make_palm()
        self._set_contact_laws(perturbation.friction)
        self._drives = Drives(self.scenario, perturbation, self.period / self._substeps)
        self._encoders = Encoders(perturbation)
        self.time = 0.0
        self._truth = self._reading = self._true_joints()

    # ------------------------------------------------------------------ the methods of HandBackend
    def reset(self, configuration: np.ndarray) -> None:
        x, y, turn, left, right = (float(v) for v in configuration)
        for joint, value in enumerate((x * SCALE, y * SCALE, turn)):
            pybullet.resetJointState(self._object, joint, value, 0.0, physicsClientId=self._client)
        for joint, value in enumerate((left, right)):
            pybullet.resetJointState(self._fingers, joint, value, 0.0, physicsClientId=self._client)
        pybullet.performCollisionDetection(physicsClientId=self._client)
        self.time = 0.0
        self._truth = self._true_joints()
        self._drives.reset(self._truth[0])
        self._encoders.reset()
        self._reading = self._encoders.read(*self._truth)

    def step(self, efforts: Optional[np.ndarray]) -> None:
        for _ in range(self._substeps):
            torques = self._drives.torques(efforts, *self._truth) * SCALE**2
            pybullet.setJointMotorControlArray(
                self._fingers,
                [0, 1],
                pybullet.TORQUE_CONTROL,
                forces=torques.tolist(),
                physicsClientId=self._client,
            )
            pybullet.stepSimulation(physicsClientId=self._client)
            self._truth = self._true_joints()
        self.time += self.period
        self._reading = self._encoders.read(*self._truth)

    def joints(self) -> Tuple[np.ndarray, np.ndarray]:
        return self._reading

    def efforts(self) -> np.ndarray:
        return self._drives.asked

    def object_pose(self) -> np.ndarray:
        x, y, turn = self._object_joints(0)
        return np.array([x / SCALE, y / SCALE, turn])

    def object_velocity(self) -> np.ndarray:
        x, y, turn = self._object_joints(1)
        return np.array([x / SCALE, y / SCALE, turn])

    def contacts(self) -> List[ContactPoint]:
        found = []
        for point in pybullet.getContactPoints(bodyA=self._object, physicsClientId=self._client):
            if point[2] == self._object:
                continue
            other = 'palm' if point[2] != self._fingers else SIDES[point[4]]
            where = np.array([point[5][0], point[5][2]]) / SCALE
            normal = np.array([point[7][0], point[7][2]])
            found.append(ContactPoint(other, where, normal, point[8] / SCALE, point[9] / SCALE))
        return _merged(found)

    def disconnect(self) -> None:
        if self._client is not None:
            pybullet.disconnect(physicsClientId=self._client)
            self._client = None

    # ------------------------------------------------------------------ state
    def _object_joints(self, part: int) -> list:
        states = pybullet.getJointStates(self._object, [0, 1, 2], physicsClientId=self._client)
        return [state[part] for state in states]

    def _true_joints(self) -> Tuple[np.ndarray, np.ndarray]:
        left, right = pybullet.getJointStates(self._fingers, [0, 1], physicsClientId=self._client)
        return np.array([left[0], right[0]]), np.array([left[1], right[1]])

    # ------------------------------------------------------------------ bodies
    def _engine(self, dt: float) -> None:
        gravity = self.scenario.gravity.in_plane * SCALE
        pybullet.setGravity(0.0, 0.0, -gravity, physicsClientId=self._client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=dt,
            numSolverIterations=ITERATIONS,
            numSubSteps=0,
            contactBreakingThreshold=BREAKING,
            deterministicOverlappingPairs=1,
            physicsClientId=self._client,
        )

    def _prism(self, polygon: np.ndarray, depth: float) -> int:
        flat = inset(np.asarray(polygon) * SCALE, MARGIN)
        corners = [[x, side, z] for x, z in flat for side in (-depth, depth)]
        return pybullet.createCollisionShape(
            pybullet.GEOM_MESH, vertices=corners, physicsClientId=self._client
        )

    def _make_object(self) -> int:
        thing = self.scenario.object
        shape = self._prism(thing.polygon.vertices_about_centroid, OBJECT_DEPTH)
        body = self._chain(
            masses=[0.0, 0.0, thing.mass],
            shapes=[-1, -1, shape],
            positions=[[0.0] * 3] * 3,
            centres=[[0.0] * 3] * 3,
            parents=[0, 1, 2],
            axes=[[1, 0, 0], [0, 0, 1], _CCW],
            kinds=[pybullet.JOINT_PRISMATIC, pybullet.JOINT_PRISMATIC, pybullet.JOINT_REVOLUTE],
        )
        self._set_inertia(body, _ROTATION, thing.inertia)
        return body

    def _make_fingers(self) -> int:
        fingers = (self.scenario.hand.left, self.scenario.hand.right)
        body = self._chain(
            masses=[f.mass for f in fingers],
            shapes=[self._prism(finger_rectangle(f), HAND_DEPTH) for f in fingers],
            positions=[[f.axis[0] * SCALE, 0.0, f.axis[1] * SCALE] for f in fingers],
            centres=[[f.length / 2 * SCALE, 0.0, 0.0] for f in fingers],
            parents=[0, 0],
            axes=[_CCW, _CCW],
            kinds=[pybullet.JOINT_REVOLUTE] * 2,
        )
        for joint, f in enumerate(fingers):
            self._set_inertia(
                body, joint, f.inertia - f.mass * (f.length / 2) ** 2
            )  # about its centre, rotor included
            low, high = f.angle_limits
            pybullet.changeDynamics(
                body, joint, jointLowerLimit=low, jointUpperLimit=high, physicsClientId=self._client
            )
        return body

    def _make_palm(self) -> list:
        shapes = [self._prism(slab, HAND_DEPTH) for slab in palm_slabs(self.scenario.palm)]
        return [
            pybullet.createMultiBody(0.0, shape, physicsClientId=self._client) for shape in shapes
        ]

    def _chain(self, masses, shapes, positions, centres, parents, axes, kinds) -> int:
        n = len(masses)
        return pybullet.createMultiBody(
            baseMass=0.0,
            linkMasses=masses,
            linkCollisionShapeIndices=shapes,
            linkVisualShapeIndices=[-1] * n,
            linkPositions=positions,
            linkOrientations=[_IDENTITY] * n,
            linkInertialFramePositions=centres,
            linkInertialFrameOrientations=[_IDENTITY] * n,
            linkParentIndices=parents,
            linkJointTypes=kinds,
            linkJointAxis=axes,
            physicsClientId=self._client,
        )

    def _set_inertia(self, body: int, link: int, inertia: float) -> None:
        """inertia [kg m²] about the link's centre, across the plane; the other two axes never turn."""
        pybullet.changeDynamics(
            body, link, localInertiaDiagonal=[inertia * SCALE**2] * 3, physicsClientId=self._client
        )

    def _set_contact_laws(self, friction: float) -> None:
        """Friction of a pair is the product of both; no restitution, no damping anywhere."""
        for body in [self._object, self._fingers, *self._palm]:
            own = friction if body == self._object else 1.0
            for link in range(-1, pybullet.getNumJoints(body, physicsClientId=self._client)):
                pybullet.changeDynamics(
                    body,
                    link,
                    lateralFriction=own,
                    restitution=0.0,
                    linearDamping=0.0,
                    angularDamping=0.0,
                    jointDamping=0.0,
                    physicsClientId=self._client,
                )
                group, mask = (
                    (OBJECT_GROUP, HAND_GROUP)
                    if body == self._object
                    else (HAND_GROUP, OBJECT_GROUP)
                )
                pybullet.setCollisionFilterGroupMask(
                    body, link, group, mask, physicsClientId=self._client
                )
                if link >= 0:
                    pybullet.setJointMotorControl2(
                        body,
                        link,
                        pybullet.VELOCITY_CONTROL,
                        force=0.0,
                        physicsClientId=self._client,
                    )


def _connected(view: bool) -> int:
    """A world of its own. PyBullet ends the whole process when there is no screen for its window: refused before that."""
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
    return client


def _merged(points: List[ContactPoint], same: float = 1e-4) -> List[ContactPoint]:
    """Points of one pair within `same` [m] are one: the engine reports both ends of a line across the plane."""
    merged: List[ContactPoint] = []
    for p in points:
        for k, q in enumerate(merged):
            if q.other == p.other and np.linalg.norm(q.point - p.point) < same:
                merged[k] = ContactPoint(
                    q.other, q.point, q.normal, min(q.gap, p.gap), q.force + p.force
                )
                break
        else:
            merged.append(p)
    return merged
