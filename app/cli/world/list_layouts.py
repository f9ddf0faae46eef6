"""`flockscope world list`: the built-in worlds."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from app.cli.choices import show
from app.cli.outcome_table import as_json


def list_worlds(
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """List the built-in worlds."""
    rows = worlds()
    if json_asked:
        typer.echo(as_json(rows))
        return
    show({"worlds": [{name: row[name] for name in ("name", "title")} for row in rows]})


def worlds() -> list[dict[str, Any]]:
    """Name, title, sides and number of obstacles of each; sides are null where they are open.

    `random` is what is drawn from the seed of a run on top of them, null if nothing is.
    """
    from worlds.layout import layout_names, read_layout

    found = []
    for name in layout_names():
        layout = read_layout(name)
        found.append(
            {
                "name": name,
                "title": layout.get("title", ""),
                "size": layout.get("size"),
                "edges": layout.get("edges", "wrap"),
                "obstacles": len(layout.get("obstacle", [])),
                "random": layout.get("random"),
                "mission": sorted(layout.get("mission", {})),
            }
        )
    return found
