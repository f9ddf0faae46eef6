"""`flockscope world show`: the picture of a world."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.cli.outcome_table import as_json, tell_written
from app.cli.world.world_file import demand_new, given_world
from worlds.input_error import InputError

PICTURES = (".png", ".svg")


def show(
    name: Annotated[str, typer.Argument(help="A built-in world or a layout file.")],
    out: Annotated[Path | None, typer.Option(help="PNG or SVG file. \\[default: NAME.png]")] = None,
    dim: Annotated[int | None, typer.Option(min=2, max=3, help="2 or 3 dimensions.")] = None,
    size: Annotated[
        str | None, typer.Option(help="Side of the box, or one per axis, if the layout has none.")
    ] = None,
    seed: Annotated[int, typer.Option(help="Run whose random obstacles to draw, if any.")] = 0,
    points: Annotated[bool, typer.Option("--points", help="Show the boundary points.")] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Let --out replace a file.")
    ] = False,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Draw a world: obstacles, edges, start, path and goal; in space from above and in front."""
    path = out or Path(f"{Path(name).name.removesuffix('.toml')}.png")
    demand_new("--out", path, overwrite, PICTURES)
    made = given_world(name, dim, size, seed)
    if points and made.dim == 3:
        raise InputError("--points is not allowed in space: boundary points are made in the plane")
    from app.worlds.contents import points as boundary_points
    from app.worlds.world_picture import draw_world
    from worlds.checks import demand_sound

    demand_sound(made)
    draw_world(made, path, boundary_points(made) if points else None)
    if json_asked:
        typer.echo(as_json({"picture": str(path)}))
    tell_written(path)
