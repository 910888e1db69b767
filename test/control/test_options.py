"""config/control.yaml holds the defaults of ControlOptions, so that there is one set of numbers."""

from pathlib import Path

import yaml

from wholearm_ros.control.setpoints import ControlOptions


def test_the_shipped_parameters_are_the_defaults():
    file = Path(__file__).parents[2] / 'config' / 'control.yaml'
    told, options = yaml.safe_load(file.read_text())['/**']['ros__parameters'], ControlOptions()
    assert told == {
        'kp': options.gains.kp,
        'kd': options.gains.kd,
        'slew_limit': options.slew_limit,
        'ramp': options.ramp,
        'handover': options.handover,
        'max_tracking_error': options.max_tracking_error,
        'stop_outside': options.stop_outside,
    }
