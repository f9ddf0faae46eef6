"""`flockscope live`: real cars, or emulated ones."""

from __future__ import annotations

from app.cli.live_check import check
from app.cli.live_emulate import emulate
from app.cli.live_lab import lab
from app.cli.live_recover import recover
from app.cli.live_replay import replay
from app.cli.live_run import run
from app.cli.usage import grouped

live = grouped(
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
