"""Parameters that more than one node declares, and what is made of them."""

from wholearm_ros.control.setpoints import ControlOptions, PdGains
from wholearm_ros.model.choices import Pacing, values
from wholearm_ros.model.scenario import Scenario
from wholearm_ros.model.scenario_file import load_scenario, parse_scenario
from wholearm_ros.model.yaml_text import parse_mapping
from wholearm_ros.package_share import scenario_path
from wholearm_ros.ros.interface.parameters import Declared, Parameters

SCENARIO = Declared(
    'scenario',
    '',
    'scenario file, its content as JSON, or the name of a shipped one; '
    'empty: the asymmetric hexagon',
)
PACING = Declared(
    'pacing',
    Pacing.realtime.value,
    'realtime: wall clock; lockstep: simulated time waits for the commands',
    choices=values(Pacing),
)

COMMAND_TIMEOUT = Declared(
    'command_timeout',
    0.015,
    'age of a command beyond which the drives hold the fingers; realtime [s]',
    0.002,
    1.0,
)
HOLD_TIME = Declared(
    'hold_time', 0.5, 'of holding, after which their torque is zero; realtime [s]', 0.0, 60.0
)

_DEFAULTS = ControlOptions()
KP = Declared('kp', _DEFAULTS.gains.kp, 'position gain [N m/rad]', 0.0, 10000.0, read_only=False)
KD = Declared('kd', _DEFAULTS.gains.kd, 'velocity gain [N m s/rad]', 0.0, 1000.0, read_only=False)
SLEW_LIMIT = Declared(
    'slew_limit',
    _DEFAULTS.slew_limit,
    'largest rate of change of the torque [N m/s]',
    0.1,
    1e5,
    read_only=False,
)
RAMP = Declared(
    'ramp', _DEFAULTS.ramp, 'time from the fingers at rest to the first setpoint [s]', 0.001, 10.0
)
HANDOVER = Declared(
    'handover',
    _DEFAULTS.handover,
    'time in which a finger that becomes velocity-controlled is brought to its trajectory [s]',
    0.001,
    10.0,
)
MAX_TRACKING_ERROR = Declared(
    'max_tracking_error',
    _DEFAULTS.max_tracking_error,
    'of the velocity-controlled finger; beyond it the run stops [rad]',
    1e-3,
    3.2,
)

STOP_OUTSIDE = Declared(
    'stop_outside',
    _DEFAULTS.stop_outside,
    "whether a run that has left its trajectory's band stops; else that is only said",
)


def scenario_of(parameters: Parameters) -> Scenario:
    """The scenario that `scenario` names. Raises ScenarioError."""
    if parameters.scenario.lstrip().startswith('{'):
        return parse_scenario(parse_mapping(parameters.scenario, 'scenario'), 'scenario')
    return load_scenario(scenario_path(parameters.scenario))


def gains_of(parameters: Parameters) -> PdGains:
    """Of `kp` and `kd`."""
    return PdGains(parameters.kp, parameters.kd)


def switch_options_of(parameters: Parameters) -> ControlOptions:
    """Of `ramp`, `handover` and `max_tracking_error`."""
    return ControlOptions(
        ramp=parameters.ramp,
        handover=parameters.handover,
        max_tracking_error=parameters.max_tracking_error,
        stop_outside=parameters.stop_outside,
    )
