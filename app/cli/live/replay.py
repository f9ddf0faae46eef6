"""`flockscope live replay`: does a recording give the same commands again?"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.cli.outcome_table import as_json
from worlds.number_text import counted

DIFFERS = 1
"""Exit code where a command comes out differently."""


def replay(
    folder: Annotated[Path, typer.Argument(help="Folder of the recording.")],
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Replay a live recording: the same rule behind the same safety, to the bit.

    Exit code 1 if a command comes out differently.
    """
    from app.live.operating.flock_driver import FlockDriver
    from app.live.recording.recording_replay import replay as replayed

    made = replayed(folder, FlockDriver)
    if json_asked:
        typer.echo(
            as_json(
                {
                    "folder": str(folder),
                    "ticks": made.ticks,
                    "commands": made.commands,
                    "same": not made.differs,
                    "differs": made.differs,
                }
            )
        )
    else:
        outcome = f"differs: {made.differs}" if made.differs else "the same to the bit"
        typer.echo(f"{counted(made.ticks, 'tick')}, {counted(made.commands, 'command')}: {outcome}")
    if made.differs:
        raise typer.Exit(DIFFERS)
