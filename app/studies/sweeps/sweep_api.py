"""A sweep from a script or a notebook: the same runs and the same store as on the command line."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from agents.individuals import Distribution, as_distribution
from agents.spec import Spec
from app.studies.key_lines import KeyLocations
from app.studies.sweeps.checked_sweep import Sweep, read_sweep, sweep_of
from app.studies.sweeps.sweep_file import RunOptions
from app.studies.sweeps.sweep_results import Results
from app.studies.sweeps.sweep_runner import run_sweep
from app.studies.workers.process_executor import cores
from worlds.input_error import InputError, shorten

TEMPORARY: list[tempfile.TemporaryDirectory[str]] = []
"""Folders that are gone with this process."""
CALL = "flockscope.sweep"


def sweep(
    what: str | Path | Spec,
    *,
    vary: Mapping[str, Any] | None = None,
    runs: int = 10,
    ticks: int = 1000,
    observe: Sequence[str | Mapping[str, Any]] = (),
    until: str = "",
    hold: int = 1,
    where: str = "",
    folder: str | Path | None = None,
    workers: int | None = None,
    tell: Callable[[str], Any] | None = None,
    **words: Any,
) -> Results:
    """Make the runs of a sweep that are not there yet, and return all of them.

    Parameters
    ----------
    what: a FILE.toml, which says all the rest; or the name of a model; or a `Spec`.
    vary: the axes by name, each a list, an array, or a dictionary with `from`, `to`, `count` (or
        `step`) and, if wanted, `scale = "log"`. Every value is run with every value of the others.
        `s.mean` and `s.spread` are axes where agents differ in `s`.
    runs: runs of each cell, with the seeds 1, 2, ...
    ticks: ticks of a run, at most.
    observe: observables by name, or as a table [[observe]] of a file has them, such as
        `{"name": "polarisation", "over": 100}` or `{"measure": "mine.py:width"}`.
    until: what ends a run, such as "consistency >= 0.9984", once it has held for `hold` ticks.
    where: a condition between axes: only cells for which it holds are run.
    folder: where the runs are kept, so that the same call goes on after any stop; without one they
        are gone with this process.
    workers: processes, by default as many as there are cores.
    tell: hears what is compiled, how many runs there are, and of versions that have changed.
    words: options and parameters of all runs, as `Flock` takes them; distributions, too.

    Raises InputError for whatever cannot be run, before anything is. A run that raises is a row
    with the status `failed`.
    """
    axes = {
        name: axis if isinstance(axis, Mapping) else axis_values(name, axis)
        for name, axis in (vary or {}).items()
    }
    design = {"kind": "grid", "where": where, "axes": axes} if vary else None
    arguments = StudyArguments(what, runs, ticks, observe, words, until, hold)
    sweep = arguments.sweep(design, tell)
    folder = result_folder(folder)
    run_sweep(sweep, folder, workers=workers or cores(), tell=tell)
    return Results(folder)


def result_folder(folder: str | Path | None) -> Path:
    """The folder, or one that is gone with this process."""
    if folder is None:
        TEMPORARY.append(tempfile.TemporaryDirectory(prefix="flockscope-sweep-"))
        folder = TEMPORARY[-1].name
    return Path(folder)


@dataclass(frozen=True)
class StudyArguments:
    """What a call of `sweep`, `sensitivity` or `optimise` says of its runs, as `sweep` takes it."""

    what: str | Path | Spec
    runs: int
    ticks: int
    observe: Sequence[str | Mapping[str, Any]]
    words: Mapping[str, Any]
    until: str = ""
    hold: int = 1

    @property
    def is_file(self) -> bool:
        """Whether `what` names a file, which says all that is to be run."""
        what = self.what
        return isinstance(what, Path) or (isinstance(what, str) and what.endswith(".toml"))

    def demand_nothing_else(self, allowed: str, *more: Any) -> None:
        """Refuse what a file says itself; `more` are arguments of one kind of study."""
        if self.words or self.observe or self.until or any(more):
            raise InputError(f"{str(self.what)!r} says itself {allowed}")

    def table(self) -> dict[str, Any]:
        """What a file would say of the runs, but for their design. Raises InputError."""
        what = self.what
        run: dict[str, Any] = spec_table(what) if isinstance(what, Spec) else {"model": str(what)}
        run["ticks"] = self.ticks
        for name, value in self.words.items():
            if name in RunOptions.model_fields:
                run[name] = plain_value(value)
            else:
                run.setdefault("parameters", {})[name] = plain_value(value)
        values: dict[str, Any] = {"run": run, "replicates": {"count": self.runs}}
        if self.until:
            values["stop"] = {"when": self.until, "hold": self.hold}
        if self.observe:
            values["observe"] = [
                {"name": entry} if isinstance(entry, str) else dict(entry) for entry in self.observe
            ]
        return values

    def sweep(self, design: Mapping[str, Any] | None, tell: Callable[[str], Any] | None) -> Sweep:
        """The sweep that is asked for. Raises InputError."""
        if self.is_file:
            self.demand_nothing_else("what is run: give folder and workers only", design)
            return read_sweep(Path(str(self.what)), tell)
        values = self.table()
        if design is not None:
            values["design"] = [dict(design)]
        return sweep_of(values, KeyLocations(CALL), Path(), tell)


def spec_table(spec: Spec) -> dict[str, Any]:
    """A spec as the table [run] of a file. Raises InputError for what a file cannot say."""
    if spec.start != "random" or spec.layout is not None or not isinstance(spec.world, str | None):
        raise InputError(
            "a sweep needs a world with a name or a file, and random starts: write the world to a "
            "file and name that"
        )
    values = spec.model_dump(exclude_none=True, exclude={"seed", "start", "versions", "layout"})
    values["parameters"] |= values.pop("individuals")
    values = {key: value for key, value in values.items() if value or key not in ("kinds", "to")}
    return {key: plain_value(value) for key, value in values.items()}


def axis_values(name: str, axis: Any) -> list[Any]:
    """The values of an axis as a file has them, distributions as text. Raises InputError.

    >>> from agents.individuals import one_of
    >>> axis_values("s", [3, one_of(2, 4), [2.5, 3.5]])
    [3, 'one_of(2, 4)', 'each(2.5, 3.5)']
    """
    if isinstance(axis, str) or not isinstance(axis, Iterable):
        text = str(axis) if isinstance(axis, Distribution) else shorten(axis)
        raise InputError(f"{name} = {text} is not allowed as an axis: a list of values is needed")
    values = [plain_value(value) for value in axis]
    return [
        value if found is None else found.to_text()
        for value, found in zip(values, map(as_distribution, values), strict=True)
    ]


def axis_bounds(axis: Any) -> Any:
    """An axis as a file has it: a pair are its bounds.

    >>> axis_bounds((0.0, 6.0)), axis_bounds([1, 2, 3])
    ({'from': 0.0, 'to': 6.0}, [1, 2, 3])
    """
    if isinstance(axis, Mapping):
        return dict(axis)
    values = axis_values("axis", axis)
    if len(values) == 2 and all(isinstance(end, int | float) for end in values):
        return {"from": float(values[0]), "to": float(values[1])}
    return values


def plain_value(value: Any) -> Any:
    """Arrays, NumPy's numbers and distributions as a file has them."""
    if isinstance(value, Distribution):
        return value.to_value()
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple):
        return [plain_value(item) for item in value]
    return value
