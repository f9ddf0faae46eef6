"""`flockscope sweep plot`: the picture of an observable, also while the sweep runs."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.cli.outcome_table import tell_written
from app.cli.sweep.status import Name
from app.cli.sweep.sweep_choice import kept_sweep
from worlds.input_error import InputError


def plot(
    name: Name,
    observable: Annotated[
        str | None, typer.Option(help="What is shown. \\[default: the first that is measured]")
    ] = None,
    kind: Annotated[
        str | None,
        typer.Option(
            help="lines, map, points, distribution or scaling. \\[default: what suits the axes]"
        ),
    ] = None,
    x: Annotated[str | None, typer.Option(help="The axis along the picture.")] = None,
    y: Annotated[str | None, typer.Option(help="The axis up a map.")] = None,
    where: Annotated[
        str, typer.Option(help="Only cells for which this holds: 'agents == 50'.")
    ] = "",
    snapshots: Annotated[
        bool, typer.Option("--snapshots", help="Draw the flock of each cell into a map.")
    ] = False,
    beta: Annotated[
        float | None, typer.Option(help="Exponent of the collapse in a picture of scaling.")
    ] = None,
    nu: Annotated[float | None, typer.Option(help="The other exponent.")] = None,
    critical: Annotated[
        float | None,
        typer.Option(
            help="Where the transition is. \\[default: where Binder's cumulants of the two largest "
            "sizes cross]"
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="PNG, SVG or PDF by its ending. \\[default: a PNG beside the runs]"),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the file that --out names.")
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Do not name the file.")] = False,
) -> None:
    """Draw lines with 95 % bands, a map over two axes, a sample's points, or distributions.

    Cells with runs that gave up or failed are marked; such runs are in no mean. Scaling takes an
    axis 'agents': a line for each size, Binder's cumulant if 'binder' is observed, and with --beta
    and --nu the collapse.
    """
    from app.experiments.runs.store_reader import StoreReader
    from app.experiments.sweeps.pictures.scaling import Scaling
    from app.experiments.sweeps.pictures.sweep_picture import draw
    from app.experiments.sweeps.sweep_table import measured

    if (beta is None) != (nu is None) or (critical is not None and beta is None):
        raise InputError("a collapse takes --beta and --nu, and --critical beside them")
    scaling = None if beta is None or nu is None else Scaling(beta, nu, critical)
    kept = StoreReader(kept_sweep(name))
    shown = observable or next(iter(measured(kept)), "picture")
    path = out or kept.folder / f"{shown.replace('/', '-')}.png"
    draw(
        kept, path, observable,
        kind=kind, x=x, y=y, where=where, snapshots=snapshots, scaling=scaling,
        overwrite=overwrite or out is None,
    )  # fmt: skip
    if not quiet:
        tell_written(path)
