"""What the commands print, write and end with: the consoles, the exit codes, one way to write a
file.
"""

import json
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

import typer
from rich.console import Console
from rich.markup import escape

from wholearm_ros.errors import SolverError, WholeArmError

OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130
EXIT_CODES = (
    'Exit codes: 0 success, 1 honest failure (no plan; object not at its goal), 2 bad input.'
)

out, err = Console(highlight=False), Console(stderr=True, highlight=False)


def finish(success: bool) -> NoReturn:
    """End the command: exit code 0, or 1 for an honest failure."""
    raise typer.Exit(OK if success else FAILED)


@contextmanager
def graph_at_work() -> Iterator[None]:
    """Around what needs the graph: the command ends when that breaks, or when interrupted."""

    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    signal.signal(signal.SIGINT, interrupt)
    signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    except KeyboardInterrupt:
        out.print('interrupted: every node has been stopped')
        raise typer.Exit(INTERRUPTED) from None
    except WholeArmError as error:
        out.print(f'[bold red]failed:[/] {escape(str(error))}', soft_wrap=True)
        raise typer.Exit(FAILED) from None


def exit_code_of(error: WholeArmError) -> int:
    """Exit code of an error that ended a command: the input's fault (2), or the solver's (1)."""
    return FAILED if isinstance(error, SolverError) else BAD_INPUT


def print_error(error: object) -> None:
    """One line on stderr that begins with 'error:'."""
    err.print(f'[bold red]error:[/] {escape(str(error))}', soft_wrap=True)


def print_plain(text: str) -> None:
    """A line on stdout, as it is."""
    out.print(text, markup=False, soft_wrap=True)


def write_text(path: Path, text: str, option: str) -> None:
    """Write a result; raises WholeArmError that names the command line option it was asked for
    with.
    """
    try:
        path.write_text(text, encoding='utf-8')
    except OSError as error:
        reason = error.strerror or error
        raise WholeArmError(f'{option} {path}: cannot be written: {reason}') from error


def write_json(path: Path, document: dict[str, Any], option: str = '--json') -> None:
    """Write a document as JSON; raises WholeArmError as `write_text` does."""
    write_text(path, json.dumps(document, indent=1, allow_nan=False) + '\n', option)
