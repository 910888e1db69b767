"""Whole-arm manipulation of a slippery polygon: planned, verified and executed on ROS 2.

The public API is the names below; a room is imported when one of its names is used first.

    import wholearm_ros as wa

    scenario = wa.load_scenario('asymmetric_hexagon')
    result = wa.plan(scenario, wa.PlanRequest(seed=0))
    run = wa.simulate(scenario, result.trajectory, backend='planar')
    print(wa.judge(scenario, run).executed)
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from wholearm_ros.control.command_watchdog import CommandWatchdog
    from wholearm_ros.mechanics.contacts import start_configuration
    from wholearm_ros.model.perturbation import draw_perturbation
    from wholearm_ros.model.scenario_file import load_scenario, parse_scenario
    from wholearm_ros.planner.planner import plan_and_verify as plan
    from wholearm_ros.planner.request import PlanRequest
    from wholearm_ros.report.bag_run import read_bag
    from wholearm_ros.report.figures.figures import write_figures
    from wholearm_ros.report.html.write import write_report
    from wholearm_ros.report.run_view import view_of as view_run
    from wholearm_ros.simulation.closed_loop import LoopOptions
    from wholearm_ros.simulation.closed_loop import run as simulate
    from wholearm_ros.simulation.factory import make_hand
    from wholearm_ros.simulation.outcome import outcome as judge

__all__ = [
    'CommandWatchdog',
    'LoopOptions',
    'PlanRequest',
    'draw_perturbation',
    'judge',
    'load_scenario',
    'make_hand',
    'parse_scenario',
    'plan',
    'read_bag',
    'simulate',
    'start_configuration',
    'view_run',
    'write_figures',
    'write_report',
]

_HOMES = {
    'CommandWatchdog': ('control.command_watchdog', 'CommandWatchdog'),
    'LoopOptions': ('simulation.closed_loop', 'LoopOptions'),
    'PlanRequest': ('planner.request', 'PlanRequest'),
    'draw_perturbation': ('model.perturbation', 'draw_perturbation'),
    'judge': ('simulation.outcome', 'outcome'),
    'load_scenario': ('model.scenario_file', 'load_scenario'),
    'make_hand': ('simulation.factory', 'make_hand'),
    'parse_scenario': ('model.scenario_file', 'parse_scenario'),
    'plan': ('planner.planner', 'plan_and_verify'),
    'read_bag': ('report.bag_run', 'read_bag'),
    'simulate': ('simulation.closed_loop', 'run'),
    'start_configuration': ('mechanics.contacts', 'start_configuration'),
    'view_run': ('report.run_view', 'view_of'),
    'write_figures': ('report.figures.figures', 'write_figures'),
    'write_report': ('report.html.write', 'write_report'),
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f'module {__name__!r} has no attribute {name!r}')
    module, attribute = _HOMES[name]
    return getattr(import_module(f'{__name__}.{module}'), attribute)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
