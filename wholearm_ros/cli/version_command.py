"""`wholearm version`, and `wholearm --version`."""

from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed

from wholearm_ros.cli.output import print_plain


def version() -> None:
    """Print the version of wholearm_ros."""
    try:
        print_plain(f'wholearm_ros {installed("wholearm_ros")}')
    except PackageNotFoundError:
        print_plain('wholearm_ros, not installed (a source tree)')
