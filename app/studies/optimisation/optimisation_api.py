"""An optimisation from a script or a notebook: the same runs and answer as on the command line."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from agents.spec import Spec
from app.studies.key_lines import KeyLocations
from app.studies.optimisation.evaluations import EvaluatedPoint
from app.studies.optimisation.optimisation_picture import draw
from app.studies.optimisation.optimisation_result import OptimisationResult
from app.studies.optimisation.optimisation_runner import optimise as carry_out
from app.studies.optimisation.study import Study, read_study, study_of
from app.studies.search import Algorithm
from app.studies.sweeps.sweep_api import StudyArguments, axis_bounds, result_folder
from app.studies.sweeps.sweep_results import Results
from worlds.input_error import InputError

CALL = "flockscope.optimise"


@dataclass(frozen=True, repr=False)
class Optimum:
    """What a search has come to."""

    study: Study
    course: list[EvaluatedPoint]
    answer: OptimisationResult
    runs: Results
    """All runs, as `sweep` returns them."""

    def __repr__(self) -> str:
        return f"<Optimum of {self.study.title}, {len(self.course)} points tried>"

    @property
    def words(self) -> list[str]:
        """The answer, sentence by sentence."""
        return list(self.answer.words())

    @property
    def best(self) -> dict[str, Any]:
        """The best point; of several objectives the first of the front. Raises InputError if
        none."""
        if not self.answer.best:
            raise InputError(self.words[0])
        return dict(self.answer.best[0].point)

    @property
    def spec(self) -> Spec:
        """The run of the best point: `Flock(found.spec)`. Raises InputError if there is none."""
        return Spec.from_toml(self.answer.best[0].spec if self.best else "", CALL)

    @property
    def columns(self) -> dict[str, list[Any]]:
        """The default and the best, or the front, on fresh seeds, as lists by column."""
        columns: dict[str, list[Any]] = {}
        for point in (self.answer.default, *self.answer.best):
            row: dict[str, Any] = {"what": point.what, **point.point}
            for name, mean in zip(self.answer.goals, point.means, strict=True):
                row |= {name: mean and mean.value, f"{name} half interval": mean and mean.half}
            for name, value in row.items():
                columns.setdefault(name, []).append(value)
        return columns

    def to_pandas(self) -> Any:
        """The same as `pandas.DataFrame`."""
        import pandas as pd

        return pd.DataFrame(self.columns)

    def plot(self, path: str | Path) -> None:
        """Draw the convergence, and of several objectives the front: PNG, SVG or PDF."""
        draw(self.study, self.course, self.answer, Path(path))

    def _repr_html_(self) -> str:
        words = "".join(f"<li>{line}</li>" for line in self.words)
        return f"{self.to_pandas()._repr_html_()}<ul>{words}</ul>"


def optimise(
    what: str | Path | Spec,
    *,
    vary: Mapping[str, Any] | None = None,
    least: str = "",
    most: str = "",
    keep: Sequence[str] = (),
    algorithm: Algorithm = "ga",
    evaluations: int = 64,
    population: int | None = None,
    seed: int = 1,
    runs: int = 10,
    fresh: int = 100,
    ticks: int = 1000,
    observe: Sequence[str | Mapping[str, Any]] = (),
    until: str = "",
    hold: int = 1,
    where: str = "",
    folder: str | Path | None = None,
    workers: int | None = None,
    tell: Callable[[str], Any] | None = None,
    **words: Any,
) -> Optimum:
    """Search for the values of parameters that make a measure least or most.

    Parameters
    ----------
    what: a FILE.toml, which says all the rest; or the name of a model; or a `Spec`.
    vary: the axes by name, each a pair of bounds, or a dictionary with `from`, `to` and, if wanted,
        `scale = "log"`, or a list of values to choose between.
    least, most: the observable whose mean is to be the least, or the most; `k` is the tick from
        which `until` has held. With both, and the algorithm `nsga2`, a front is found.
    keep: what means of observables have to keep to, such as `"polarisation >= 0.9"`.
    algorithm: `ga`, `pso`, `cma` or `nsga2`.
    evaluations: points that are tried, at most; population: those of a generation.
    seed: of the search. runs: runs of each point, with the seeds 1, 2, ...
    fresh: runs with seeds that the search has not seen, on which its best is told.
    ticks, observe, until, hold, folder, workers, tell, words: as `sweep` takes them.

    Begun again with the same folder it goes on where it was stopped. Raises InputError.
    """
    arguments = StudyArguments(what, runs, ticks, observe, words, until, hold)
    if arguments.is_file:
        searched = "what is searched: give folder and workers"
        arguments.demand_nothing_else(searched, vary, least, most, keep, where)
        study = read_study(Path(str(what)))
    else:
        values = arguments.table()
        values["replicates"]["fresh"] = fresh
        values["search"] = {
            "algorithm": algorithm,
            "axes": {name: axis_bounds(axis) for name, axis in (vary or {}).items()},
            "where": where,
            "evaluations": evaluations,
            "seed": seed,
        }
        if population is not None:
            values["search"]["population"] = population
        aims = (("least", least), ("most", most))
        values["objective"] = [{"observable": name, "aim": aim} for aim, name in aims if name]
        values["constraint"] = [{"says": condition} for condition in keep]
        study = study_of(values, KeyLocations(CALL), Path())
    place = result_folder(folder)
    done = carry_out(study, place, workers=workers, tell=tell)
    if done.answer is None:
        raise InputError(f"the search in {str(place)!r} was asked to stop: the same call goes on")
    return Optimum(study, done.course, done.answer, Results(place))
