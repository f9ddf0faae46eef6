"""`flockscope live`: real cars, or emulated ones."""

from __future__ import annotations

import typer

from app.cli.live_check import check
from app.cli.live_emulate import emulate
from app.cli.live_lab import lab
from app.cli.live_recover import recover
from app.cli.live_replay import replay
from app.cli.live_run import run
from app.cli.refusals import told

live = typer.Typer(
    help="Real cars in a room with motion capture: check, drive, replay, or emulate it all.",
    no_args_is_help=True,
    add_completion=False,
)
live.command("lab")(told(lab))
live.command("check")(told(check))
live.command("run")(told(run))
live.command("replay")(told(replay))
live.command("recover")(told(recover))
live.command("emulate")(told(emulate))
