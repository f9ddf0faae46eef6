"""`flockscope list`: what there is to choose from."""

from __future__ import annotations

import json
import textwrap
from typing import Annotated

import typer

from app.cli.choices import KINDS, WIDE, Rows, names, rows, show_tables
from app.cli.list_details import format_details, things_called
from app.cli.usage import Rules, by_name


def listing(
    what: Annotated[
        str | None,
        typer.Argument(
            help=f"{', '.join(KINDS)}, or one name: a model, a world ...", callback=by_name
        ),
    ] = None,
    rule: Rules = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """List all names, one kind of things, or one thing in full."""
    made = rows(brought=bool(rule))
    if what is None:
        typer.echo(json.dumps(made) if as_json else "\n".join(overview(made)))
    elif what in KINDS:
        if as_json:
            typer.echo(json.dumps(made[what]))
        else:
            show_tables({what: made[what]})
    else:
        found = things_called(what, made)
        if as_json:
            typer.echo(json.dumps(found))
        else:
            typer.echo("\n".join(format_details(found)))


def overview(made: dict[str, Rows]) -> list[str]:
    """All names on one screen, and how to see more of them."""
    lines = [
        "One thing:  flockscope list NAME, as in `flockscope list hwvem`",
        "One kind:   flockscope list KIND, as in `flockscope list models`",
    ]
    for kind, found in names(made).items():
        lines.append(f"{kind} ({len(found)})")
        if kind == "parameters":
            lines.append("  flockscope list MODEL shows those of a model, with unit and range")
        else:
            lines += textwrap.wrap(
                ", ".join(found), WIDE - 2, initial_indent="  ", subsequent_indent="  ",
                break_on_hyphens=False,
            )  # fmt: skip
    return lines
