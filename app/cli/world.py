"""`flockscope world`: worlds to look at, to check, to read from drawings, to make."""

from __future__ import annotations

import typer

from app.cli.refusals import told
from app.cli.world_check import check
from app.cli.world_import import import_drawing
from app.cli.world_list import list_worlds
from app.cli.world_make import make
from app.cli.world_show import show

world = typer.Typer(
    help="Worlds: list them, draw them, check them, read them from drawings, make them.",
    no_args_is_help=True,
    add_completion=False,
)
world.command("list")(told(list_worlds))
world.command("show")(told(show))
world.command("check")(told(check))
world.command("import")(told(import_drawing))
world.command("make")(told(make))
