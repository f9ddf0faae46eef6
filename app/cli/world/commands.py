"""`flockscope world`: worlds to look at, to check, to read from drawings, to make."""

from __future__ import annotations

from app.cli.usage import grouped
from app.cli.world.check import check
from app.cli.world.import_drawing import import_drawing
from app.cli.world.list_layouts import list_worlds
from app.cli.world.make import make
from app.cli.world.show import show

world = grouped(
    "Worlds: list them, draw them, check them, read them from drawings, make them.",
    {
        "list": list_worlds,
        "show": show,
        "check": check,
        "import": import_drawing,
        "make": make,
    },
)
