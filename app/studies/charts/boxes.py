"""Box plots: the box from quartile to quartile, whiskers to 5 and 95 %."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

WHISKERS = (5, 95)
WORDS = "box: quartiles and median; whiskers: 5 and 95 %; dots: runs beyond; dotted line: mean"


def draw_key(figure: Any, signs: list[Any], words: str) -> None:
    """Say what is what, below the panels, where no data are."""
    figure.legend(
        handles=signs,
        loc="outside lower left",
        ncols=len(signs),
        fontsize=9,
        title=words,
        title_fontsize=8,
        alignment="left",
    )


def runs_with_value(values: Sequence[float | None]) -> np.ndarray:
    """The runs that have a value."""
    return np.array([k for k in values if k is not None], float)


def box(axes: Any, x: float, values: Sequence[float | None], colour: str, width: float) -> None:
    """Draw one box at x."""
    present = runs_with_value(values)
    if present.size == 0:
        return
    line = {"color": colour, "linewidth": 1.2}
    axes.boxplot(
        [present],
        positions=[x],
        widths=width,
        whis=WHISKERS,
        patch_artist=True,
        manage_ticks=False,
        boxprops={"facecolor": colour + "40", "edgecolor": colour, "linewidth": 1.2},
        medianprops={"color": colour, "linewidth": 2.2},
        whiskerprops=line,
        capprops=line,
        flierprops={"marker": ".", "markersize": 4, "alpha": 0.5, "markeredgecolor": colour},
        showmeans=True,
        meanline=True,
        meanprops={"color": colour, "linewidth": 1.0, "linestyle": (0, (1.5, 1.2))},
    )
