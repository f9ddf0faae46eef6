"""What the formation commands write: pictures as PNG and SVG, numbers as CSV."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from app.experiments.pictures.draw import LOOK
from worlds.refusal import Refusal

SAVED, LOST, INK, PALE = "#1f9d63", "#c0392b", "#3c434b", "#9aa3ad"
SHADES = "BrBG"
"""Colours of shares: downwash brown, upwash green."""


def written(folder: Path, name: str, draw: Callable[[Any], None]) -> dict[str, Path]:
    """Draw on a new figure and write it into the folder; the files by kind. Raises Refusal."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    files = {kind: folder / f"{name}.{kind}" for kind in ("png", "svg")}
    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure: Any = Figure(layout="constrained")
        FigureCanvasAgg(figure)
        draw(figure)
        try:
            folder.mkdir(parents=True, exist_ok=True)
            figure.savefig(files["png"], dpi=160)
            figure.savefig(files["svg"], metadata={"Date": None})
        except OSError as error:
            raise refused(folder, error) from None
    return files


def table(
    folder: Path, name: str, head: Sequence[str], rows: Iterable[Sequence[Any]]
) -> dict[str, Path]:
    """Write rows of numbers as CSV into the folder; the file by kind. Raises Refusal."""
    path = folder / f"{name}.csv"
    lines = [",".join(head), *(",".join(f"{one:.9g}" for one in row) for row in rows)]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    except OSError as error:
        raise refused(folder, error) from None
    return {"csv": path}


def refused(folder: Path, error: OSError) -> Refusal:
    """That the folder cannot be written."""
    return Refusal(f"--out {str(folder)!r} cannot be written: {error.strerror}")
