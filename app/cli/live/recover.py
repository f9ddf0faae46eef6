"""`flockscope live recover`: the tables of a live recording whose process was killed."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from app.cli.outcome_table import as_json
from worlds.number_text import counted


def recover(
    folder: Annotated[Path, typer.Argument(help="Folder of the recording.")],
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Make the tables of a live recording whose process was killed.

    Says what the cars were told last, and whether that was to stop.
    """
    from app.live.recording.recovery import ending
    from app.live.recording.recovery import recover as recovered

    rows = recovered(folder)
    last = ending(folder)
    if json_asked:
        made = {"folder": str(folder), "rows": rows, "ending": None}
        if last is not None:
            made["ending"] = asdict(last) | {
                "told_to_stop": last.told_to_stop,
                "words": last.words(),
            }
        typer.echo(as_json(made))
    else:
        typer.echo(
            "recovered: " + ", ".join(f"{counted(n, 'row')} of {name}" for name, n in rows.items())
        )
        typer.echo(last.words() if last is not None else "nothing was sent that is recorded")
