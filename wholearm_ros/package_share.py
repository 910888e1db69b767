"""Where the files that ship with the package are: the source tree when run from there, else
share/wholearm_ros.
"""

import sys
from pathlib import Path
from typing import Union

from wholearm_ros.errors import ScenarioError, WholeArmError

DEFAULT_SCENARIO = 'asymmetric_hexagon'
# In config/, too, but no scenarios.
NODE_PARAMETERS, ROS2_CONTROL = 'control.yaml', 'ros2_control.yaml'


def share_directory() -> Path:
    """The directory of config/ and launch/: the source tree first, so that an edited file counts at
    once.
    """
    package = Path(__file__).resolve().parent
    places = [
        package.parent,
        Path(sys.prefix) / 'share' / 'wholearm_ros',
        *(parent / 'share' / 'wholearm_ros' for parent in package.parents),
    ]
    for place in places:
        if (place / 'package.xml').is_file() and (place / 'config').is_dir():
            return place
    raise WholeArmError(
        f'config/ of wholearm_ros: not found; looked in {", ".join(map(str, places))}'
    )


def shipped_scenarios() -> dict[str, Path]:
    """Name → file of every scenario that ships with the package."""
    found = sorted((share_directory() / 'config').glob('*.yaml'))
    return {path.stem: path for path in found if path.name not in (NODE_PARAMETERS, ROS2_CONTROL)}


def scenario_path(name: Union[str, Path] = '') -> Path:
    """A scenario by path, or a shipped one by name ('regular_hexagon'); '' is the default one.

    Raises ScenarioError, with the names that ship, when it is neither.
    """
    path = Path(name or DEFAULT_SCENARIO)
    if path.is_file():
        return path
    shipped = shipped_scenarios()
    if str(path) in shipped:
        return shipped[str(path)]
    if path.exists():
        return path  # a directory: whoever reads it says so
    raise ScenarioError(
        f'{path}: cannot be read: no such file, and no shipped scenario of this name; '
        f'allowed: a YAML or JSON file, or one of {", ".join(shipped)}'
    )
