"""Runs that were kept in a file, as a table for Python: a laboratory's, or a class's results."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING

from agents.flock import Flock
from app.classroom.class_file import ENDINGS, load
from app.classroom.collect.class_table import headed
from app.viewer.gallery.saved_scene import read_scene
from app.viewer.lab.runs_file import RunsFile, spec_of
from app.viewer.measuring.kept_runs import KeptRun, runs_table
from app.viewer.measuring.observable_curves import ObservableHistory
from app.viewer.measuring.run_conditions import ConditionHistory
from worlds.input_error import InputError

if TYPE_CHECKING:
    import pandas as pd


def runs_frame(path: str | Path) -> pd.DataFrame:
    """The runs that a laboratory has kept in a file, or those that a class has handed in.

    A row for each run in the order in which they ended: `run`, `name`, `model`, `seed`, `agents`,
    `world`, `ticks`, every parameter and option with which it began, `changed` (what was changed
    while it ran, in words) and what each observable came to, with its unit. `spec` is the run as it
    began: `Flock(row.spec)` makes it again.

    Of a class's file (`.zip`) `name` is the student's; `question`, `measure` (what was measured,
    with its unit), `result`, `status`, `counts` and `reason` stand before `spec`.

    Raises InputError for what is no such file; warns of what was left out.
    """
    path = Path(path)
    return class_frame(path) if path.suffix.lower() in ENDINGS else laboratory_frame(path)


def laboratory_frame(path: Path) -> pd.DataFrame:
    """The runs of a laboratory. Raises InputError."""
    import pandas as pd

    found = RunsFile(path).found
    if not found.runs and not path.exists():
        raise InputError(f"runs {str(path)!r} cannot be read: there is no such file")
    if found.skipped:
        warnings.warn(found.told(str(path)), stacklevel=3)
    frame = pd.DataFrame(runs_table(found.runs))
    frame["spec"] = [spec_of(run.course.conditions) for run in reversed(found.runs)]
    return frame


def class_frame(path: Path) -> pd.DataFrame:
    """The results of all questions of a class. Raises InputError."""
    import pandas as pd

    results = [
        (collection.question, point, counts)
        for collection in load(path).questions
        for point, counts in zip(collection.points, collection.counting, strict=True)
    ]
    specs = [read_scene(path.name, point.spec.encode()).spec for _, point, _ in results]
    runs = []
    for number, (spec, (_, point, _)) in enumerate(zip(specs, results, strict=True), 1):
        history = ConditionHistory.begin(Flock(spec))
        runs.append(KeptRun(number, ObservableHistory(history, point.ticks, {}), point.student))
    frame = pd.DataFrame(runs_table(runs))
    frame["question"] = [question.title for question, _, _ in results]
    frame["measure"] = [headed(one.column, one.result_unit) for one, _, _ in results]
    frame["result"] = [point.result for _, point, _ in results]
    frame["status"] = [point.status for _, point, _ in results]
    frame["counts"] = [counts for _, _, counts in results]
    frame["reason"] = [point.reason for _, point, _ in results]
    frame["spec"] = specs
    return frame
