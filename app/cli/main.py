"""The command `flockscope`: finds the asked command and imports only what that one needs."""

from __future__ import annotations

import sys
import warnings
from importlib import import_module
from typing import Annotated, Any, NamedTuple

import typer
from typer.core import TyperCommand
from typer.main import get_command

from app.cli.terminal.console import guard_streams, with_one_line_errors
from app.cli.terminal.usage import CommandGroup, OneCommand


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
        "Open a class: each student has a flock, by one code.",
    ),
    "run": Entry(".run", "run", "Run a flock and print what is observed at its end."),
    "paper": Entry(".paper", "paper", "Repeat a table or a figure of a paper."),
    "sweep": Entry(
        ".sweep.commands", "sweep", "Make many runs over parameters; every run is kept."
    ),
    "sensitivity": Entry(
        ".sensitivity", "sensitivity", "Say which parameter matters, from a sweep."
    ),
    "optimise": Entry(".optimise", "optimise", "Search for the best values of parameters."),
    "tracks": Entry(
        ".tracks.commands", "tracks", "Read and measure tracks of animals, people and robots."
    ),
    "fit": Entry(".fit", "fit", "Find parameters from tracks, and say what they tell."),
    "live": Entry(".live.commands", "live", "Drive real cars: check, run, replay, emulate."),
    "flight": Entry(".flight", "flight", "Fly a flapping-wing aircraft: trim, sweep, load."),
    "world": Entry(".world", "world", "List, draw, check, import and make worlds."),
    "formation": Entry(".formation", "formation", "Say what birds save in formation flight."),
    "list": Entry(".listing", "listing", "List models, worlds, observables, papers, lessons."),
    "new": Entry(".new", "new", "Write a start for a rule of your own."),
    "check": Entry(
        ".model_commands", "check", "Check that a model keeps to what every model does."
    ),
    "warm": Entry(".model_commands", "warm", "Compile models in advance."),
    "cite": Entry(".model_commands", "cite", "Print the papers of a model as BibTeX."),
    "recording": Entry(
        ".take.recording", "recording", "Show what a recording holds; write it as CSV."
    ),
    "picture": Entry(
        ".take.picture", "picture", "Draw a flock in its world, with legend and scale."
    ),
    "film": Entry(".take.film", "film", "Film a flock in its world: MP4, WebM or GIF."),
    "export": Entry(".take.export", "export", "Write a flock as one web page that runs by itself."),
    "recover": Entry(".take.recording", "recover", "Save the recording of a run that was killed."),
    "docs": Entry(".docs", "docs", "Read all about flockscope in the browser, offline."),
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
        single.command(name, cls=OneCommand)(with_one_line_errors(function))
        command = get_command(single)
    command.name = name
    return command


app = typer.Typer(cls=Commands, no_args_is_help=False, pretty_exceptions_enable=False)


def show_version(is_requested: bool) -> None:
    """Print the version and stop."""
    if is_requested:
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
    arguments = sys.argv[1:]
    is_bare = not arguments or (arguments[0].startswith("-") and arguments[0] not in OWN_OPTIONS)
    app(args=["lab", *arguments] if is_bare else arguments, prog_name="flockscope")
