"""`flockscope world make`: a layout of random obstacles."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.cli.outcome_table import as_json, tell_written
from app.cli.world.world_file import demand_new, edges_asked, sides, size_text, write_layout
from app.settings import assignment, at_least
from worlds.number_text import counted


def make(
    kind: Annotated[str, typer.Argument(help="discs, blocks, forest, corridors or maze.")],
    out: Annotated[Path, typer.Option(help="The layout to write (TOML).")],
    seed: Annotated[int, typer.Option(help="Seed of the world.")] = 1,
    size: Annotated[str, typer.Option(help="Side of the box, or one per axis, m.")] = "60,40",
    dim: Annotated[int | None, typer.Option(min=2, max=3, help="2 or 3 dimensions.")] = None,
    edges: Annotated[
        str, typer.Option(help="solid, open or wrap for all sides, or one per axis: wrap,solid.")
    ] = "solid",
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", help="A parameter, NAME=VALUE; may be repeated."),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Let --out replace a file.")
    ] = False,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Make a world of random obstacles; the same seed and parameters give the same world."""
    at_least("--seed", seed, 0)
    demand_new("--out", out, overwrite)
    from worlds.generators import generate

    given = dict(assignment(setting) for setting in settings or [])
    made = generate(kind, seed, sides(size) or 0.0, edges_asked(edges), dim, "--set", **given)
    write_layout(made, out)
    solid = len(made.obstacles)
    if json_asked:
        typer.echo(as_json({"layout": str(out), "obstacles": solid, "size": made.size}))
    else:
        typer.echo(f"{counted(solid, 'obstacle')} in {size_text(made)}")
    tell_written(out)
