"""The whole graph: `ros2 launch wholearm_ros wholearm.launch.py scenario:=regular_hexagon pacing:=lockstep record:=/tmp/bag`.

The counterpart of `wholearm run`, for those who plan and send goals themselves.
"""

from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    RegisterEventHandler,
    SetEnvironmentVariable,
)
from launch.conditions import IfCondition
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration, PythonExpression
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

from launch import LaunchDescription
from wholearm_ros.model.backends import BACKENDS, DEFAULT_BACKEND
from wholearm_ros.model.choices import Hardware, Pacing, Search, Storage, Transition, values
from wholearm_ros.package_share import NODE_PARAMETERS, share_directory

ARGUMENTS = (
    ('scenario', '', 'scenario file, or the name of a shipped one; empty: the asymmetric hexagon'),
    ('namespace', 'wholearm', 'of every node'),
    ('pacing', Pacing.realtime.value, ' or '.join(values(Pacing))),
    ('rate', '1000.0', 'of the motors [Hz]'),
    (
        'hardware',
        DEFAULT_BACKEND,
        f'simulated ({", ".join(BACKENDS)}); none: one of yours publishes joint_states; '
        'ros2_control: by ros2_control_bridge, which you activate',
    ),
    (
        'params',
        str(share_directory() / 'config' / NODE_PARAMETERS),
        'parameter file for every node',
    ),
    ('view', 'false', "PyBullet's window"),
    ('perturb', '0.0', 'level of errors of the simulated hand, unknown to the planner'),
    ('hand_errors', '0.0', 'level of errors of its joints, axes and encoders, likewise'),
    ('seed', '0', 'of everything drawn at random in planning'),
    ('search', Search.best.value, ' or '.join(values(Search))),
    (
        'transition',
        Transition.auto.value,
        f'how torque ranges that do not overlap are crossed: {", ".join(values(Transition))}',
    ),
    ('time_budget', '180.0', 'for a plan, its verification included [s]'),
    ('probe', 'true', 'whether the hand feels where the object lies in the end'),
    ('attempts', '4', 'trajectories at most for a goal of the reorientation'),
    ('priority', '20', 'of the loop in real time, where the machine allows it; 0: none'),
    ('record', '', 'directory of a bag to record into; empty: none'),
    ('storage', Storage.mcap.value, f'format of the bag: {" or ".join(values(Storage))}'),
    ('network', 'false', 'true: other machines may take part, and command the drives'),
)


def generate_launch_description():
    def text(name):
        return ParameterValue(LaunchConfiguration(name), value_type=str)

    def number(name, kind):
        return ParameterValue(LaunchConfiguration(name), value_type=kind)

    def node(executable, parameters, **more):
        return Node(
            package='wholearm_ros',
            executable=executable,
            namespace=LaunchConfiguration('namespace'),
            output='screen',
            parameters=[LaunchConfiguration('params'), parameters],
            **more,
        )

    def hardware_is_one_of(kinds):
        return IfCondition(
            PythonExpression(["'", LaunchConfiguration('hardware'), f"' in {tuple(kinds)}"])
        )

    scenario, pacing = {'scenario': text('scenario')}, {'pacing': text('pacing')}
    rate = {'motor_rate': number('rate', float)}
    real_time = PythonExpression(
        [
            "int('",
            LaunchConfiguration('priority'),
            "') if '",
            LaunchConfiguration('pacing'),
            f"' == '{Pacing.realtime.value}' else 0",
        ]
    )
    loop = {'priority': ParameterValue(real_time, value_type=int)}
    nodes = [
        node(
            'hand_hardware',
            {
                **scenario,
                **pacing,
                **loop,
                **rate,
                'backend': text('hardware'),
                'view': number('view', bool),
                'perturb': number('perturb', float),
                'hand_errors': number('hand_errors', float),
                'perturb_number': number('seed', int),
            },
            condition=hardware_is_one_of(BACKENDS),
        ),
        node(
            'ros2_control_bridge',
            {**scenario, **loop},
            condition=hardware_is_one_of((Hardware.ros2_control.value,)),
        ),
        node('mode_switcher', {**pacing, **loop, 'probe': number('probe', bool)}),
        node('velocity_controller', {**scenario, **loop}),
        node('torque_controller', {**scenario, **loop, **rate}),
        node('trajectory_generator', {**scenario}),
        node('reorientation', {**scenario, 'max_attempts': number('attempts', int)}),
        node('object_observer', {**scenario}),
        node(
            'contact_state_planner',
            {
                **scenario,
                'seed': number('seed', int),
                'search': text('search'),
                'transition': text('transition'),
                'time_budget': number('time_budget', float),
            },
        ),
    ]
    recorder = node(
        'bag_recorder',
        {'path': text('record'), 'storage': text('storage'), **loop},
        condition=IfCondition(PythonExpression(["'", LaunchConfiguration('record'), "' != ''"])),
    )
    # A graph with a node missing is of no use: all end with the first one that does.
    watch = [
        RegisterEventHandler(
            OnProcessExit(
                target_action=n, on_exit=[EmitEvent(event=Shutdown(reason='a node ended'))]
            )
        )
        for n in (*nodes, recorder)
    ]
    # The nodes choose their transport by it; without it they bind the loopback interface only.
    network = SetEnvironmentVariable(
        'ROS_AUTOMATIC_DISCOVERY_RANGE',
        'SUBNET',
        condition=IfCondition(LaunchConfiguration('network')),
    )
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=value, description=told)
                for name, value, told in ARGUMENTS
            ),
            network,
            *nodes,
            recorder,
            *watch,
        ]
    )
