"""Where the files that ship with the package are: the source tree when it is run from there, else share/wholearm_ros."""

import sys
from pathlib import Path

from wholearm_ros.errors import WholeArmError

DEFAULT_SCENARIO = 'asymmetric_hexagon.yaml'


def share_directory() -> Path:
    """Holds config/ and launch/. The source tree first, so that an edited file counts at once."""
    package = Path(__file__).resolve().parents[1]
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


def scenario_path(name: str = '') -> Path:
    """A scenario by path or by the name of a shipped one ('regular_hexagon'); '' is the default one."""
    if not name:
        return share_directory() / 'config' / DEFAULT_SCENARIO
    path = Path(name)
    shipped = share_directory() / 'config' / f'{name}.yaml'
    return shipped if not path.exists() and shipped.is_file() else path
