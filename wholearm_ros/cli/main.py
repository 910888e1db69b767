"""The command line. A command is imported when it is called: `--help` is quick, and only `run`
needs ROS 2.
"""

from importlib import import_module
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from wholearm_ros.cli.output import BAD_INPUT, EXIT_CODES, exit_code_of, print_error
from wholearm_ros.cli.version_command import version
from wholearm_ros.errors import WholeArmError

COMMANDS = {
    'plan': 'Plan a scenario: contact states, the trajectory through them, verified.',
    'advise': 'Find the smallest change that gives a scenario without a plan one.',
    'simulate': 'Execute a plan on a simulated hand, without ROS.',
    'map': 'Find out from which face to which an object can be turned, and how surely.',
    'suite': 'Plan and execute many scenarios, and count what reached its goal.',
    'report': 'Write what happened as one HTML file.',
    'run': 'Plan and execute on the ROS 2 graph, each node a process.',
    'console': 'See the hand live in the browser, and command it (needs ROS 2).',
    'feel': 'Feel what lies in the hand, before anything is planned (needs ROS 2).',
    'check-hand': 'Check your own hand against the contract (needs ROS 2).',
    'version': 'Print the version.',
}
CONSOLE_TOO = ", and the extra: pip install 'wholearm_ros[console]'"
HELP = {'help_option_names': ['-h', '--help']}


class _Commands(TyperGroup):
    """The commands by name and one line of help; the file of a command is imported when it is
    called.
    """

    def list_commands(self, ctx: Any) -> list[str]:
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> TyperCommand | None:
        return TyperCommand(cmd_name, help=COMMANDS[cmd_name]) if cmd_name in COMMANDS else None

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        name, stub, rest = super().resolve_command(ctx, args)
        return name, stub and load_command(str(name)), rest

    def invoke(self, ctx: Any) -> Any:
        try:
            return super().invoke(ctx)
        except WholeArmError as error:
            print_error(error)
            return ctx.exit(exit_code_of(error))


app = typer.Typer(
    cls=_Commands,
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode='rich',
    context_settings=HELP,
)


def _print_version(asked: bool) -> None:
    if asked:
        version()
        raise typer.Exit


@app.callback()
def about(
    _version: Annotated[
        bool,
        typer.Option(
            '--version', callback=_print_version, is_eager=True, help='Print the version and exit.'
        ),
    ] = False,
) -> None:
    """Whole-arm manipulation of a slippery polygon by two fingers and a palm: planned, verified,
    executed.

    [bold]Examples[/]

      wholearm plan asymmetric_hexagon --json plan.json
      wholearm simulate plan.json
      wholearm simulate regular_hexagon --perturb 1 --seed 3
      wholearm run --record runs/first          (needs ROS 2)
      wholearm report runs/first

    Exit codes: 0 success, 1 honest failure (no plan; object not at its goal), 2 bad input.
    """


def load_command(name: str) -> TyperCommand:
    """The command of cli/<name>_command.py; where what it imports is missing, a command that says
    so.
    """
    function = name.replace('-', '_')
    try:
        module = import_module(f'wholearm_ros.cli.{function}_command')
    except ImportError as error:
        if (error.name or '').partition('.')[0] == 'wholearm_ros':
            raise  # a mistake of ours, not a missing ROS
        return _unavailable(name, str(error))
    return _single(name, getattr(module, function), getattr(module, 'EPILOG', EXIT_CODES), HELP)


def _unavailable(name: str, missing: str) -> TyperCommand:
    """A command that says what is missing, whatever its options are."""

    def command() -> None:
        """Not available here."""
        print_error(
            f'{name}: {missing}; allowed: a sourced ROS 2 Jazzy, or its wheels installed'
            f'{CONSOLE_TOO if name == "console" else ""}. '
            '`wholearm simulate` does without ROS.'
        )
        raise typer.Exit(BAD_INPUT)

    return _single(
        name,
        command,
        EXIT_CODES,
        {**HELP, 'ignore_unknown_options': True, 'allow_extra_args': True},
    )


def _single(name: str, function: Any, epilog: str, settings: dict[str, Any]) -> TyperCommand:
    single = typer.Typer(add_completion=False, rich_markup_mode='rich', context_settings=settings)
    single.command(name, epilog=epilog, context_settings=settings)(function)
    command = typer.main.get_command(single)
    assert isinstance(command, TyperCommand)
    return command


def main() -> None:
    """Entry point of `wholearm`."""
    app(prog_name='wholearm')


if __name__ == '__main__':
    main()
