"""Sensitivity from a script or a notebook: the same runs and answers as on the command line."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from agents.spec import Spec
from app.figure import ENDINGS, INK, NAMED, new_figure, write_figure
from app.studies.charts.axis_limits import measure_limits
from app.studies.charts.colour_table import COLOURS, PALE, RULER
from app.studies.charts.mean_line import interval_sides
from app.studies.measure import SHARE, UNBOUNDED
from app.studies.runs.store_reader import StoreReader
from app.studies.sensitivity.sensitivity_result import Sensitivity, analyse, design_of
from app.studies.sweeps.sweep_api import StudyArguments, axis_bounds, result_folder
from app.studies.sweeps.sweep_results import Results
from app.studies.sweeps.sweep_runner import run_sweep
from app.studies.workers.process_executor import cores
from worlds.file_writer import demand_writable
from worlds.input_error import InputError, unknown
from worlds.number_text import counted

# Bars of sensitivity: how much each axis has to do with what is measured, with intervals.

TOTAL, ALONE = COLOURS[0], PALE


def draw(sensitivities: list[Sensitivity], title: str, path: Path, overwrite: bool = True) -> None:
    """Draw a panel for each thing that is measured: PNG, SVG or PDF. Raises InputError."""
    demand_writable("picture", path, overwrite, ENDINGS)
    with new_figure(NAMED) as figure:
        axes = len(sensitivities[0].influences)
        figure.set_size_inches(7.2, 1.3 + len(sensitivities) * (0.8 + 0.5 * axes))
        for panel, sensitivity in zip(
            figure.subplots(len(sensitivities), squeeze=False)[:, 0], sensitivities, strict=True
        ):
            draw_bars(panel, sensitivity)
        first = sensitivities[0]
        text = f"{counted(first.cells, 'cell')} of {counted(first.seeds, 'run')}"
        figure.suptitle(f"{title}\n{text}", x=0.01, ha="left", wrap=True)
        write_figure(figure, path)


def draw_bars(panel: Any, sensitivity: Sensitivity) -> None:
    """Draw the bars of one thing that is measured, the largest at the top."""
    places = np.arange(len(sensitivity.influences))[::-1].astype(float)
    names = {"sobol": ("all in all, S_T", "alone, S_1"), "morris": ("size, μ*", "mean, μ")}
    total, alone = names[sensitivity.kind]
    for shift, indices, colour, label in (
        (0.19, [i.total for i in sensitivity.influences], TOTAL, total),
        (-0.19, [i.alone for i in sensitivity.influences], ALONE, alone),
    ):
        panel.barh(
            places + shift,
            [index.value for index in indices],
            0.36,
            xerr=interval_sides(
                [index.value for index in indices], [index.interval for index in indices]
            ),
            color=colour,
            label=label,
            error_kw={"ecolor": INK, "elinewidth": 1.0, "capsize": 2.5},
        )
    panel.set_yticks(places, [i.axis for i in sensitivity.influences])
    panel.grid(axis="x")
    panel.grid(axis="y", visible=False)
    panel.axvline(0.0, color=RULER, linewidth=0.8)
    panel.set_xlim(*index_limits(sensitivity))
    what = "share of the variance" if sensitivity.kind == "sobol" else "effect of the whole range"
    chance = (
        "" if sensitivity.noise is None else f"; chance {sensitivity.noise:.0%} of the variance"
    )
    panel.set_xlabel(f"{sensitivity.observable}: {what}, 95 % intervals{chance}")
    panel.legend(fontsize=9, loc="lower right")


def index_limits(sensitivity: Sensitivity) -> tuple[float, float]:
    """The ends of the axis of the indices of one thing that is measured.

    Sobol's are shares, from 0 to 1; an estimate that is beyond, by chance, is shown all the same.
    """
    indices = [index for i in sensitivity.influences for index in (i.total, i.alone)]
    values = [index.value for index in indices]
    ends = [end for index in indices for end in index.interval]
    bounds = SHARE if sensitivity.kind == "sobol" else UNBOUNDED
    return measure_limits([0.0, *values], bounds, ends)


@dataclass(frozen=True, repr=False)
class Influences:
    """How much each axis has to do with each thing that is measured."""

    found: list[Sensitivity]
    title: str
    runs: Results
    """The runs, as `sweep` returns them."""

    def __repr__(self) -> str:
        names = ", ".join(sensitivity.observable for sensitivity in self.found)
        return f"<Influences on {names}: {self.title}>"

    @property
    def words(self) -> list[str]:
        """The order of the axes and what else is to be known, sentence by sentence."""
        return [line for sensitivity in self.found for line in sensitivity.words()]

    def order(self, observable: str) -> list[str]:
        """The axes, the one that matters most first. Raises InputError for what is not measured."""
        by_name = {sensitivity.observable: sensitivity for sensitivity in self.found}
        if observable not in by_name:
            raise unknown("observable", observable, by_name)
        return [influence.axis for influence in by_name[observable].influences]

    @property
    def columns(self) -> dict[str, list[Any]]:
        """The indices as lists by column, a row for each axis of each thing that is measured."""
        rows = [
            {
                "observable": sensitivity.observable,
                "axis": row.axis,
                sensitivity.symbols[0]: row.total.value,
                f"{sensitivity.symbols[0]} half interval": row.total.half,
                sensitivity.symbols[1]: row.alone.value,
                f"{sensitivity.symbols[1]} half interval": row.alone.half,
            }
            | ({"sigma": row.spread} if row.spread is not None else {})
            for sensitivity in self.found
            for row in sensitivity.influences
        ]
        return {name: [row[name] for row in rows] for name in rows[0]}

    def to_pandas(self) -> Any:
        """The indices as `pandas.DataFrame`."""
        import pandas as pd

        return pd.DataFrame(self.columns)

    def plot(self, path: str | Path) -> None:
        """Draw bars with intervals: PNG, SVG or PDF."""
        draw(self.found, self.title, Path(path))

    def _repr_html_(self) -> str:
        words = "".join(f"<li>{line}</li>" for line in self.words)
        return f"{self.to_pandas()._repr_html_()}<ul>{words}</ul>"


def sensitivity(
    what: str | Path | Spec,
    *,
    vary: Mapping[str, Any] | None = None,
    kind: Literal["saltelli", "morris"] = "saltelli",
    points: int = 64,
    trajectories: int = 10,
    seed: int = 1,
    runs: int = 4,
    ticks: int = 1000,
    observe: Sequence[str | Mapping[str, Any]] = (),
    folder: str | Path | None = None,
    workers: int | None = None,
    tell: Callable[[str], Any] | None = None,
    **words: Any,
) -> Influences:
    """Make the runs of a design of sensitivity that are not there yet, and say what matters.

    Parameters
    ----------
    what: a FILE.toml, which says all the rest; or the name of a model; or a `Spec`.
    vary: the axes by name, each a pair of bounds, or a dictionary with `from`, `to` and, if wanted,
        `scale = "log"`, or a list of three values and more.
    kind: `saltelli`, for Sobol's indices, or `morris`, for elementary effects.
    points: of a saltelli design, a power of two: points (D + 2) cells.
    trajectories: of a morris design: trajectories (D + 1) cells.
    seed: of the design.
    runs: runs of each cell, with the seeds 1, 2, ... that all cells have in common.
    ticks, observe, folder, workers, tell, words: as `sweep` takes them.

    Raises InputError for what cannot be run, and for runs of which no index can be found.
    """
    design = None
    arguments = StudyArguments(what, runs, ticks, observe, words)
    if not arguments.is_file:
        if not vary:
            raise InputError("vary is needed: which parameters may matter, each with its bounds?")
        if kind not in ("saltelli", "morris"):
            raise unknown("kind of design", kind, ("saltelli", "morris"))
        size = {"points": points} if kind == "saltelli" else {"trajectories": trajectories}
        axes = {name: axis_bounds(axis) for name, axis in vary.items()}
        design = {"kind": kind, "axes": axes, "seed": seed, **size}
    elif vary:
        raise InputError(f"{str(what)!r} says itself what is varied: leave vary out")
    sweep = arguments.sweep(design, tell)
    design_of(sweep)
    place = result_folder(folder)
    run_sweep(sweep, place, workers=workers or cores(), tell=tell)
    return Influences(analyse(sweep, StoreReader(place)), sweep.title, Results(place))
