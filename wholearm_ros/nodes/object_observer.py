"""Estimates the object's pose and contact state from the finger angles; receives no true pose."""

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from std_msgs.msg import String

from wholearm_ros.control.setpoints import Joints
from wholearm_ros.errors import WholeArmError
from wholearm_ros.estimation.feel import Feeler
from wholearm_ros.estimation.observer import Estimate, Observer
from wholearm_ros.model.modes import PLANNED_MODES
from wholearm_ros.model.trajectory import ManipulationTrajectory
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.common_parameters import SCENARIO, scenario_of
from wholearm_ros.ros.interface.joint_state_serialization import NANOSECONDS, read_joints
from wholearm_ros.ros.interface.messages import (
    estimate_message,
    status_message,
    to_joints,
    values_of,
)
from wholearm_ros.ros.interface.parameters import Declared
from wholearm_ros.ros.node.node import OK, WARN, Health, WholeArmNode
from wholearm_ros.ros.node.run import run_node
from wholearm_ros.ros.visualization.markers import estimate_markers

RATE = Declared('estimate_rate', 50.0, 'of estimates, by the newest joint states [Hz]', 1.0, 200.0)
DRAWN_EVERY = 5  # estimates


class ObjectObserver(WholeArmNode):
    """joint_states, trajectory, progress of the mode switcher → object_estimate, contact_state."""

    def __init__(self) -> None:
        super().__init__('object_observer', (SCENARIO, RATE))
        self.scenario = scenario_of(self.parameters)
        self.observer = Observer(Feeler(self.scenario))
        self.observer.resting(np.array([2.0, 1.0]))  # compiled before anything happens

        self.newest: bytes | None = None  # joint states as they came: few of them are read
        self.trajectory: ManipulationTrajectory | None = None
        self.progress: dict[str, str] = {}
        self.stamp, self.estimates, self.said = -1, 0, 'no joint states yet'

        self.palm = self.frame(channels.PALM_FRAME)
        self.estimate_topic = self.publisher(channels.OBJECT_ESTIMATE)
        self.state_topic = self.publisher(channels.CONTACT_STATE)
        self.markers = self.publisher(channels.MARKERS)
        self.listen(channels.JOINT_STATES, self.on_joints, channels.NEWEST_STATE, raw=True)
        self.subscription(channels.MANIPULATION_TRAJECTORY, self.on_trajectory)
        self.subscription(channels.PROGRESS, self.on_progress)
        self.every(1.0 / self.parameters.estimate_rate, self.guarded_estimate)

    def on_joints(self, message: bytes) -> None:
        """Kept as it is: reading every one of them would cost a tenth of a core."""
        self.newest = message

    def on_trajectory(self, message: String) -> None:
        """The trajectory that is followed from its start on."""
        self.trajectory = ManipulationTrajectory.from_json(message.data)

    def on_progress(self, message: DiagnosticStatus) -> None:
        """Of the mode switcher: when the trajectory's time is zero."""
        self.progress = values_of(message)

    def guarded_estimate(self) -> None:
        """By the newest joint states, if there are any that were not looked at."""
        message, self.newest = self.newest, None
        if message is None:
            return
        try:
            self.estimate(*to_joints(read_joints(message)))
        except WholeArmError as error:
            self.refuse(f'{channels.JOINT_STATES.name}: refused: {error}')

    def estimate(self, stamp: int, joints: Joints) -> None:
        """Publish what the joints at `stamp` [ns] say."""
        if stamp == self.stamp or not joints.finite:
            return
        self.stamp, self.estimates = stamp, self.estimates + 1
        found = self.explain(stamp, joints.angles)
        self.said = found.describe()
        level = WARN if found.best is None else OK
        name = self.get_fully_qualified_name()
        values = {'stamp': stamp, **found.to_dict()}
        self.state_topic.publish(status_message(name, level, self.said, values))
        if found.best is not None:
            deviations = self.observer.deviations(found.best)
            told = estimate_message(stamp, found.best.pose, deviations, self.palm)
            self.estimate_topic.publish(told)
        if self.estimates % DRAWN_EVERY == 0:
            pose = None if found.best is None else found.best.pose
            self.markers.publish(estimate_markers(self.scenario, pose, self.palm))

    def explain(self, stamp: int, angles: np.ndarray) -> Estimate:
        """By the plan while it is followed, by the edges of rest at the end and while probing."""
        trajectory, start = self.trajectory, self.progress.get('trajectory start')
        follows = (
            trajectory is not None
            and bool(start)
            and self.progress.get('mode') in PLANNED_MODES
            and self.progress.get('goal') == trajectory.plan_id
        )
        if trajectory is None or not follows:
            return self.observer.resting(angles)
        return self.observer.following(trajectory, (stamp - int(start or 0)) / NANOSECONDS, angles)

    def health(self) -> Health:
        """How many estimates there were."""
        return OK, self.said, {'estimates': self.estimates, 'stamp': self.stamp}


def main() -> None:
    """The executable."""
    run_node(ObjectObserver)


if __name__ == '__main__':
    main()
