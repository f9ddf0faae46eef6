"""Kinds in a class: questions about their numbers, and students who play one of them."""

from __future__ import annotations

import asyncio
import csv
import io
import json
from collections import Counter
from dataclasses import replace

import pytest

from agents.kinds import Kind, chase, kind_table
from agents.spec import Spec
from app.classroom import flocks
from app.classroom.class_file import ClassState, SavedStudent, open_class, packed
from app.classroom.class_keeper import restore_class, state_of
from app.classroom.classroom import Classroom
from app.classroom.collect.class_curve import CurveAsked
from app.classroom.collect.collection import Collection
from app.classroom.collect.hand_in import hand_in
from app.classroom.collect.question import question_from_toml, question_of
from app.classroom.collect.question_choices import parameters_of
from app.classroom.front.student_requests import StudentRequests
from app.classroom.question_service import QuestionService
from app.classroom.student import Role
from app.classroom.workers.laboratory_worker import Laboratories
from app.studies.sweeps.checked_sweep import read_sweep
from app.viewer.editing.editor import disc
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.run.run_preset import preset_spec
from tests.classroom.small import WHEN
from tests.classroom.test_server_lessons import run_class, until  # noqa: F401
from worlds.input_error import InputError

SHARK = Kind("shark", 2, v0=0.05, to={"flock": chase(2.0, 1.5, catch=0.1)})
SCENE = preset_spec("vem", agents=20, seed=3, size=3.0, kinds=[SHARK], parameters={"eta": 0.4})
VALUES = {
    "title": "Caught against sharks",
    "parameter": "shark.agents",
    "measure": {"observe": "catches"},
    "ticks": 30,
    "values": [0, 2, 4],
}
HUNT = question_of(VALUES, SCENE)
PLAYED = {"parameter": "shark.v0", "free": ["shark.eta"], "kinds": ["shark", "flock"]}
ROLES = question_of(VALUES | PLAYED | {"values": [0.04, 0.06]}, SCENE)


def test_a_question_is_about_a_number_of_a_kind_of_its_scene():
    assert HUNT.value_of(SCENE) == 2.0
    assert (HUNT.is_whole, HUNT.unit, HUNT.parameter_words) == (True, "1", "shark: agents")
    assert (ROLES.unit, ROLES.parameter_words) == ("length/tick", "shark: speed")
    for value in (0.0, 4.0):
        spec = HUNT.with_value(SCENE, value)
        assert [kind.agents for kind in spec.kinds] == [value]
        assert spec.with_values(kinds=SCENE.kinds) == SCENE
    for question in (HUNT, ROLES):
        assert question_of(json.loads(json.dumps(question.to_values())), SCENE) == question
        assert question_from_toml(question.to_toml(), SCENE, "q.toml") == question


def test_the_form_has_the_numbers_of_kinds_and_every_one_can_be_asked():
    choices = parameters_of(SCENE)
    names = [one.name for one in choices]
    assert names.index("agents") < names.index("shark.agents")
    assert {"shark.v0", "shark.flock.weight", "flock.shark.radius"} < {*names}
    for one in choices:
        json.dumps(vars(one), allow_nan=False)
        values = [value for value in one.suggested if one.low <= value <= one.high]
        made = question_of(VALUES | {"parameter": one.name, "values": values[:2]}, SCENE)
        assert made.with_value(SCENE, values[1]) != SCENE
        assert made.value_of(made.with_value(SCENE, values[1])) == values[1]


def test_a_question_is_about_a_number_of_the_model_of_a_kind(tmp_path):
    """With its range, its unit and its words, also from a file; and a run of it is handed in."""
    loner = Kind("loner", 4, model="gregoire-chate", v0=0.05, to={"flock": "own"})
    scene = SCENE.with_values(kinds=[loner])
    asked = {"parameter": "loner.eta", "values": [0.2, 0.8], "measure": {"observe": "polarisation"}}
    choice = next(one for one in parameters_of(scene) if one.name == "loner.eta")
    assert (choice.high, choice.unit, choice.title) == (1.0, "1", "loner: noise")
    made = question_of(VALUES | asked, scene)
    assert (made.unit, made.parameter_words) == ("1", "loner: noise")
    assert made.with_value(scene, 0.8).kinds[0].parameters == {"v0": 0.05, "eta": 0.8}
    assert question_of(json.loads(json.dumps(made.to_values())), scene) == made
    assert question_from_toml(made.to_toml(), scene, "q.toml") == made
    with pytest.raises(InputError, match=r"loner.eta = 2 is not in \[0, 1\]"):
        question_of(VALUES | asked | {"values": [0.2, 2.0]}, scene)
    with pytest.raises(InputError, match="_kind_models"):
        question_of(VALUES | asked | {"_kind_models": {}}, scene)
    point = hand_in(made, "Ada", made.with_value(scene, 0.2), scene, WHEN)
    assert (point.value, point.status, point.differs) == (0.2, "ok", ())
    (tmp_path / "s.toml").write_text(CurveAsked(made, scene, runs=2).to_toml())
    cells = read_sweep(tmp_path / "s.toml").cells
    assert [cell.axes for cell in cells] == [{"loner.eta": 0.2}, {"loner.eta": 0.8}]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"parameter": "whale.agents"}, "whale.agents: unknown kind 'whale'"),
        ({"parameter": "shark.k"}, "shark.k: k cannot differ"),
        ({"parameter": "flock.shark.catch"}, "only who chases can catch"),
        ({"values": [0, 1.5]}, "shark.agents = 1.5 is not a whole number"),
        ({"values": [0, -1]}, r"shark.agents = -1 is not in \[0, 3000\]"),
        ({"values": [0, 3000], "ticks": 5_000}, "3,020 agents for 5,000 ticks take too long"),
        ({"free": ["whale.v0"]}, "whale.v0: unknown kind 'whale'"),
        ({"kinds": ["whale"]}, r"kinds: unknown kind 'whale'.*known: flock, shark"),
        ({"kinds": ["shark", "shark"]}, "kinds: shark is there twice"),
        ({"kinds": "shark"}, "kinds"),
        ({"kinds": [3]}, "kinds"),
        ({"kinds": ["shark"] * 10}, "kinds"),
    ],
)
def test_what_the_scene_has_not_cannot_be_asked(changes, said):
    with pytest.raises(InputError, match=said):
        question_of(VALUES | changes, SCENE)


def test_a_scene_without_kinds_has_neither_their_numbers_nor_their_roles():
    plain = SCENE.with_values(kinds=[], to={})
    asked = VALUES | {"measure": {"observe": "polarisation"}}
    with pytest.raises(InputError, match=r"shark.agents .* this run has no kinds of agents"):
        question_of(asked, plain)
    with pytest.raises(InputError, match="shark cannot be played: the scene has no kinds"):
        question_of(asked | {"parameter": "eta", "kinds": ["shark"]}, plain)


def test_a_kind_that_looks_far_costs_as_much_as_it_looks():
    """The bound of a run sees how far kinds look, not the rule's reach alone."""
    many = SCENE.with_values(agents=3_000, size=60.0)
    asked = VALUES | {"ticks": 1_500, "values": [0, 2], "measure": {"observe": "polarisation"}}
    question_of(asked, many)
    far = [Kind("shark", 2, to={"flock": chase(2.0, 60.0)})]
    with pytest.raises(InputError, match="agents that each look at 3,000 take too long"):
        question_of(asked, many.with_values(kinds=far))
    with pytest.raises(InputError, match=r"agents that each look at .* take too long"):
        question_of(asked, many.with_values(kinds=[Kind("shark", 2, r=5.0)]))
    loner = Kind("shark", 2, model="gregoire-chate")
    question_of(asked, many.with_values(kinds=[loner], to={}))


def test_a_result_is_at_the_number_of_the_kind_and_differs_by_nothing_else():
    spec = HUNT.with_value(SCENE.with_values(seed=8), 4.0)
    point = hand_in(HUNT, "Ada", spec, SCENE, WHEN)
    assert (point.value, point.status, point.differs) == (4.0, "ok", ())
    other = spec.with_values(kinds=[replace_own(spec.kinds[0], v0=0.06)])
    assert hand_in(HUNT, "Ada", other, SCENE, WHEN).differs == (
        "other v0 of shark: 0.06, not 0.05",
    )
    with pytest.raises(InputError, match="this run has no kinds of agents"):
        hand_in(HUNT, "Ada", spec.with_values(kinds=[], to={}), SCENE, WHEN)


def replace_own(kind: Kind, **own: float) -> Kind:
    return kind.with_parameters(own)


def test_the_curve_of_a_question_is_a_sweep_with_the_kinds(tmp_path):
    asked = CurveAsked(HUNT, SCENE, runs=2)
    (tmp_path / "s.toml").write_text(asked.to_toml())
    made = read_sweep(tmp_path / "s.toml")
    assert [cell.axes for cell in made.cells] == [{"shark.agents": n} for n in (0, 2, 4)]
    assert [cell.spec.kinds[0].agents for cell in made.cells] == [0, 2, 4]


# Who plays what.


def test_students_play_the_kinds_in_turn_and_each_kind_has_all_values():
    collection = Collection(ROLES)
    given = [collection.give(f"student {k}") for k in range(8)]
    assert [one.kind for one in given] == 4 * ["shark", "flock"]
    assert set(Counter((one.kind, one.value) for one in given).values()) == {2}
    spec = collection.begins("student 0", SCENE)
    table = kind_table(spec.kinds, spec.to)
    assert table.kind("shark").parameters == {"r": 1.0, "eta": 0.4, "v0": given[0].value}
    collection.take_back("student 1")
    assert collection.give("another").kind == "flock"


def test_a_player_changes_what_is_free_and_what_is_more_is_told():
    collection = Collection(ROLES)
    spec = collection.begins("Ada", SCENE)
    (shark,) = spec.kinds
    own = spec.with_values(kinds=[replace_own(shark, eta=2.0)])
    point = hand_in(ROLES, "Ada", own, SCENE, WHEN)
    assert (point.value, point.free, point.differs) == (0.04, (2.0,), ())
    more = spec.with_values(kinds=[replace_own(shark, r=1.5)])
    assert hand_in(ROLES, "Ada", more, SCENE, WHEN).differs == ("other r of shark: 1.5, not 1",)


def test_pages_without_sliders_of_kinds_are_asked_for_no_moves(tmp_path):
    """A flock in a browser has the kinds, and values may be given; they move nothing of them."""

    async def scenario() -> None:
        service = QuestionService(tmp_path)
        free = VALUES | {"values": []}
        try:
            for asked in (free, ROLES.to_values(), VALUES | {"free": ["shark.v0"]}):
                with pytest.raises(InputError, match="students' pages have no sliders of kinds"):
                    await service.ask(asked, SavedScene("Hunt", SCENE), moves_kinds=False)
            two = SavedScene("Hunt", SCENE, Spec("couzin"))
            with pytest.raises(InputError, match="where two flocks are beside each other"):
                await service.ask(ROLES.to_values(), two)
            await service.ask(VALUES, SavedScene("Hunt", SCENE), moves_kinds=False)
            await service.ask(free, SavedScene("Hunt", SCENE))
            assert len(service.all) == 2
        finally:
            await service.close()

    asyncio.run(scenario())


def test_a_class_file_has_who_plays_what():
    collection = Collection(ROLES)
    for name in ("Ada", "Bo"):
        collection.give(name)
    students = {name: SavedStudent(Role.OWN) for name in ("Ada", "Bo")}
    state = ClassState("Hunt", SavedScene("Hunt", SCENE), students, [collection])
    data = packed(state)
    (again,) = open_class("class.zip", data).questions
    assert (again.question, again.given) == (ROLES, collection.given)
    collection.given["Bo"] = replace(collection.given["Bo"], kind="whale")
    with pytest.raises(InputError, match="given: kind = 'whale' is none of the question's"):
        open_class("class.zip", packed(state))


class ChangedLaboratories(Laboratories):
    """Laboratories that are asked for what a browser could ask for."""

    def change(self, whose: int, kind: str, name: str, value: float) -> None:
        """Set a number of a kind."""
        simulation = self.all[whose].simulation
        is_ordinary = kind == "flock"
        if is_ordinary:
            simulation.set(name, value).result(60)
        else:
            simulation.set_kind(kind, name, value).result(60)

    def edit(self, whose: int) -> None:
        """Put an obstacle into the world."""
        change = self.all[whose].simulation.edits.change
        change(lambda editor: editor.add(disc((1.0, 1.0), 0.2))).result(60)

    def open_other(self, whose: int) -> None:
        """Open another scene of the gallery."""
        self.all[whose].open(SavedScene("Other", preset_spec("vem", agents=9)))


def test_a_student_on_the_server_has_the_sliders_of_their_kind_alone(
    run_class,  # noqa: F811
    monkeypatch,
    tmp_path,
):
    """From the question on; what another kind has is refused there, and handed in is what runs."""

    async def scenario(room: Classroom) -> None:
        ada, _ = room.admit(room.code, "Ada")
        bo, _ = room.admit(room.code, "Bo")
        await room.ask(ROLES.to_values())
        assert (ada.kind, bo.kind) == ("shark", "flock")
        for student in (ada, bo):
            await room.place_of(student)
        told = StudentRequests(room).question(ada)
        assert told is not None
        assert (told["kind"], told["parameter"]) == ("shark", "shark: speed")
        point = await room.asking.hand_in("Ada", await room.flocks.tell_own(ada, "scene"))
        assert (point.value, point.differs) == (0.04, ())
        for student, kind, said in ((ada, "flock", "v0"), (bo, "shark", "v0 of shark")):
            with pytest.raises(Exception, match=f"you play {student.kind}: {said} cannot be"):
                await room.flocks.tell_own(student, "change", kind, "v0", 0.01)
        with pytest.raises(Exception, match="you play shark: the world cannot be changed here"):
            await room.flocks.tell_own(ada, "edit")
        await room.flocks.tell_own(ada, "change", "shark", "v0", 0.07)
        with pytest.raises(Exception, match=r"you play shark: .* cannot be changed here"):
            await room.flocks.tell_own(ada, "open_other")
        point = await room.asking.hand_in("Ada", await room.flocks.tell_own(ada, "scene"))
        assert (point.value, point.differs) == (0.07, ())
        rows = list(csv.DictReader(io.StringIO(room.results_csv())))
        assert [(row["student"], row["kind"]) for row in rows] == 2 * [("Ada", "shark")]
        assert room.asking.value_of("Bo") == "0.04 length/tick"
        again = restore_class(state_of(room), tmp_path / "class.zip", 1, tmp_path)
        assert [one.kind for one in again.asking.all[0].given.values()] == ["shark", "flock"]

    monkeypatch.setattr(flocks, "Laboratories", ChangedLaboratories)
    room = Classroom(SavedScene("Hunt", SCENE), 4, 1, tmp_path)
    run_class(scenario, room)
