"""`flockscope live`: real cars, or emulated ones."""

from __future__ import annotations

from app.cli.live.check import check
from app.cli.live.emulate import emulate
from app.cli.live.lab import lab
from app.cli.live.recover import recover
from app.cli.live.replay import replay
from app.cli.live.run import run
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
