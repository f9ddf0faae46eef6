"""Bars of sensitivity: how much each axis has to do with what is measured, with intervals."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from app.figure import write_figure
from app.studies.pictures.experiment_picture import LOOK
from app.studies.sensitivity.sensitivity_result import Sensitivity
from app.studies.sweeps.pictures.mean_lines import COLOURS
from app.studies.sweeps.pictures.sweep_picture import ENDINGS
from worlds.file_writer import demand_writable
from worlds.number_text import counted

TOTAL, ALONE = COLOURS[0], "#9ecae1"


def draw(found: list[Sensitivity], title: str, path: Path, overwrite: bool = True) -> None:
    """Draw a panel for each thing that is measured: PNG, SVG or PDF. Raises InputError."""
    demand_writable("picture", path, overwrite, ENDINGS)
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure: Any = Figure(layout="constrained")
        FigureCanvasAgg(figure)
        axes = len(found[0].influences)
        figure.set_size_inches(7.2, 1.3 + len(found) * (0.8 + 0.5 * axes))
        for panel, one in zip(figure.subplots(len(found), squeeze=False)[:, 0], found, strict=True):
            draw_bars(panel, one)
        first = found[0]
        said = f"{counted(first.cells, 'cell')} of {counted(first.seeds, 'run')}"
        figure.suptitle(f"{title}\n{said}", x=0.01, ha="left", wrap=True)
        write_figure(figure, path)


def draw_bars(panel: Any, one: Sensitivity) -> None:
    """Draw the bars of one thing that is measured, the largest at the top."""
    places = np.arange(len(one.influences))[::-1].astype(float)
    names = {"sobol": ("all in all, S_T", "alone, S_1"), "morris": ("size, μ*", "mean, μ")}
    total, alone = names[one.kind]
    for shift, indices, colour, label in (
        (0.19, [i.total for i in one.influences], TOTAL, total),
        (-0.19, [i.alone for i in one.influences], ALONE, alone),
    ):
        panel.barh(
            places + shift,
            [index.value for index in indices],
            0.36,
            xerr=np.nan_to_num([index.half for index in indices]),
            color=colour,
            label=label,
            error_kw={"ecolor": "#3c434b", "elinewidth": 1.0, "capsize": 2.5},
        )
    panel.set_yticks(places, [i.axis for i in one.influences])
    panel.grid(axis="x")
    panel.grid(axis="y", visible=False)
    panel.axvline(0.0, color="#7a828c", linewidth=0.8)
    what = "share of the variance" if one.kind == "sobol" else "effect of the whole range"
    chance = "" if one.noise is None else f"; chance {one.noise:.0%} of the variance"
    panel.set_xlabel(f"{one.observable}: {what}, 95 % intervals{chance}")
    panel.legend(fontsize=9, loc="lower right")
