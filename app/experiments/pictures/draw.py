"""The picture of an experiment, written as PNG and SVG."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from app.experiments.experiment import Experiment
from app.experiments.pictures.models import draw_models
from app.experiments.pictures.pairs import draw_pairs
from app.experiments.pictures.sweeps import draw_sweeps
from app.experiments.verdict import Verdict
from worlds.refusal import Refusal

PICTURES = {"models": draw_models, "sweeps": draw_sweeps, "pairs": draw_pairs}
LOOK = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.grid.axis": "y",
    "axes.axisbelow": True,
    "grid.color": "#e3e6ea",
    "axes.edgecolor": "#7a828c",
    "xtick.color": "#3c434b",
    "ytick.color": "#3c434b",
    "axes.titlesize": 11,
    "lines.solid_capstyle": "butt",
    "figure.titlesize": 11,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "flockscope",
}


def draw(experiment: Experiment, made: list[Verdict], folder: Path) -> dict[str, Path]:
    """Draw the picture into the folder; returns the files by kind. Raises Refusal."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure: Any = Figure(layout="constrained")
        FigureCanvasAgg(figure)
        PICTURES[experiment.picture](figure, made)
        figure.suptitle(f"{experiment.title}\n{experiment.source}", x=0.01, ha="left")
        files = {kind: folder / f"{experiment.name}.{kind}" for kind in ("png", "svg")}
        try:
            figure.savefig(files["png"], dpi=160)
            figure.savefig(files["svg"], metadata={"Date": None})
        except OSError as error:
            raise Refusal(
                f"picture in {str(folder)!r} cannot be written: {error.strerror}"
            ) from None
    return files
