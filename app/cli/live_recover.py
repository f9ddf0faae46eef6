"""`flockscope live recover`: the tables of a live recording whose process was killed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.cli.outcome import as_json
from worlds.counting import counted


def recover(
    folder: Annotated[Path, typer.Argument(help="Folder of the recording.")],
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Make the tables of a live recording whose process was killed."""
    from app.live.record import recover as recovered

    rows = recovered(folder)
    if json_asked:
        typer.echo(as_json({"folder": str(folder), "rows": rows}))
    else:
        typer.echo(
            "recovered: " + ", ".join(f"{counted(n, 'row')} of {name}" for name, n in rows.items())
        )
