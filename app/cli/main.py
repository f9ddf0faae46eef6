"""The command `flockscope`: finds the asked command and imports only what that one needs."""

from __future__ import annotations

import sys
import warnings
from importlib import import_module
from typing import Annotated, Any, NamedTuple

import typer
from typer.core import TyperCommand
from typer.main import get_command

from app.cli.error_messages import told
from app.cli.terminal import guard_streams
from app.cli.usage import CommandGroup, OneCommand


class Entry(NamedTuple):
    """Where a command is, from this package, and what it is in a line."""

    module: str
    function: str
    summary: str


COMMANDS = {
    "lab": Entry(".lab", "lab", "Open the laboratory in the browser (the default)."),
    "class": Entry(
        ".classroom",
        "classroom",
        "A class: students with flocks of their own, one code on the wall.",
    ),
    "run": Entry(".run", "run", "Run a flock and print what is observed at its end."),
    "paper": Entry(".paper", "paper", "Repeat a table or a figure of a paper."),
    "sweep": Entry(".sweep.commands", "sweep", "Many runs over parameters, kept whatever happens."),
    "sensitivity": Entry(".sensitivity", "sensitivity", "Which parameter matters, from a sweep."),
    "optimise": Entry(".optimise", "optimise", "The best values of parameters, by a search."),
    "live": Entry(
        ".live.commands", "live", "Real cars: check a laboratory, drive, replay, emulate."
    ),
    "flight": Entry(
        ".flight.commands", "flight", "A flapping-wing aircraft: trim, sweep over speed, fly."
    ),
    "world": Entry(
        ".world.commands", "world", "Worlds: list, draw, check, read from drawings, make."
    ),
    "formation": Entry(".formation", "formation", "Formation flight: what birds save by upwash."),
    "list": Entry(".listing", "listing", "Models, worlds, observables, papers, lessons."),
    "check": Entry(".check", "check", "Check a model: what every model keeps to."),
    "warm": Entry(".warm", "warm", "Compile models ahead, so that nobody waits for them."),
    "cite": Entry(".cite", "cite", "The papers that a model comes from, as BibTeX."),
    "recording": Entry(
        ".take.recording", "recording", "What a recording holds, and its numbers as CSV."
    ),
    "picture": Entry(
        ".take.picture", "picture", "A picture of a flock in its world, with legend and scale."
    ),
    "film": Entry(".take.film", "film", "A film of a flock in its world: MP4, WebM or GIF."),
    "recover": Entry(".recover", "recover", "Save the recording of a run that was killed."),
}


OWN_OPTIONS = ("--help", "--version", "--install-completion", "--show-completion")


class Commands(CommandGroup):
    """The commands by name; the module of a command is imported when it is called."""

    def list_commands(self, ctx: Any) -> list[str]:  # noqa: ARG002
        """Names in the order of the help page."""
        return list(COMMANDS)

    def get_command(self, ctx: Any, cmd_name: str) -> Any:  # noqa: ARG002
        """A stand-in with name and summary, enough for the help page."""
        if cmd_name not in COMMANDS:
            return None
        return TyperCommand(cmd_name, help=COMMANDS[cmd_name].summary)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The real command for a call."""
        name, command, rest = super().resolve_command(ctx, args)
        return name, command and load(command.name or ""), rest


def load(name: str) -> Any:
    """Import a command."""
    entry = COMMANDS[name]
    function = getattr(import_module(entry.module, __package__), entry.function)
    if isinstance(function, typer.Typer):  # a command that has commands of its own
        command = get_command(function)
    else:
        single = typer.Typer(add_completion=False)
        single.command(name, cls=OneCommand)(told(function))
        command = get_command(single)
    command.name = name
    return command


app = typer.Typer(cls=Commands, no_args_is_help=False, pretty_exceptions_enable=False)


def show_version(asked: bool) -> None:
    """Print the version and stop."""
    if asked:
        from importlib.metadata import version

        typer.echo(f"flockscope {version('flockscope')}")
        raise typer.Exit


@app.callback()
def flockscope(
    version: Annotated[
        bool, typer.Option("--version", callback=show_version, is_eager=True, help="The version.")
    ] = False,
) -> None:
    """A laboratory for flocks: watch them, steer them, measure them.

    Without a command it opens the laboratory in the browser.
    """


def show_warning(message: Warning | str, *_: object, **__: object) -> None:
    """Show a warning in one line, on stderr."""
    typer.echo(f"flockscope: {' '.join(str(message).split())}", err=True)


def main() -> None:
    """Entry point of the command line; without a command, options are those of `lab`."""
    guard_streams()
    warnings.showwarning = show_warning
    given = sys.argv[1:]
    bare = not given or (given[0].startswith("-") and given[0] not in OWN_OPTIONS)
    app(args=["lab", *given] if bare else given, prog_name="flockscope")
