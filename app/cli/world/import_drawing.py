"""`flockscope world import`: a layout from a drawing, or from a map of another program."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.outcome_table import as_json, tell_written
from app.cli.world.world_file import demand_new, edges_asked, size_text, write_layout
from worlds.input_error import InputError
from worlds.number_text import counted

if TYPE_CHECKING:
    from worlds.readers.roles import LayerRole
    from worlds.world import World

Layers = list[str] | None
MOST_LINES = 60
"""Most layers, and most changes, that are told to people; --json has all."""
LONGEST = 80
"""Letters of a layer's name that are shown."""
WIDEST = 40
"""Letters of a column of the table that are kept in line."""


def import_drawing(
    file: Annotated[
        Path,
        typer.Argument(
            help="DXF, SVG, GeoJSON, WKT; .scenario (Vadere), .map (MovingAI), .yaml, .zip (ROS)."
        ),
    ],
    out: Annotated[Path, typer.Option(help="The layout to write (TOML).")],
    walkable: Annotated[
        Layers, typer.Option(help="A layer of walkable areas: all else is solid.")
    ] = None,
    obstacle: Annotated[
        Layers, typer.Option("--obstacle", "--solid", help="A layer of what is solid.")
    ] = None,
    wall: Annotated[
        Layers,
        typer.Option(help="A layer of lines, open or closed, that --thickness makes walls."),
    ] = None,
    start: Annotated[Layers, typer.Option(help="A layer of the mission's start.")] = None,
    goal: Annotated[Layers, typer.Option(help="A layer of the mission's goal.")] = None,
    path: Annotated[Layers, typer.Option(help="A layer of the mission's path.")] = None,
    ignore: Annotated[
        Layers,
        typer.Option(
            help="A layer that means nothing here. All seven may be repeated; * stands for any "
            "letters, and alone for all layers without a role."
        ),
    ] = None,
    unit: Annotated[
        str | None,
        typer.Option(
            help="Of the file: m, dm, cm, mm, km, in, ft, yd. \\[default: m; DXF: its $INSUNITS]"
        ),
    ] = None,
    scale: Annotated[
        float | None, typer.Option(help="Metres per unit of the file, in place of --unit.")
    ] = None,
    join: Annotated[
        float | None,
        typer.Option(help="Join lines whose ends meet, draw splines by chords, within this, m."),
    ] = None,
    drop_lines: Annotated[
        bool,
        typer.Option("--drop-lines", help="Leave out lines that bound no area, naming each."),
    ] = False,
    thickness: Annotated[
        float | None,
        typer.Option(
            help="Make walls of open lines, and on layers of walls of all, this thick, m."
        ),
    ] = None,
    degrees: Annotated[
        bool,
        typer.Option(
            "--degrees", help="The file is in degrees (GeoJSON, WKT): project it to metres."
        ),
    ] = False,
    edges: Annotated[
        str, typer.Option(help="solid, open or wrap for all sides, or one per axis: wrap,solid.")
    ] = "solid",
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
    quiet: Annotated[
        bool, typer.Option("--quiet", help="Do not tell what each layer is and what was changed.")
    ] = False,
) -> None:
    """Make a layout of a drawing. With a walkable area, all outside of it is solid.

    Each layer is what you say, or what its name says (walkable, obstacle, wall, start, exit, path,
    and JuPedSim's names that begin with jps-). What has no clear role, bounds no area, crosses
    itself or is not closed is refused by name and place.
    """
    demand_new("--out", out, overwrite)
    from worlds.readers import cast, geometry_of, open_drawing, world_and_notes

    asked = {
        "walkable": walkable,
        "obstacle": obstacle,
        "wall": wall,
        "start": start,
        "goal": goal,
        "path": path,
        "ignore": ignore,
    }
    drawing = open_drawing(file)
    rows = cast(drawing, {role: layers for role, layers in asked.items() if layers})
    try:
        geometry = geometry_of(drawing, rows, scale, unit, thickness, join, drop_lines, degrees)
    except InputError:
        if not quiet:
            report(table(rows))
        raise
    made, mission = world_and_notes(geometry, edges_asked(edges), margin, to_origin)
    write_layout(made, out)
    notes = (*geometry.changes, *mission)
    if not quiet:
        report(table(rows))
        report([f"flockscope: {file}: {note}" for note in notes])
    free = free_area(made)
    solid = len(made.obstacles)
    if json_asked:
        value = {"layout": str(out), "obstacles": solid, "size": made.size, "low": made.low}
        layers = [
            {"layer": row.layer, "entities": row.entities, "role": row.role, "why": row.why}
            for row in rows
        ]
        typer.echo(as_json({**value, "free_area": free, "layers": layers, "notes": notes}))
    else:
        typer.echo(f"{counted(solid, 'obstacle')} in {size_text(made)}, {free:.6g} m² free")
    if not quiet:
        tell_written(out)


def report(lines: Sequence[str]) -> None:
    """Lines on stderr, the first MOST_LINES of them."""
    for line in lines[:MOST_LINES]:
        typer.echo(line, err=True)
    if len(lines) > MOST_LINES:
        typer.echo(f"and {len(lines) - MOST_LINES} more; --json has all of them", err=True)


def table(rows: Sequence[LayerRole]) -> list[str]:
    """The layers of a drawing, what is on them, what each is taken for and why; if it has any."""
    if not rows:
        return []
    cells = [("layer", "entities", "role", "why")]
    cells += [(printable(row.layer), row.entities, row.role or "?", row.why) for row in rows]
    wide = [min(max(len(cell[k]) for cell in cells), WIDEST) for k in range(3)]
    return [
        "  ".join([*(one.ljust(w) for one, w in zip(cell[:3], wide, strict=True)), cell[3]])
        for cell in cells
    ]


def printable(name: str) -> str:
    """A name from a file without what a terminal would obey, and not longer than a line.

    >>> printable("wall" + chr(27) + "[2J")
    'wall\\\\x1b[2J'
    """
    safe = "".join(sign if sign.isprintable() else repr(sign)[1:-1] for sign in name)
    return safe if len(safe) <= LONGEST else safe[: LONGEST - 3] + "..."


def free_area(made: World) -> float:
    """The area of the box that is not solid, m²."""
    from app.worlds.contents import free_share

    return free_share(made) * made.size[0] * made.size[1]
