"""`flockscope world check`: what is wrong with a layout, and what it holds."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from app.cli.error_messages import REFUSED
from app.cli.outcome_table import as_json
from app.cli.world.world_file import given_world, size_text
from worlds.number_text import counted


def check(
    name: Annotated[str, typer.Argument(help="A layout file or a built-in world.")],
    dim: Annotated[int | None, typer.Option(min=2, max=3, help="2 or 3 dimensions.")] = None,
    seed: Annotated[int, typer.Option(help="Run whose random obstacles to draw, if any.")] = 0,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Check a layout: print its problems, one a line, and what it holds if it is sound.

    The exit code is 2 if it has an error, and 0 if it has warnings only.
    """
    made = given_world(name, dim, seed=seed)
    from app.worlds.contents import contents
    from worlds.checks import problems

    found = problems(made)
    sound = all(one.severity != "error" for one in found)
    holds = contents(made) if sound else None
    if json_asked:
        rows = [
            {"severity": p.severity, "feature": p.feature, "place": p.place, "text": p.text}
            for p in found
        ]
        typer.echo(as_json({"world": made.name, "sound": sound, "problems": rows, "holds": holds}))
    else:
        for one in found:
            typer.echo(f"{one.severity}: {one.text}")
        if holds:
            typer.echo(f"{made.name} is sound: {size_text(made)}, {described(holds)}")
    if not sound:
        raise typer.Exit(REFUSED)


def described(holds: dict[str, Any]) -> str:
    """What a world holds, in words."""
    return (
        f"{counted(holds['obstacles'], 'obstacle')}, "
        f"{counted(holds['outline_edges'], 'outline edge')}, "
        f"{counted(holds['boundary_points'], 'boundary point')}, {holds['free']:.1%} free"
    )
