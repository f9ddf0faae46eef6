"""The figures of papers, one file each: what is measured of its runs, and how it is drawn.

A file here may have kinds of experiments, subclasses of `Settings`, and a table `PICTURES`
of functions that draw. Each of these takes by name what it needs of: `figure`, the figure of
matplotlib; `experiment`; `made`, its verdicts; `main`, those on its first measure; and `seed`, that
of the run which is shown.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from types import ModuleType

from app.figure import new_figure, write_figure
from app.results_folder import PICTURES
from app.studies.experiment import Experiment
from app.studies.judge.verdict import Verdict, main_verdicts
from app.studies.measure import Settings


@cache
def figure_files() -> tuple[ModuleType, ...]:
    """The modules of this folder."""
    return tuple(import_module(f"{__name__}.{entry.name}") for entry in iter_modules(__path__))


@cache
def kinds() -> dict[str, type[Settings]]:
    """The kinds of experiments by name."""
    classes = (
        value
        for module in figure_files()
        for value in vars(module).values()
        if isinstance(value, type) and issubclass(value, Settings) and "kind" in vars(value)
    )
    return {settings.kind: settings for settings in classes}


@cache
def pictures() -> dict[str, Callable[..., None]]:
    """The functions that draw, by the names of pictures."""
    return {
        name: function
        for module in figure_files()
        for name, function in getattr(module, "PICTURES", {}).items()
    }


def draw(
    experiment: Experiment, verdicts: list[Verdict], folder: Path, seed: int = 1
) -> dict[str, Path]:
    """Draw the picture into the folder; returns the files by kind.

    `seed` is that of the run which pictures of single runs show. Raises InputError.
    """
    with new_figure() as figure:
        offered = {
            "figure": figure,
            "experiment": experiment,
            "verdicts": verdicts,
            "main": main_verdicts(verdicts),
            "seed": seed,
        }
        function = pictures()[experiment.picture]
        function(**{name: offered[name] for name in inspect.signature(function).parameters})
        figure.suptitle(f"{experiment.title}\n{experiment.source}", x=0.01, ha="left", wrap=True)
        files = {kind: folder / f"{experiment.name}.{kind}" for kind in PICTURES}
        for path in files.values():
            write_figure(figure, path)
    return files
