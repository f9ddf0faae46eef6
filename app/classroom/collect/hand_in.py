"""A result that is handed in: the student's run, made and measured by the sweep engine.

`hand_in` is what a worker process is asked for; it is plain, and all that it takes and gives can be
sent to a process.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import UTC, datetime

from agents.catalogue import FILES, MODELS
from agents.flock import Flock
from agents.spec import Spec
from app.classroom.collect.bounds import demand_cheap
from app.classroom.collect.differences import Ran, differences
from app.classroom.collect.question import Question
from app.experiments.runs.outcome import Outcome, Status, failure
from app.experiments.sweeps.making.one_run import Wanted
from app.viewer.gallery.saved_scene import TEXTS, SavedScene
from app.viewer.lab.sweeps.asked import AGENTS
from worlds.refusal import Refusal

SECONDS = 30.0
"""After which whoever asked for a result kills the process that makes it: bounds are of steps, and
a flock that is crowded takes longer for one."""


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
    """The run as TOML, with nothing left open: the same spec gives the same result."""
    when: datetime
    """In UTC, to the second."""
    differs: tuple[str, ...] = ()
    """How the run is not that of the class's scene, in words, seed and parameter apart."""

    def scene(self, question: Question) -> SavedScene:
        """What opens the run, at its first tick. Raises Refusal."""
        made = SavedScene.from_toml(self.spec_of_scene(), f"the result of {self.student}")
        return SavedScene(
            title=f"{self.student}: {question.parameter} = {self.value:g}"[: TEXTS["title"]],
            spec=made.spec,
            watch=self.told(question)[: TEXTS["watch"]],
        )

    def spec_of_scene(self) -> str:
        """The run as the table of a scene."""
        return SavedScene("", Spec.from_toml(self.spec, self.student)).to_toml()

    def told(self, question: Question) -> str:
        """The result in a sentence."""
        unit = "" if question.unit == "1" else f" {question.unit}"
        at = f"{question.parameter} = {self.value:g}{unit}, seed {self.seed}"
        if self.result is None:
            return f"{self.student}, {at}: {self.reason}."
        return f"{self.student}, {at}: {self.result:.4g} {question.result_words}."


def hand_in(
    question: Question, student: str, spec: Spec, scene: Spec, when: datetime | None = None
) -> Point:
    """Make a student's run for a question, from its first tick, and measure it.

    `spec` is their run as it is now, `scene` that of the class, `when` by default now. Raises
    Refusal, before anything is run, for what cannot be run, is no answer, or would take too long.
    """
    demand_answer(question, spec)
    value = question.value_of(spec)
    flock = Flock(spec)
    meant = as_meant(question, scene, value, flock.seed)
    seeded = spec.but(seed=flock.seed)
    outcome = run_of(question, seeded)
    result, reason = measured(question, outcome)
    return Point(
        student,
        value,
        result,
        outcome.status,
        reason,
        flock.seed,
        outcome.ticks,
        flock.spec.to_toml(),
        (when or datetime.now(UTC)).astimezone(UTC).replace(microsecond=0),
        differences(Ran.of(flock), meant, question.parameter),
    )


def demand_answer(question: Question, spec: Spec) -> None:
    """Refuse a run that is no answer to a question. Raises Refusal."""
    if spec.model in FILES:
        raise Refusal(f"{spec.model} is a model of a file: hand in one of the catalogue's")
    if spec.start != "random":
        raise Refusal(
            "this run began from given places: press Setup, which begins one that can be made again"
        )
    if spec.model not in MODELS:
        raise Refusal(f"there is no model {spec.model!r} here")
    demand_cheap(question, spec)


def run_of(question: Question, spec: Spec) -> Outcome:
    """The run as the sweep engine makes it; one that raises is an outcome too."""
    making = question.making
    making.prepare()
    assert spec.seed is not None
    try:
        return making.run(Wanted(spec), spec.seed)
    except Exception as error:
        return failure(error)


def measured(question: Question, outcome: Outcome) -> tuple[float | None, str]:
    """The result of a run, and why there is none."""
    if outcome.status == "failed":
        return None, f"the run failed: {outcome.reason}"[:200]
    value = outcome.values.get(question.column)
    if value is None:
        what = question.measure.until
        return None, f"{what} did not hold for {question.measure.hold} ticks in {question.ticks}"
    if not math.isfinite(value):
        return None, f"{question.measure.observe} has no value there"
    return float(value), outcome.astray


def as_meant(question: Question, scene: Spec, value: float, seed: int) -> Ran:
    """The run of the class's scene with a student's value and seed."""
    meant = scene.but(seed=seed)
    if question.parameter == AGENTS or question.parameter in meant.parameters:
        meant = question.with_value(meant, value)
    return Ran.of(Flock(meant))


def warm_up(question: Question, scene: Spec) -> None:
    """Compile what a run of the question calls, so that the first student need not wait."""
    making = question.making
    making.prepare()
    making.try_out(Flock(scene.but(seed=1)))
