"""`flockscope world import`: a layout from a GeoJSON, WKT or DXF drawing."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.cli.outcome import as_json, tell_written
from app.cli.world_file import demand_new, edges_asked, size_text, write_layout
from worlds.counting import counted


def import_drawing(
    file: Annotated[Path, typer.Argument(help="A .geojson, .wkt or .dxf file.")],
    out: Annotated[Path, typer.Option(help="The layout to write (TOML).")],
    scale: Annotated[
        float | None,
        typer.Option(help="Metres per unit of the file. \\[default: 1; DXF: its $INSUNITS]"),
    ] = None,
    obstacles: Annotated[
        list[str] | None,
        typer.Option(help="A layer that is solid; may be repeated. \\[default: all others]"),
    ] = None,
    walkable: Annotated[
        str | None,
        typer.Option(help="The layer of the walkable area. \\[default: walkable, if there is one]"),
    ] = None,
    edges: Annotated[
        str, typer.Option(help="solid, open or wrap for all sides, or one per axis: wrap,solid.")
    ] = "solid",
    thickness: Annotated[
        float | None, typer.Option(help="Make walls of open lines, this thick, m.")
    ] = None,
    margin: Annotated[
        float | None,
        typer.Option(help="Room around the obstacles, m. \\[default: a tenth of their extent]"),
    ] = None,
    to_origin: Annotated[
        bool, typer.Option("--to-origin", help="Move the lower corner of the box to (0, 0).")
    ] = False,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Let --out replace a file.")
    ] = False,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Do not tell what is left out.")] = False,
) -> None:
    """Make a layout of a drawing. With a walkable area, all outside of it is solid.

    What bounds no area, crosses itself or is not closed is refused by name and place.
    """
    demand_new("--out", out, overwrite)
    from worlds.readers import read_geometry, world_around

    geometry = read_geometry(file, scale, obstacles, walkable, thickness)
    made = world_around(geometry, edges_asked(edges), margin, to_origin)
    write_layout(made, out)
    if not quiet:
        for note in geometry.notes:
            typer.echo(f"flockscope: {file}: {note}", err=True)
    solid = len(made.obstacles)
    if json_asked:
        value = {"layout": str(out), "obstacles": solid, "size": made.size, "low": made.low}
        typer.echo(as_json({**value, "notes": geometry.notes}))
    else:
        typer.echo(f"{counted(solid, 'obstacle')} in {size_text(made)}")
    if not quiet:
        tell_written(out)
