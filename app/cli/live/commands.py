"""`flockscope live`: real cars, or emulated ones."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from app.cli.live.check import check
from app.cli.live.lab import lab
from app.cli.live.live_options import Seconds, Ticks
from app.cli.live.run import run
from app.cli.terminal.outcome_table import as_json
from app.cli.terminal.usage import PrintJson, command_group
from worlds.number_text import counted

# `flockscope live emulate`: a laboratory in software, to try everything without hardware.


def emulate(
    file: Annotated[
        Path | None, typer.Argument(help="The laboratory's file. \\[default: an example]")
    ] = None,
    arm: Annotated[bool, typer.Option("--arm", help="Arm once every car is seen.")] = False,
    record: Annotated[
        Path | None, typer.Option(help="Record poses, commands and events in this new folder.")
    ] = None,
    port: Annotated[
        int, typer.Option(min=0, max=65535, help="UDP port that the cars hear; 0: a free one.")
    ] = 0,
    seconds: Seconds = None,
    ticks: Ticks = None,
    json_asked: Annotated[
        bool, typer.Option("--json", help="Print events and summary as lines of JSON.")
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Only the summary.")] = False,
) -> None:
    """Drive emulated cars: the laboratory's file, with cars and cameras in software.

    Loop, safety, frames on the link and the firmware's watchdog are those of real cars.
    """
    from app.cli.live.run import driving_seconds, run_laboratory
    from app.live.device_kinds import SIMULATED
    from app.live.operating.lab_choices import laboratory, open_driven

    link = f"{SIMULATED}?port={port}" if port else SIMULATED
    lab = laboratory(file).lab.with_values(str(file or "the example"), source=SIMULATED, link=link)
    run_laboratory(
        lab, open_driven, arm, record, driving_seconds(lab, seconds, ticks), json_asked, quiet
    )


# `flockscope live replay`: does a recording give the same commands again?

DIFFERS = 1
"""Exit code where a command comes out differently."""


def replay(
    folder: Annotated[Path, typer.Argument(help="Folder of the recording.")],
    json_asked: PrintJson = False,
) -> None:
    """Replay a live recording: the same rule behind the same safety, to the bit.

    Exit code 1 if a command comes out differently.
    """
    from app.live.operating.flock_driver import FlockDriver
    from app.live.recording.recording_replay import replay as replayed

    result = replayed(folder, FlockDriver)
    if json_asked:
        typer.echo(
            as_json(
                {
                    "folder": str(folder),
                    "ticks": result.ticks,
                    "commands": result.commands,
                    "same": not result.differs,
                    "differs": result.differs,
                }
            )
        )
    else:
        outcome = f"differs: {result.differs}" if result.differs else "the same to the bit"
        typer.echo(
            f"{counted(result.ticks, 'tick')}, {counted(result.commands, 'command')}: {outcome}"
        )
    if result.differs:
        raise typer.Exit(DIFFERS)


# `flockscope live recover`: the tables of a live recording whose process was killed.


def recover(
    folder: Annotated[Path, typer.Argument(help="Folder of the recording.")],
    json_asked: PrintJson = False,
) -> None:
    """Make the tables of a live recording whose process was killed.

    Says what the cars were told last, and whether that was to stop.
    """
    from app.live.recording.recovery import read_end
    from app.live.recording.recovery import recover as recovered

    rows = recovered(folder)
    last = read_end(folder)
    if json_asked:
        result = {"folder": str(folder), "rows": rows, "ending": None}
        if last is not None:
            result["ending"] = asdict(last) | {
                "told_to_stop": last.is_stop,
                "words": last.describe(),
            }
        typer.echo(as_json(result))
    else:
        typer.echo(
            "recovered: " + ", ".join(f"{counted(n, 'row')} of {name}" for name, n in rows.items())
        )
        typer.echo(last.describe() if last is not None else "nothing was sent that is recorded")


live = command_group(
    "Real cars in a room with motion capture: check, drive, replay, or emulate it all.",
    {
        "lab": lab,
        "check": check,
        "run": run,
        "replay": replay,
        "recover": recover,
        "emulate": emulate,
    },
)
