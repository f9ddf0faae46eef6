"""What the processes of a class's questions do: runs, pictures and files, and curves.

Each has a process of its own: so a run that takes long keeps neither the class from being kept nor
its picture from being drawn.
"""

from __future__ import annotations

import signal
import time
from dataclasses import dataclass
from pathlib import Path

from agents.spec import CompleteSpec
from app.classroom.class_file import ClassState, packed, save
from app.classroom.collect.class_curve import ClassCurve, CurveAsked, curve_of, find_curve
from app.classroom.collect.class_picture import picture
from app.classroom.collect.collection import Collection
from app.classroom.collect.hand_in import Point, demand_answer, hand_in, run_of, warm_up
from app.classroom.collect.question import Question
from app.classroom.collect.run_cost import estimate_pairs
from app.results_folder import make_folder
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.lab.sweeps.laboratory_sweeps import Sweeps
from worlds.input_error import InputError

DRAW_NICENESS = 5
"""Of the process that draws and saves: flocks, of 10, come after it."""
USUAL = 2.0
"""Times the work of the question's dearest run, up to which a run is a usual one."""


@dataclass(frozen=True)
class MadeRun:
    """A run that was handed in, and what it took."""

    point: Point
    seconds: float
    """Of processor time."""


class QuestionRunWorker:
    """Makes runs one after the other.

    A run has so much processor time, counted from its start: then the system ends this process.
    Only processor time tells anything on a machine that many share; and compiled code, which may be
    at one call for the whole run, hears of no other way.
    """

    def warm_up(self, question: Question, scene: CompleteSpec) -> None:
        """Compile what the runs of a question call."""
        warm_up(question, scene)

    def measure_usual(self, question: Question, scene: CompleteSpec, limit: float) -> float:
        """Processor time (s) of a question's dearest run of the scene, made once to see."""
        spec = dearest(question, scene)
        warm_up(question, spec)
        with ProcessorTimeLimit(limit):
            begun = time.process_time()
            run_of(question, spec, 1)
            return time.process_time() - begun

    def make_usual(
        self, question: Question, student: str, ran: str, scene: CompleteSpec, limit: float
    ) -> MadeRun | None:
        """The result of a student whose laboratory runs the scene `ran`, TOML. Raises InputError.

        None for a run that is other than usual: of another model, or of much more work.
        """
        with ProcessorTimeLimit(limit):
            begun = time.process_time()
            spec = spec_of(ran, student)
            demand_answer(question, spec)
            usual = USUAL * estimate_pairs(dearest(question, scene), question.ticks)
            if spec.model != question.model or estimate_pairs(spec, question.ticks) > usual:
                return None
            point = hand_in(question, student, spec, scene)
            return MadeRun(point, time.process_time() - begun)

    def make_any(
        self, question: Question, student: str, ran: str, scene: CompleteSpec, limit: float
    ) -> MadeRun:
        """Likewise, whatever it is; what has to be compiled for it first is not counted."""
        spec = spec_of(ran, student)
        demand_answer(question, spec)
        warm_up(question, spec)
        with ProcessorTimeLimit(limit):
            begun = time.process_time()
            point = hand_in(question, student, spec, scene)
            return MadeRun(point, time.process_time() - begun)


class ProcessorTimeLimit:
    """Ends the process that spends more processor time (s) within it, where the system can."""

    def __init__(self, seconds: float):
        self.seconds = seconds

    def __enter__(self) -> None:
        if hasattr(signal, "setitimer"):  # on Windows only whoever asks has a limit, by the clock
            signal.setitimer(signal.ITIMER_PROF, self.seconds)

    def __exit__(self, *_: object) -> None:
        if hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_PROF, 0.0)


def spec_of(ran: str, student: str) -> CompleteSpec:
    """The run of a scene, TOML. Raises InputError."""
    return SavedScene.from_toml(ran, f"the run of {student}").spec


def dearest(question: Question, scene: CompleteSpec) -> CompleteSpec:
    """The run of the class's scene with that value of the question that is the most work."""
    values = question.values or [question.value_of(scene)]
    runs = [question.with_value(scene, value) for value in values]
    return max(runs, key=lambda one: estimate_pairs(one, question.ticks))


class DrawWorker:
    """Draws pictures of results, and writes the file of the class; usual runs go before it."""

    def picture(self, collection: Collection, kind: str) -> bytes:
        """The picture of a question. Raises InputError."""
        return picture(collection, kind)

    def save(self, state: ClassState, path: Path) -> None:
        """Write the file of a class. Raises InputError."""
        make_folder(path.parent)
        save(state, path)

    def packed(self, state: ClassState) -> bytes:
        """The file of a class. Raises InputError."""
        return packed(state)


class CurveWorker:
    """Finds and makes the curves that sweeps have of questions; `results`: the folder of sweeps."""

    def __init__(self, results: Path):
        self.results = results
        self.sweeps: Sweeps | None = None

    def find_curve(self, question: Question, scene: CompleteSpec) -> ClassCurve | None:
        """The curve of a sweep that is there."""
        return find_curve(self.results.absolute(), question, scene)

    def begin_curve(self, question: Question, scene: CompleteSpec) -> str:
        """Begin the sweep that makes the curve of a question; its name. Raises InputError."""
        if self.sweeps is None:
            self.sweeps = Sweeps(self.results)
        return self.sweeps.begin(CurveAsked(question, scene))

    def curve(
        self, name: str, question: Question, scene: CompleteSpec
    ) -> tuple[ClassCurve | None, str]:
        """The curve of a sweep that was begun here, as far as it is, and how far it is in words.

        The words are empty once it has ended. Raises InputError if it cannot be read.
        """
        if self.sweeps is None:
            raise InputError(f"the sweep {name} ended with its process: make the curve again")
        listed, fault = self.sweeps.seen.of(name), self.sweeps.seen.fault
        making = self.sweeps.making is not None
        if listed is None or not listed.done:
            return None, fault or ("the sweep begins" if making else "")
        curve = curve_of(self.sweeps.results / name, question, scene)
        return curve, f"the sweep has made {listed.done} runs" if listed.runs else ""
