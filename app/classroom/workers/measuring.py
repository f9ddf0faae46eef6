"""What a process does that makes the runs handed in, and draws pictures of them."""

from __future__ import annotations

from pathlib import Path

from agents.spec import Spec
from app.classroom.class_file.saving import packed, save
from app.classroom.class_file.state import ClassState
from app.classroom.collect.collection import Collection
from app.classroom.collect.curve import Curve, CurveAsked, curve_of, find_curve
from app.classroom.collect.hand_in import Point, hand_in, warm_up
from app.classroom.collect.picture import picture
from app.classroom.collect.question import Question
from app.results import make_folder
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.lab.sweeps.sweeps import Sweeps


class Measuring:
    """Makes runs one after the other; `results`: the folder of sweeps."""

    def __init__(self, results: Path):
        self.results = results
        self.sweeps: Sweeps | None = None

    def warm_up(self, question: Question, scene: Spec) -> None:
        """Compile what the runs of a question call."""
        warm_up(question, scene)

    def hand_in(self, question: Question, student: str, ran: str, scene: Spec) -> Point:
        """The result of a student whose laboratory runs the scene `ran`, TOML. Raises Refusal."""
        spec = SavedScene.from_toml(ran, f"the run of {student}").spec
        return hand_in(question, student, spec, scene)

    def picture(self, collection: Collection, kind: str, curve: Curve | None) -> bytes:
        """The picture of a question. Raises Refusal."""
        return picture(collection, kind, curve)

    def save(self, state: ClassState, path: Path) -> None:
        """Write the file of a class. Raises Refusal."""
        make_folder(path.parent)
        save(state, path)

    def packed(self, state: ClassState) -> bytes:
        """The file of a class. Raises Refusal."""
        return packed(state)

    def find_curve(self, question: Question, scene: Spec) -> Curve | None:
        """The curve of a sweep that is there."""
        return find_curve(self.results.absolute(), question, scene)

    def begin_curve(self, question: Question, scene: Spec) -> str:
        """Begin the sweep that makes the curve of a question; its name. Raises Refusal."""
        if self.sweeps is None:
            self.sweeps = Sweeps(self.results)
        return self.sweeps.begin(CurveAsked(question, scene))

    def curve(self, name: str, question: Question, scene: Spec) -> tuple[Curve | None, str]:
        """The curve of a sweep that was begun here, as far as it is, and how far it is in words.

        The words are empty once it has ended. Raises Refusal if it cannot be read.
        """
        assert self.sweeps is not None
        listed, fault = self.sweeps.seen.of(name), self.sweeps.seen.fault
        making = self.sweeps.making is not None
        if listed is None or not listed.done:
            return None, fault or ("the sweep begins" if making else "")
        curve = curve_of(self.sweeps.results / name, question, scene)
        return curve, f"the sweep has made {listed.done} runs" if listed.runs else ""
