"""Options and arguments that several commands share, each defined once."""

from pathlib import Path
from typing import Annotated, Any

import typer

from wholearm_ros.model.backends import JUDGES
from wholearm_ros.model.choices import Backend, Pacing, Search, Transition

TIME_BUDGET = 180.0  # [s]
MIN_SUCCESS = 0.8


def _writable(path: Path | None) -> Path | None:
    """Refused before the work, not after it."""
    if path is not None and not path.absolute().parent.is_dir():
        raise typer.BadParameter(f'{path.absolute().parent} is not a directory')
    return path


def _known_judge(value: str) -> str:
    if value not in JUDGES:
        raise typer.BadParameter(f'got {value!r}; allowed: {", ".join(JUDGES)}')
    return value


def output_file(name: str, text: str, default: bool | str = True) -> Any:
    """Option whose value is a file to write; default: what --help says about its default."""
    return typer.Option(
        name,
        metavar='OUT',
        dir_okay=False,
        writable=True,
        callback=_writable,
        help=text,
        show_default=default,
    )


def level_option(name: str, text: str) -> Any:
    """Option that takes a level of errors; text: its help."""
    return typer.Option(name, min=0.0, max=10.0, metavar='LEVEL', help=text)


def scenario_argument(text: str) -> Any:
    """Argument that may be left out: then it is the asymmetric hexagon; text: its help."""
    return typer.Argument(metavar='[SCENARIO]', help=text, show_default='asymmetric_hexagon')


ScenarioName = Annotated[
    str,
    typer.Argument(
        metavar='SCENARIO',
        help='Scenario file, YAML or JSON, or the name of a shipped one (asymmetric_hexagon).',
    ),
]
GoalEdgeOption = Annotated[
    int | None,
    typer.Option(
        '--goal-edge',
        min=0,
        metavar='EDGE',
        help="Lay the object on this edge, by any way, instead of the scenario's goal.",
        show_default="the scenario's goal",
    ),
]
SeedOption = Annotated[
    int,
    typer.Option(
        '--seed', min=0, help='Of the search and of random draws: same seed, same result.'
    ),
]
SearchOption = Annotated[
    Search,
    typer.Option('--search', help="best: widest torque margins first; random: the paper's search."),
]
TransitionOption = Annotated[
    Transition,
    typer.Option(
        '--transition',
        help='How to cross between torque ranges that do not overlap; auto: the more robust way.',
    ),
]
BudgetOption = Annotated[
    float,
    typer.Option(
        '--time-budget', min=0.0, help='Seconds for planning, verification by simulation included.'
    ),
]
SuccessOption = Annotated[
    float,
    typer.Option(
        '--min-success',
        min=0.0,
        max=1.0,
        help='Least lower bound (95 % confidence) of the success rate of a plan that is given.',
    ),
]
BackendOption = Annotated[
    Backend, typer.Option('--backend', help='Physics of the simulated hand; planar is our own.')
]
JudgeOption = Annotated[
    str,
    typer.Option(
        '--backend',
        metavar=f'[{"|".join(JUDGES)}]',
        callback=_known_judge,
        help='Physics of the simulated hand; jury: all that are installed, and where they part.',
    ),
]
PerturbOption = Annotated[
    float,
    level_option(
        '--perturb',
        'Draw mass, shape, friction, delay, torque and noise unknown to the planner; '
        '1: ±5 %, ±0.5 mm, 0-0.05, 0-3 ms, ±3 %, 0.2 mrad.',
    ),
]
HandErrorsOption = Annotated[
    float,
    level_option(
        '--hand-errors',
        'Draw errors of the hand unknown to the planner: joint friction, encoder zeros, '
        'axes, direction of gravity, start x; 1: 0-0.02 N m, ±2 mrad, ±0.3 mm, ±0.5 °, ±1 mm.',
    ),
]
PacingOption = Annotated[
    Pacing,
    typer.Option(
        '--pacing',
        help='realtime: wall clock; lockstep: simulated time waits for every command, '
        'the same result on any machine.',
    ),
]
RateOption = Annotated[float, typer.Option('--rate', min=50.0, max=2000.0, help='Motor rate [Hz].')]
ViewOption = Annotated[
    bool, typer.Option('--view', help="Open PyBullet's window, where there is a screen.")
]
JsonOption = Annotated[Path | None, output_file('--json', 'Write the result here as JSON.')]
