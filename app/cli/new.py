"""`flockscope new rule`: a start for a rule of one's own, in one file."""

from __future__ import annotations

import inspect
import re
import sys
from pathlib import Path
from typing import Annotated

import typer

from app.cli.terminal.outcome_table import print_written_files
from app.cli.terminal.usage import command_group
from worlds.file_writer import write_text
from worlds.input_error import InputError

START = '''"""{title}: agents turn to the mean heading of their neighbours, near ones first."""

import math

from flockscope.rules import Decision, Rule, Vicsek, adjacent, compiled, parameter


class Parameters(Vicsek):  # brings the radius r and the noise eta
    """What can be changed: each is a slider, and an option `--set NAME=VALUE`."""

    fade: float = parameter(
        0.5,
        "Distance over which a neighbour's weight falls to 1/e",
        words="Reach of the weight",
        symbol="\\\\lambda",
        unit="length",
        low=0.05,
        high=5.0,
        source="this file",
    )


@compiled  # runs as machine code; `--interpret` runs it as plain Python, where `print` works
def decide(me, near, surroundings, p):
    """The heading that an agent wants; of any length but 0, which keeps its own."""
    x, y, z = me.ux, me.uy, me.uz  # its own heading counts 1
    for j in range(near.n):  # who may be a neighbour
        dx, dy, dz = near.x[j] - me.x, near.y[j] - me.y, near.z[j] - me.z
        d = math.sqrt(dx * dx + dy * dy + dz * dz)
        weight = adjacent(me, near, j, p.r) * math.exp(-d / p.fade)  # 0 beyond r
        x += weight * near.ux[j]
        y += weight * near.uy[j]
        z += weight * near.uz[j]
    return Decision(x, y, z)


RULE = Rule(
    name="{name}",
    title="{title}",
    summary="Agents listen less to neighbours that are further away.",
    equation=r"u_i + \\sum_j e^{{-d_{{ij}}/\\lambda}}\\, u_j",
    source="this file",
    parameters=Parameters,
    decide=decide,
)
'''
"""The file without --from."""
NAMES = re.compile(r"[a-z][a-z0-9-]*")


def rule(
    file: Annotated[Path, typer.Argument(metavar="FILE.py", help="Where the rule is to be.")],
    origin: Annotated[
        str | None, typer.Option("--from", help="The model whose rule it begins as.")
    ] = None,
) -> None:
    """Write a rule to begin with; the laboratory runs it, and follows what you save.

    Raises InputError for a file that is there already, and for a name that is none or is taken.
    """
    if file.suffix != ".py":
        raise InputError(f"FILE.py = {str(file)!r} is not allowed: it must end in .py")
    if file.exists():
        raise InputError(f"{file} is there already: choose another name")
    name = file.stem.lower().replace("_", "-")
    if not NAMES.fullmatch(name):
        raise InputError(
            f"FILE.py = {str(file)!r} is not allowed: letters, digits, - and _ make the rule's name"
        )
    from agents.catalogue import MODELS

    if name in MODELS:
        raise InputError(f"there is a model {name!r} already: choose another name for {file}")
    title = name.replace("-", " ").capitalize()
    text = START.format(name=name, title=title) if origin is None else copied(origin, name)
    write_text("rule", file, text)
    print_written_files(file)


def copied(origin: str, name: str) -> str:
    """The file of a built-in rule, and below it a model of another name. Raises InputError."""
    from agents.catalogue import is_built_in
    from agents.catalogue import model as find_model

    model = find_model(origin)
    if not is_built_in(model.name):
        raise InputError(f"--from {origin!r} has a file of its own: copy that")
    catalogue = find_model.__module__  # which a wheel has under a name of its own
    rules = f"{catalogue.rpartition('.')[0]}.rules."
    home, variable = next(
        (module, key)
        for place, module in list(sys.modules.items())
        if place.startswith(rules)
        for key, value in vars(module).items()
        if value is model.rule
    )
    return (
        f"{inspect.getsource(home)}\n\n"
        f"# Its own name, with the body and the world of {model.name!r}.\n"
        "from dataclasses import replace  # noqa: E402\n\n"
        f"from {catalogue} import model  # noqa: E402\n\n"
        f'MODEL = replace(model("{model.name}"), rule=replace({variable}, name="{name}"))\n'
    )


new = command_group("Write a start of your own.", {"rule": rule})


@new.callback()
def start() -> None:
    """Write a start of your own."""  # without a callback one command alone would have no name
