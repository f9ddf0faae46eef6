"""A result that is handed in: the student's run, made and measured by the sweep engine.

`hand_in` is what a worker process is asked for; it is plain, and all that it takes and gives can be
sent to a process.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from datetime import UTC, datetime

from agents.catalogue import FILES, MODELS
from agents.flock import Flock
from agents.spec import CompleteSpec, versions
from app.classroom.collect.differences import RunIdentity, differences, on_one_line
from app.classroom.collect.question import Question, with_axes
from app.studies.charts.run_group import RunGroup
from app.studies.run_axes import AGENTS, is_whole_axis, read_axis
from app.studies.runs.database import Outcome, Status, failure
from app.studies.sweeps.sweep_job import RunRequest
from app.viewer.gallery.saved_scene import TEXTS, SavedScene, read_scene
from app.viewer.run.run_preset import preset_spec
from worlds.input_error import InputError

SECONDS = 8.0
"""Of processor time of a run, from its start, after which it is ended: bounds are of a flock spread
evenly, and one that crowds together takes longer."""
VERSIONS = versions()


@dataclass(frozen=True)
class Point:
    """One result of a student."""

    student: str
    value: float
    """Of the parameter, in its unit, whatever the student chose."""
    result: float | None
    """What was measured; None where it did not happen, or the run failed."""
    status: Status
    """ok, gave-up where a condition did not come to hold, failed where the run raised."""
    reason: str
    """Why there is no result."""
    seed: int
    ticks: int
    """That were run."""
    spec: str
    """The run as TOML, with all its parameters: the same spec gives the same result."""
    when: datetime
    """In UTC, to the second."""
    differs: tuple[str, ...] = ()
    """How the run is not that of the class's scene, in words, apart from what may be chosen."""
    free: tuple[float, ...] = ()
    """Values of the question's free parameters, in its order."""

    def scene(self, question: Question) -> SavedScene:
        """What opens the run, at its first tick. Raises InputError."""
        made = read_scene(f"the result of {self.student}", self.spec.encode())
        title = f"{self.student}: {question.parameter} = {self.value:g}"
        watch = self.told(question)
        return replace(made, title=title[: TEXTS["title"]], watch=watch[: TEXTS["watch"]])

    def told(self, question: Question) -> str:
        """The result in a sentence."""
        at = f"{question.parameter} = {question.value_text(self.value)}, seed {self.seed}"
        if self.result is None:
            return f"{self.student}, {at}: {self.reason}."
        said = f"{self.student}, {at}: {question.result_words}: {self.result:.4g}."
        differs = f" Not the class's scene ({', '.join(self.differs)}): in no mean."
        return f"{said}{differs}" if self.differs else said


@dataclass(frozen=True)
class ResultGroup(RunGroup):
    """Results that are taken together."""

    value: float
    """Of the parameter: theirs, or in the middle of theirs, its mean."""
    low: float
    high: float
    """Between which theirs lie."""
    values: tuple[float, ...] = ()
    """Results of different runs: one that two students handed in counts once."""
    gave_up: int = 0
    """Runs in which it did not happen; they are in no mean."""
    broken: int = 0


def hand_in(
    question: Question,
    student: str,
    spec: CompleteSpec,
    scene: CompleteSpec,
    when: datetime | None = None,
) -> Point:
    """Make a student's run for a question, from its first tick, and measure it.

    `spec` is their run as it is now, `scene` that of the class, `when` by default now. Raises
    InputError, before anything is run, for what cannot be run, is no answer, or would take too
    long.
    """
    demand_answer(question, spec)
    value = question.value_of(spec)
    flock = Flock(spec)
    kept = complete_run(spec.with_values(seed=flock.seed), flock)
    meant = as_meant(question, scene, spec, flock.seed)
    outcome = run_of(question, spec, flock.seed)
    result, reason = measured(question, outcome)
    return Point(
        student,
        value,
        result,
        outcome.status,
        reason,
        flock.seed,
        outcome.ticks,
        kept,
        (when or datetime.now(UTC)).astimezone(UTC).replace(microsecond=0),
        differences(RunIdentity.of(flock), meant, question.open),
        tuple(question.value_of(spec, name) for name in question.free),
    )


def complete_run(spec: CompleteSpec, flock: Flock) -> str:
    """A run with all its parameters, as a scene opens it again. Raises InputError if none can."""
    made = preset_spec(**dict(spec)).with_parameters(
        flock.all_parameters,
        agents=flock.options.agents,
        informed=flock.options.informed,
        versions=VERSIONS,
    )
    text = made.to_toml()
    read_scene("this run", text.encode())
    return text


def demand_answer(question: Question, spec: CompleteSpec) -> None:
    """Refuse a run that is no answer to a question. Raises InputError."""
    for name in spec.models:
        if name in FILES:
            raise InputError(f"{name} is a model of a file: hand in one of the catalogue's")
    if spec.start != "random":
        raise InputError(
            "this run began from given places: press Setup, which begins one that can be made again"
        )
    if spec.model not in MODELS:
        raise InputError(f"there is no model {spec.model!r} here")
    question.demand_cheap(spec)


def run_of(question: Question, spec: CompleteSpec, seed: int) -> Outcome:
    """The run as the sweep engine makes it; one that raises is an outcome too."""
    making = question.making
    making.prepare()
    try:
        return making.run(RunRequest(spec), seed)
    except Exception as error:
        return failure(error)


def measured(question: Question, outcome: Outcome) -> tuple[float | None, str]:
    """The result of a run, and why there is none."""
    if outcome.status == "failed":
        return None, on_one_line(f"the run failed: {outcome.reason}", 200)
    value = outcome.values.get(question.column)
    if value is None:
        return None, f"it did not happen in {question.ticks} ticks: {question.condition_words}"
    if not math.isfinite(value):
        return None, f"{question.measure.observe} has no value there"
    return float(value), on_one_line(outcome.astray, 200)


def as_meant(question: Question, scene: CompleteSpec, spec: CompleteSpec, seed: int) -> RunIdentity:
    """The run of the class's scene with a student's seed, and with their value of what is asked.

    `spec`: their run. What they may change of kinds beside that is as they have it.
    """
    meant = question.begun_scene(scene).with_values(seed=seed)
    axes = [read_axis(name, question.model_of(name)) for name in question.open]
    names = [axis.name for axis in axes if axis.kind or axis.moment]
    if question.parameter == AGENTS or question.parameter in meant.parameters:
        names.append(question.parameter)
    values = {name: question.value_of(spec, name) for name in names}
    whole = {
        name: round(value)
        for name, value in values.items()
        if is_whole_axis(question.model_of(name), name)
    }
    meant = with_axes(meant, values | whole)
    return RunIdentity.of(Flock(meant))


def warm_up(question: Question, scene: CompleteSpec) -> None:
    """Compile what a run of the question calls, so that the first student need not wait."""
    making = question.making
    making.prepare()
    making.try_out(Flock(scene.with_values(seed=1)))
