"""`flockscope world`: worlds to look at, to check, to read from drawings, to make."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.choices import show_tables
from app.cli.terminal.console import REFUSED
from app.cli.terminal.outcome_table import as_json, print_written_files
from app.cli.terminal.usage import Overwrite, PrintJson, Settings, command_group
from app.settings import assignment, check_whole_number, names, numbers
from worlds.file_writer import demand_writable, write_text
from worlds.input_error import InputError
from worlds.number_text import counted

if TYPE_CHECKING:
    from worlds.readers.roles import LayerRole
    from worlds.world import World

# Worlds that the commands are given, and layouts that they write.

SIDE = 10.0
"""Side of the box of a layout that leaves it open, m."""


def load_world(name: str, dim: int | None = None, size: str | None = None, seed: int = 0) -> World:
    """The world of a built-in name or a layout file, sound or not. Raises InputError.

    Without `size` it is the layout's own, else SIDE. Random obstacles are drawn from `seed`.
    """
    from worlds.generators import draw_obstacles
    from worlds.layout import read_layout, world_from_layout

    world = world_from_layout(read_layout(name), name, dim, sides(size), lambda _: SIDE)
    check_whole_number("--seed", seed, 0)
    return draw_obstacles(world, seed)


def sides(text: str | None) -> float | tuple[float, ...] | None:
    """One side for all axes, or one per axis. Raises InputError."""
    if text is None:
        return None
    lengths = numbers("--size", text)
    return lengths[0] if len(lengths) == 1 else tuple(lengths)


def parse_edges(text: str) -> str | tuple[str, ...]:
    """One word for all sides, or one per axis."""
    edges = names(text)
    return edges[0] if len(edges) == 1 else tuple(edges)


LAYOUTS = (".toml",)
"""Endings of layouts."""


def demand_new(
    option: str, path: Path, overwrite: bool, endings: Collection[str] = LAYOUTS
) -> None:
    """Refuse a file that cannot be written, or is there, unless asked. Raises InputError."""
    demand_writable(option, path, overwrite, endings)


def write_layout(world: World, path: Path) -> None:
    """Write the layout of a world, which must be sound. Raises InputError."""
    from worlds.checks import demand_sound

    demand_sound(world)
    write_text("--out", path, world.to_toml())


def size_text(world: World) -> str:
    """The sides of the box."""
    return " x ".join(f"{side:g}" for side in world.size) + " m"


# `flockscope world check`: what is wrong with a layout, and what it holds.


def check(
    name: Annotated[str, typer.Argument(help="A layout file or a built-in world.")],
    dim: Annotated[int | None, typer.Option(min=2, max=3, help="2 or 3 dimensions.")] = None,
    seed: Annotated[int, typer.Option(help="Run whose random obstacles to draw, if any.")] = 0,
    json_asked: PrintJson = False,
) -> None:
    """Check a layout: print its problems, one a line, and what it holds if it is sound.

    The exit code is 2 if it has an error, and 0 if it has warnings only.
    """
    world = load_world(name, dim, seed=seed)
    from app.worlds.contents import contents
    from worlds.checks import problems

    faults = problems(world)
    sound = all(fault.severity != "error" for fault in faults)
    holds = contents(world) if sound else None
    if json_asked:
        rows = [
            {"severity": p.severity, "feature": p.feature, "place": p.place, "text": p.text}
            for p in faults
        ]
        typer.echo(as_json({"world": world.name, "sound": sound, "problems": rows, "holds": holds}))
    else:
        for fault in faults:
            typer.echo(f"{fault.severity}: {fault.text}")
        if holds:
            typer.echo(f"{world.name} is sound: {size_text(world)}, {describe_contents(holds)}")
    if not sound:
        raise typer.Exit(REFUSED)


def describe_contents(holds: dict[str, Any]) -> str:
    """What a world holds, in words."""
    return (
        f"{counted(holds['obstacles'], 'obstacle')}, "
        f"{counted(holds['outline_edges'], 'outline edge')}, "
        f"{counted(holds['boundary_points'], 'boundary point')}, {holds['free']:.1%} free"
    )


# `flockscope world list`: the built-in worlds.


def list_worlds(
    json_asked: PrintJson = False,
) -> None:
    """List the built-in worlds."""
    rows = worlds()
    if json_asked:
        typer.echo(as_json(rows))
        return
    show_tables({"worlds": [{name: row[name] for name in ("name", "title")} for row in rows]})


def worlds() -> list[dict[str, Any]]:
    """Name, title, sides and number of obstacles of each; sides are null where they are open.

    `random` is what is drawn from the seed of a run on top of them, null if nothing is.
    """
    from worlds.layout import layout_names, read_layout

    rows = []
    for name in layout_names():
        layout = read_layout(name)
        rows.append(
            {
                "name": name,
                "title": layout.get("title", ""),
                "size": layout.get("size"),
                "edges": layout.get("edges", "wrap"),
                "obstacles": len(layout.get("obstacle", [])),
                "random": layout.get("random"),
                "mission": sorted(layout.get("mission", {})),
            }
        )
    return rows


# `flockscope world make`: a layout of random obstacles.


def make(
    kind: Annotated[str, typer.Argument(help="discs, blocks, forest, corridors or maze.")],
    out: Annotated[Path, typer.Option(help="The layout to write (TOML).")],
    seed: Annotated[int, typer.Option(help="Seed of the world.")] = 1,
    size: Annotated[str, typer.Option(help="Side of the box, or one per axis, m.")] = "60,40",
    dim: Annotated[int | None, typer.Option(min=2, max=3, help="2 or 3 dimensions.")] = None,
    edges: Annotated[
        str, typer.Option(help="solid, open or wrap for all sides, or one per axis: wrap,solid.")
    ] = "solid",
    settings: Settings = None,
    overwrite: Overwrite = False,
    json_asked: PrintJson = False,
) -> None:
    """Make a world of random obstacles; the same seed and parameters give the same world."""
    check_whole_number("--seed", seed, 0)
    demand_new("--out", out, overwrite)
    from worlds.generators import generate

    values = dict(assignment(setting) for setting in settings or [])
    world = generate(kind, seed, sides(size) or 0.0, parse_edges(edges), dim, "--set", **values)
    write_layout(world, out)
    solid = len(world.obstacles)
    if json_asked:
        typer.echo(as_json({"layout": str(out), "obstacles": solid, "size": world.size}))
    else:
        typer.echo(f"{counted(solid, 'obstacle')} in {size_text(world)}")
    print_written_files(out)


# `flockscope world show`: the picture of a world.

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
    overwrite: Overwrite = False,
    json_asked: PrintJson = False,
) -> None:
    """Draw a world: obstacles, edges, start, path and goal; in space from above and in front."""
    path = out or Path(f"{Path(name).name.removesuffix('.toml')}.png")
    demand_new("--out", path, overwrite, PICTURES)
    world = load_world(name, dim, size, seed)
    if points and world.dim == 3:
        raise InputError("--points is not allowed in space: boundary points are made in the plane")
    from app.worlds.contents import points as boundary_points
    from app.worlds.world_picture import draw_world
    from worlds.checks import demand_sound

    demand_sound(world)
    draw_world(world, path, boundary_points(world) if points else None)
    if json_asked:
        typer.echo(as_json({"picture": str(path)}))
    print_written_files(path)


# `flockscope world import`: a layout from a drawing, or from a map of another program.

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
    overwrite: Overwrite = False,
    json_asked: PrintJson = False,
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
    from worlds.readers import assign_roles, geometry_of, open_drawing, world_and_notes

    roles = {
        "walkable": walkable,
        "obstacle": obstacle,
        "wall": wall,
        "start": start,
        "goal": goal,
        "path": path,
        "ignore": ignore,
    }
    drawing = open_drawing(file)
    rows = assign_roles(drawing, {role: layers for role, layers in roles.items() if layers})
    try:
        geometry = geometry_of(drawing, rows, scale, unit, thickness, join, drop_lines, degrees)
    except InputError:
        if not quiet:
            report(table(rows))
        raise
    world, mission = world_and_notes(geometry, parse_edges(edges), margin, to_origin)
    write_layout(world, out)
    notes = (*geometry.changes, *mission)
    if not quiet:
        report(table(rows))
        report([f"flockscope: {file}: {note}" for note in notes])
    free = free_area(world)
    solid = len(world.obstacles)
    if json_asked:
        value = {"layout": str(out), "obstacles": solid, "size": world.size, "low": world.low}
        layers = [
            {"layer": row.layer, "entities": row.entities, "role": row.role, "why": row.why}
            for row in rows
        ]
        typer.echo(as_json({**value, "free_area": free, "layers": layers, "notes": notes}))
    else:
        typer.echo(f"{counted(solid, 'obstacle')} in {size_text(world)}, {free:.6g} m² free")
    if not quiet:
        print_written_files(out)


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
        "  ".join([*(text.ljust(w) for text, w in zip(cell[:3], wide, strict=True)), cell[3]])
        for cell in cells
    ]


def printable(name: str) -> str:
    """A name from a file without what a terminal would obey, and not longer than a line.

    >>> printable("wall" + chr(27) + "[2J")
    'wall\\\\x1b[2J'
    """
    safe = "".join(sign if sign.isprintable() else repr(sign)[1:-1] for sign in name)
    return safe if len(safe) <= LONGEST else safe[: LONGEST - 3] + "..."


def free_area(world: World) -> float:
    """The area of the box that is not solid, m²."""
    from app.worlds.contents import free_share

    return free_share(world) * world.size[0] * world.size[1]


world = command_group(
    "Worlds: list them, draw them, check them, read them from drawings, make them.",
    {
        "list": list_worlds,
        "show": show,
        "check": check,
        "import": import_drawing,
        "make": make,
    },
)
