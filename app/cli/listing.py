"""`flockscope list`: what there is to choose from."""

from __future__ import annotations

import json
import textwrap
from typing import Annotated

import typer

from app.cli.choices import KINDS, WIDE, Rows, names, rows, show_tables
from app.cli.list_details import find_by_name, format_details
from app.cli.usage import Rules, model_name


def listing(
    what: Annotated[
        str | None,
        typer.Argument(
            help=f"{', '.join(KINDS)}, or one name: a model, a world ...", callback=model_name
        ),
    ] = None,
    rule: Rules = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """List all names, one kind of things, or one thing in full."""
    rows_by_kind = rows(has_rule_file=bool(rule))
    if what is None:
        typer.echo(json.dumps(rows_by_kind) if as_json else "\n".join(overview(rows_by_kind)))
    elif what in KINDS:
        if as_json:
            typer.echo(json.dumps(rows_by_kind[what]))
        else:
            show_tables({what: rows_by_kind[what]})
    else:
        matches = find_by_name(what, rows_by_kind)
        if as_json:
            typer.echo(json.dumps(matches))
        else:
            typer.echo("\n".join(format_details(matches)))


def overview(rows_by_kind: dict[str, Rows]) -> list[str]:
    """All names on one screen, and how to see more of them."""
    lines = [
        "One thing:  flockscope list NAME, as in `flockscope list hwvem`",
        "One kind:   flockscope list KIND, as in `flockscope list models`",
    ]
    for kind, kind_names in names(rows_by_kind).items():
        lines.append(f"{kind} ({len(kind_names)})")
        if kind == "parameters":
            lines.append("  flockscope list MODEL shows those of a model, with unit and range")
        else:
            lines += textwrap.wrap(
                ", ".join(kind_names), WIDE - 2, initial_indent="  ", subsequent_indent="  ",
                break_on_hyphens=False,
            )  # fmt: skip
    return lines
