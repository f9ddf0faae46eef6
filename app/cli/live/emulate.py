"""`flockscope live emulate`: a laboratory in software, to try everything without hardware."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.cli.live.live_options import Seconds, Ticks


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
    from app.cli.live.run import conduct, lasting
    from app.live.device_kinds import SIMULATED
    from app.live.operating.lab_choices import laboratory
    from app.live.operating.lab_opener import open_driven

    link = f"{SIMULATED}?port={port}" if port else SIMULATED
    lab = laboratory(file).lab.altered(str(file or "the example"), source=SIMULATED, link=link)
    conduct(lab, open_driven, arm, record, lasting(lab, seconds, ticks), json_asked, quiet)
