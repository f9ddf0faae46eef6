"""`flockscope recover`: the recording of a run that was killed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from worlds.number_text import counted


def recover(
    file: Annotated[
        Path, typer.Argument(help="The .part file that the run has left; of a live run its folder.")
    ],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Save the recording of a killed run from its .part file, or its folder."""
    if file.is_dir():
        from app.cli.live.commands import recover as recover_live

        recover_live(file, as_json)
        return
    from agents.recordings.recorder import recover as recover_part

    path, rows = recover_part(file)
    if as_json:
        typer.echo(json.dumps({"recording": str(path), "rows": rows}))
    else:
        typer.echo(f"{path}: {counted(rows, 'row')}")
