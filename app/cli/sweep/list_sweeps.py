"""`flockscope sweep list`: the sweeps in a folder, and how far each is."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.cli.error_messages import one_line
from app.cli.outcome_table import as_json
from app.cli.sweep.sweep_choice import is_sweep
from app.results_folder import RESULTS


def list_sweeps(
    folder: Annotated[Path, typer.Option("--in", help="Where to look.")] = RESULTS,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """List sweeps and their progress."""
    from app.experiments.sweeps.sweep_status import status_of

    there = sorted(folder.iterdir()) if folder.is_dir() else []
    found = []
    for sweep in filter(is_sweep, there):
        try:
            found.append(status_of(sweep))
        except Exception as error:  # whatever one store holds, the others are listed
            typer.echo(one_line(f"flockscope: {sweep} is left out: {error}"), err=True)
    if json_asked:
        typer.echo(as_json({"sweeps": found}))
        return
    if not found:
        typer.echo(f"no sweep in {folder}/")
    for one in found:
        name = one_line(Path(one["folder"]).name)
        broken = one["runs"]["failed"] + one["runs"]["killed"]
        failed = f", {broken} failed" if broken else ""
        typer.echo(f"{name}: {one['state']}, {one['done']} of {one['of']} runs{failed}")
