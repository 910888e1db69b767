"""Plans routes of contact states: of the scenario as configured, or between two object poses."""

import json
import threading
import traceback
from collections.abc import Callable
from dataclasses import replace
from typing import Any, Optional

import numpy as np
from diagnostic_msgs.msg import DiagnosticStatus
from nav_msgs.srv import GetPlan
from rclpy.executors import SingleThreadedExecutor
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import Trigger

from wholearm_ros.errors import WholeArmError
from wholearm_ros.launcher.map_maker import MapMaker
from wholearm_ros.mechanics.contacts import close_finger
from wholearm_ros.mechanics.world import build_world
from wholearm_ros.model.choices import Search, Transition, values
from wholearm_ros.model.hand import LEFT, RIGHT
from wholearm_ros.model.outcomes import AT_GOAL, PROBED
from wholearm_ros.model.plan import ContactPlan
from wholearm_ros.model.scenario import GoalAtPose, GoalOnEdge, Scenario, StartAtPose
from wholearm_ros.model.scenario_file import parse_scenario, scenario_to_dict
from wholearm_ros.model.start_checks import floating
from wholearm_ros.planner.legs import LegPlanner
from wholearm_ros.planner.map_store import MapStore
from wholearm_ros.planner.request import PlanRequest, PlanResult
from wholearm_ros.planner.warm import warm
from wholearm_ros.ros.interface import channels
from wholearm_ros.ros.interface.common_parameters import SCENARIO, scenario_of
from wholearm_ros.ros.interface.joint_state_serialization import MessageError
from wholearm_ros.ros.interface.messages import (
    PLANNER_BUSY,
    pose_message,
    status_message,
    to_planar,
    values_of,
)
from wholearm_ros.ros.interface.parameters import Declared
from wholearm_ros.ros.node.node import OK, WARN, Health, WholeArmNode
from wholearm_ros.ros.node.run import run_node
from wholearm_ros.ros.visualization.markers import map_markers

DECLARED = (
    replace(SCENARIO, read_only=False),
    Declared(
        'seed',
        0,
        'of everything drawn at random; the same seed gives the same plan',
        0,
        2**31 - 1,
        read_only=False,
    ),
    Declared(
        'search',
        PlanRequest.search,
        "best: widest margins first; random: the paper's",
        choices=values(Search),
        read_only=False,
    ),
    Declared(
        'transition',
        PlanRequest.transition,
        'how torque ranges that do not overlap are crossed',
        choices=values(Transition),
        read_only=False,
    ),
    Declared(
        'time_budget',
        PlanRequest.time_budget,
        'after which no further candidate is begun [s]',
        0.0,
        3600.0,
        read_only=False,
    ),
    Declared(
        'min_success',
        PlanRequest.min_success,
        'least lower bound of the success rate with which a plan is given',
        0.0,
        1.0,
        read_only=False,
    ),
    Declared(
        'hand_errors',
        PlanRequest.hand_errors,
        'level of the errors of the hand in the samples of search and certificate',
        0.0,
        10.0,
        read_only=False,
    ),
    Declared(
        'map_jobs',
        0,
        'processes that make the face map of the object in the background, 0 for none',
        0,
        256,
        read_only=False,
    ),
)
MAP_PERIOD = 5.0  # [s] between two looks at the map that is being made
# [m, m, rad] of the goal pose of a `plan` request without one.
TOLERANCE = np.array([0.01, 0.005, 0.03])
MOST_HEIGHT = 1e-3  # [m] of the start above the palm in a `plan` request
Answer = tuple[bool, str, Optional[ContactPlan]]  # found, one line, the plan


class ContactStatePlanner(WholeArmNode):
    """plan, plan_scenario → contact_plan, status.

    Plans in a thread of its own, so that the node always answers.
    """

    def __init__(self) -> None:
        super().__init__('contact_state_planner', DECLARED)
        scenario_of(self.parameters)  # refused now rather than at the first request
        self.busy, self.planned = False, 0
        self.maps: MapStore | None = None
        self.maker: MapMaker | None = None
        self.published: tuple[object, ...] = ()
        self.legs = LegPlanner(PlanRequest())
        self.face_map = self.publisher(channels.FACE_MAP)
        self.markers = self.publisher(channels.MARKERS)
        self.subscription(channels.RESULT, self.on_result)
        self.contact_plan = self.publisher(channels.CONTACT_PLAN)
        self.status = self.publisher(channels.PLANNER_STATUS)
        self.publish_status(
            OK,
            'loading the compiled kernels; the first time they are compiled, which takes a minute',
        )
        warm()  # before anybody can ask: no request pays for it
        self.service(channels.PLAN, self.on_plan)
        self.service(channels.PLAN_SCENARIO, self.on_plan_scenario)
        self.publish_status(OK, 'ready')
        self.tend_map()
        self.every(MAP_PERIOD, self.tend_map)

    async def on_plan_scenario(
        self, _: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        """The scenario as configured; the plan goes to whoever executes it."""
        answer = await self.answer(lambda: scenario_of(self.parameters))
        response.success, response.message, plan = answer
        if plan is not None:
            self.planned += 1
            self.contact_plan.publish(String(data=plan.to_json()))
        return response

    async def on_plan(
        self, request: GetPlan.Request, response: GetPlan.Response
    ) -> GetPlan.Response:
        """Between two poses of the object; no poses when there is no plan: the status says why.

        A question: what would be executed stays as it is.
        """
        _, _, plan = await self.answer(lambda: self.between(request))
        stamp, palm = self.get_clock().now().to_msg(), self.frame(channels.PALM_FRAME)
        response.plan.header.frame_id, response.plan.header.stamp = palm, stamp
        if plan is not None:
            response.plan.poses = [pose_message(stamp, pose, palm) for pose in plan.object_path()]
        return response

    def between(self, request: GetPlan.Request) -> Scenario:
        """The configured scenario with the request's start and goal pose.

        Raises ScenarioError or MessageError.
        """
        scenario = scenario_of(self.parameters)
        palm = self.frame(channels.PALM_FRAME)
        start, goal = to_planar(request.start, 'start', palm), to_planar(request.goal, 'goal', palm)
        if not np.isfinite(request.tolerance) or request.tolerance < 0:
            raise MessageError(f'tolerance: got {request.tolerance}; allowed: 0 or more')
        goal[2] += 2 * np.pi * round((start[2] - goal[2]) / (2 * np.pi))  # the shorter way round
        tolerance = TOLERANCE.copy()
        tolerance[:2] = request.tolerance or tolerance[:2]
        for key, pose, height in (('start', start, MOST_HEIGHT), ('goal', goal, tolerance[1])):
            if problem := floating(key, scenario, pose, height):
                raise MessageError(problem)
        world = build_world(scenario)
        fingers = np.array([close_finger(world, start, side) for side in (LEFT, RIGHT)])
        asked = replace(
            scenario, start=StartAtPose(start, fingers), goal=GoalAtPose(goal, tolerance)
        )
        return parse_scenario(scenario_to_dict(asked), 'plan request')

    async def answer(self, make_scenario: Callable[[], Scenario]) -> Answer:
        """(found, one line, plan or None); the status tells of it, too."""
        if self.busy:
            return False, PLANNER_BUSY, None
        self.busy, done = True, Future(executor=self.executor)
        try:
            scenario = make_scenario()
            self.publish_status(OK, f'planning {scenario.name}')
            threading.Thread(
                target=self.plan, args=(scenario, self.request(), done), daemon=True
            ).start()
            result = await done
            if isinstance(result, Exception):
                raise result
            if isinstance(scenario.goal, GoalOnEdge) and scenario.goal.direction is None:
                self.publish_map(scenario)
        except WholeArmError as error:
            return self.no_plan(str(error))
        except (
            Exception
        ) as error:  # a fault of ours: whoever asked is told, and may ask for something else
            traceback.print_exception(error)
            return self.no_plan(f'the planner failed by a fault of its own: {error!r}')
        finally:
            self.busy = False
        return self.concluded(result)

    def plan(self, scenario: Scenario, request: PlanRequest, done: Future) -> None:
        """Of the thread: `done` becomes a PlanResult or an exception."""
        try:
            done.set_result(self.legs_of(scenario, request).plan(scenario))
        except Exception as error:
            done.set_result(error)
        executor: Any = self.executor
        executor.wake()  # it looks at who awaits only when something else happens

    def legs_of(self, scenario: Scenario, request: PlanRequest) -> LegPlanner:
        """Of one object in one hand it is the same: it remembers how runs went."""
        maps = MapStore(scenario)
        if self.maps is None or self.maps.directory != maps.directory:
            self.maps, self.legs = maps, LegPlanner(request, maps)
            self.published = ()
        self.legs.request = request
        return self.legs

    def tend_map(self) -> None:
        """Of the object as configured, in the background where that is asked for; another object's
        begins anew. What is made is published, and used.
        """
        jobs = self.parameters.map_jobs
        if not jobs:
            return self.leave()
        scenario = scenario_of(self.parameters)
        self.legs_of(scenario, self.request())
        if self.maker is not None and self.maker.directory != MapStore(scenario).directory:
            self.leave()
        self.maker = self.maker or MapMaker(scenario, jobs)
        self.publish_map(scenario)

    def publish_map(self, scenario: Scenario) -> None:
        """As far as it is made; not the same one again."""
        assert self.maps is not None
        found, making = self.maps.load(), self.maker is not None and self.maker.making
        told = found.ways, len(found.refused), making
        if told != self.published:
            self.published = told
            document = {**found.to_dict(scenario.name), 'making': making}
            self.face_map.publish(String(data=json.dumps(document)))
            self.markers.publish(map_markers(scenario, found, self.frame(channels.PALM_FRAME)))

    def leave(self) -> None:
        """A map that is not finished goes on the next time."""
        if self.maker is not None:
            self.maker.stop()
            self.maker = None

    def on_result(self, message: DiagnosticStatus) -> None:
        """Of the trajectory generator: whether a plan led to its goal."""
        told = values_of(message)
        if told.get('claimed') in PROBED:
            self.legs.happened(told.get('goal_id', ''), told['claimed'] == AT_GOAL)

    def no_plan(self, reason: str) -> Answer:
        """Reported on the status, too."""
        self.publish_status(WARN, reason)
        return False, reason, None

    def concluded(self, result: PlanResult) -> Answer:
        """The figures of the search."""
        plan, found = result.plan, result.trajectory is not None
        self.publish_status(
            OK if found else WARN,
            plan.summary(),
            {
                'plan id': plan.id,
                'outcome': plan.outcome,
                'seed': plan.seed,
                **result.timings,
                **plan.counts,
                **_certificate_values(plan),
            },
        )
        return found, plan.summary(), plan if found else None

    def request(self) -> PlanRequest:
        """As the parameters say."""
        p = self.parameters
        return PlanRequest(
            search=p.search,
            seed=p.seed,
            transition=p.transition,
            time_budget=p.time_budget,
            min_success=p.min_success,
            hand_errors=p.hand_errors,
        )

    def publish_status(
        self, level: bytes, message: str, values: Optional[dict[str, Any]] = None
    ) -> None:
        """On the status and in the log."""
        self.status.publish(status_message(self.get_fully_qualified_name(), level, message, values))
        if level == OK:
            self.get_logger().info(message)
        else:  # rclpy wants every line of code to keep to one severity
            self.get_logger().warning(message)

    def health(self) -> Health:
        """Whether it plans, and how many plans there were."""
        return OK, 'planning' if self.busy else 'ready', {'plans': self.planned}


def _certificate_values(plan: ContactPlan) -> dict[str, Any]:
    """For the status: how surely the plan succeeds."""
    if plan.certificate is None:
        return {}
    values = plan.certificate.to_dict()
    return {f'certificate {name.replace("_", " ")}': value for name, value in values.items()}


def main() -> None:
    """The executable."""
    # EventsExecutor takes no coroutine as a service callback; this node has no fast topic.
    run_node(ContactStatePlanner, make_executor=SingleThreadedExecutor)


if __name__ == '__main__':
    main()
