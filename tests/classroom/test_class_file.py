"""A class in one file: restored to equal values, whole or not at all, checked if a stranger's."""

from __future__ import annotations

import io
import resource
import stat
import tomllib
import zipfile
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import flockscope
from agents.flock import Flock
from app.classroom.class_file import (
    MOST_ENTRIES,
    OPENED,
    PICTURE,
    ClassState,
    SavedStudent,
    load,
    open_class,
    packed,
    save,
)
from app.classroom.collect.class_curve import ClassCurve
from app.classroom.collect.class_table import points_from_csv, to_csv
from app.classroom.collect.collection import Collection, StudentAssignment
from app.classroom.collect.hand_in import ResultGroup, hand_in
from app.classroom.collect.question import question_of
from app.classroom.lesson_prediction import LessonPrediction
from app.classroom.student import Role, same, student_name
from app.viewer.gallery.saved_scene import SavedScene, read_scene
from app.viewer.gallery.scene_collection import find_scene
from app.viewer.run.run_preset import preset_spec
from tests.classroom.small import ORDER, SCENE, VALUES, WHEN, made, told
from tests.classroom.test_lesson_steps import scene_text
from worlds.input_error import InputError


def small_class() -> ClassState:
    """A class of three, one of whom has built obstacles; two questions, one answered."""
    scene = SavedScene("Order", SCENE, watch="what to see", look={"colour": "heading"})
    world = replace(Flock(preset_spec("vem", world="obstacles", agents=10)).world, name="mine")
    own = SavedScene.from_toml(
        SavedScene("Mine", preset_spec("vem", world=world)).to_toml(), "mine"
    )
    order = Collection(question_of(VALUES | {"free": ["v0"]}, SCENE))
    for name in ("Ada", "Zoë 山"):
        spec = order.begins(name, SCENE)
        order.add(hand_in(order.question, name, spec, SCENE, WHEN))
    order.add(hand_in(order.question, "B", SCENE.but(agents=20), SCENE, WHEN))
    groups = tuple(ResultGroup(v, v, v, (0.1 + 0.2, 0.5), 1) for v in order.question.values)
    order.curve = ClassCurve("vem-eta", groups, ("other v0: 1, not 2",))
    free = Collection(question_of(VALUES | {"values": [], "counts": "all"}, SCENE))
    free.give("Ada")
    students = {
        "Ada": SavedStudent(Role.OWN, scene),
        "Zoë 山": SavedStudent(Role.OWN, own),
        "B": SavedStudent(Role.WATCHING),
    }
    return ClassState("Monday", scene, students, [order, free], 30)


@pytest.fixture(scope="module")
def state():
    return small_class()


@pytest.fixture(scope="module")
def data(state):
    return packed(state)


def test_a_class_is_restored_to_equal_values(state, tmp_path):
    save(state, tmp_path / "class.zip")
    assert load(tmp_path / "class.zip") == state
    assert [path.name for path in tmp_path.iterdir()] == ["class.zip"]


LESSON = SavedScene.from_toml(scene_text(), "lesson")
"""A scene of two steps; in the second something is predicted."""


def predicted_class() -> ClassState:
    """A class at the second step of a lesson, whose students have predicted."""
    students = {
        "Ada": SavedStudent(Role.OWN, None, {2: LessonPrediction(1, 0)}),
        "Bo": SavedStudent(Role.OWN, None, {2: LessonPrediction(0)}),
        "Cy": SavedStudent(Role.OWN),
    }
    return ClassState("Lesson", LESSON, students, step=2)


def test_the_step_and_predictions_of_a_lesson_are_restored():
    state = predicted_class()
    assert open_class("class.zip", packed(state)) == state
    with zipfile.ZipFile(io.BytesIO(packed(state))) as pack:
        assert pack.read("predictions.csv").decode().splitlines() == [
            "student,step,predicted,shown",
            "Ada,2,much,little",
            "Bo,2,little,",
        ]


@pytest.mark.parametrize(
    ("entry", "before", "after", "said"),
    [
        ("class.toml", "step = 2", "step = 3", "step = 3 is not allowed: 0 to 2 (class.toml)"),
        ("class.toml", "step = 2", "step = true", "step = True is not allowed"),
        ("predictions.csv", "Bo,2", "Di,2", "student = 'Di' is not in the class"),
        ("predictions.csv", "Bo,2", "Bo,1", "unknown step '1' (known: 2)"),
        ("predictions.csv", "Bo,2,little", "Bo,2,some", "unknown choice 'some'"),
        ("predictions.csv", "Ada,2,much,little", "Ada,2,much,some", "unknown choice 'some'"),
        ("predictions.csv", "Bo,2,little,", "Ada,2,little,", "step 2 of Ada is there twice"),
        ("predictions.csv", "Bo,2,little,", "Bo,2", "row 2 is not as its columns"),
        ("predictions.csv", "shown", "showed", "has not the columns student, step, predicted"),
    ],
)
def test_what_is_wrong_with_predictions_is_said_in_a_line(entry, before, after, said):
    changed = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(packed(predicted_class()))) as pack,
        zipfile.ZipFile(changed, "w") as made,
    ):
        for name in pack.namelist():
            text = pack.read(name).decode()
            made.writestr(name, text.replace(before, after) if name == entry else text)
    with pytest.raises(InputError) as refused:
        open_class("class.zip", changed.getvalue())
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_class_that_went_on_to_another_model_is_opened_again(state):
    other = SavedScene("Layers", preset_spec("hwvem", agents=10))
    order, free = state.questions
    asked = replace(order, scene=state.scene)
    made = open_class("class.zip", packed(replace(state, scene=other, questions=[asked])))
    assert made.scene == other
    assert made.questions == [asked]
    before = open_class("class.zip", packed(replace(state, questions=[asked, free])))
    assert before.questions[0].scene is None, "it has the scene of the class"


def test_the_same_class_is_the_same_file(data):
    assert packed(open_class("class.zip", data)) == data


def test_a_person_can_unpack_and_read_it(state, data, tmp_path):
    with zipfile.ZipFile(io.BytesIO(data)) as pack:
        assert pack.testzip() is None
        pack.extractall(tmp_path)
    found = sorted(str(p.relative_to(tmp_path)) for p in tmp_path.rglob("*") if p.is_file())
    assert found == [
        "class.toml", "curves/01-order-against-noise.toml",
        "plots/01-order-against-noise.png", "plots/01-order-against-noise.svg",
        "questions/01-order-against-noise.toml", "questions/02-order-against-noise.toml",
        "results/01-order-against-noise.csv",
        *(f"results/01-order-against-noise/000{k}.toml" for k in (1, 2, 3)),
        "results/02-order-against-noise.csv",
        "scene.toml", "students/001-Ada.toml", "students/002-Zoë 山.toml",
    ]  # fmt: skip
    said = tomllib.loads((tmp_path / "class.toml").read_text("utf-8"))
    assert [one["name"] for one in said["students"]] == list(state.students)
    run = (tmp_path / "results/01-order-against-noise/0001.toml").read_bytes()
    point = state.questions[0].points[0]
    assert hand_in(ORDER, "Ada", read_scene("run", run).spec, SCENE).result == point.result


def test_python_reads_the_results_and_makes_the_runs_again(state, tmp_path):
    save(state, tmp_path / "class.zip")
    frame = flockscope.runs_frame(tmp_path / "class.zip")
    order = state.questions[0]
    assert frame.name.tolist() == ["Ada", "Zoë 山", "B"]
    assert frame.result.tolist() == [point.result for point in order.points]
    assert frame.eta.tolist() == [point.value for point in order.points]
    assert frame.agents.tolist() == [30, 30, 20]
    assert set(frame.question) == {order.question.title}
    again = hand_in(order.question, "Ada", frame.spec[0], SCENE, WHEN)
    assert again.result == frame.result[0]
    with pytest.raises(InputError, match="cannot be read"):
        flockscope.runs_frame(tmp_path / "other.zip")


def test_results_that_are_opened_are_those_of_runs_made_again(data):
    found = open_class("class.zip", data).questions[0]
    for point in found.points:
        spec = point.scene(found.question).spec
        assert hand_in(found.question, point.student, spec, SCENE, WHEN) == point


NAMES = st.lists(st.text(min_size=1, max_size=30), max_size=6)


@given(NAMES, st.integers(1, 1000), st.data())
@settings(suppress_health_check=[HealthCheck.too_slow], max_examples=25)
def test_classes_of_any_names_come_back(texts, seats, draw):
    names: dict[str, str] = {}
    for text in texts:
        try:
            names.setdefault(same(student_name(text)), student_name(text))
        except InputError:
            continue
    scene = SavedScene("Order", SCENE)
    roles = {
        name: SavedStudent(draw.draw(st.sampled_from(Role)),
                           draw.draw(st.sampled_from([None, scene])))
        for name in names.values()
    }  # fmt: skip
    found = Collection(ORDER, given={
        name: StudentAssignment(
            draw.draw(st.sampled_from(ORDER.values)), draw.draw(st.integers(0, 2**62))
        )
        for name in names.values()
    })  # fmt: skip
    whole = ClassState("Any", scene, roles, [found], seats)
    assert open_class("any.zip", packed(whole)) == whole


def test_a_scene_of_the_gallery_is_a_class_s_scene():
    for name in ("order", "spread", "mission", "pocket", "school"):
        whole = ClassState("Monday", find_scene(name))
        assert open_class("class.zip", packed(whole)) == whole


def test_a_full_disk_leaves_the_file_that_was_there(state, tmp_path):
    path = tmp_path / "class.zip"
    path.write_bytes(b"old")
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (4096, hard))
    try:
        with pytest.raises(
            InputError, match=r"class '.*class.zip' cannot be written: File too large"
        ):
            save(state, path)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert path.read_bytes() == b"old"
    assert [one.name for one in tmp_path.iterdir()] == ["class.zip"]


@pytest.mark.parametrize(
    ("name", "said"),
    [("class.txt", "ends in .zip"), ("nowhere/class.zip", "there is no folder"), (".", "a folder")],
)
def test_a_place_that_takes_no_class_is_refused_first(state, tmp_path, monkeypatch, name, said):
    monkeypatch.setattr("app.classroom.class_file.packed", None)
    with pytest.raises(InputError, match=said):
        save(state, tmp_path / name)


def test_a_fault_while_it_is_made_leaves_nothing(state, tmp_path, monkeypatch):
    monkeypatch.setattr("app.classroom.class_file.picture", lambda *_: 1 // 0)
    with pytest.raises(ZeroDivisionError):
        save(state, tmp_path / "class.zip")
    assert not list(tmp_path.iterdir())


def entries(data):
    """Names and contents of a class's file."""
    with zipfile.ZipFile(io.BytesIO(data)) as pack:
        return {one: pack.read(one) for one in pack.namelist()}


def zipped(contents, **more):
    """A ZIP of these entries, some of them as ZipInfo."""
    made_of = io.BytesIO()
    with zipfile.ZipFile(made_of, "w", zipfile.ZIP_DEFLATED, **more) as pack:
        for name, content in contents.items():
            pack.writestr(name, content)
    return made_of.getvalue()


def refused(data, said):
    """Whether it is refused in one short line."""
    with pytest.raises(InputError, match=said) as refusal:
        open_class("class.zip", data)
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 600


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04", b"hello", b"\x00" * 1000])
def test_what_is_no_zip_is_refused(content):
    refused(content, "is not a class's file")


@pytest.mark.parametrize(
    "name",
    [
        "../class.toml", "students/../../x.toml", "/etc/passwd", "students/a/b.toml", "run.py",
        "results/01/1.toml", "results/../0001.toml", "plots/x.exe", "C:\\x.toml",
        "students/.x.toml", "students/a\\b.toml", "class.toml ",
        "students/a\x1b[2J.toml", "students/..toml",
    ],
)  # fmt: skip
def test_names_that_no_class_has_are_refused(data, name):
    refused(zipped(entries(data) | {name: b"x"}), "is nothing that a class's file has")


def test_links_devices_and_twins_are_refused(data):
    for kind in (stat.S_IFLNK, stat.S_IFCHR, stat.S_IFIFO):
        info = zipfile.ZipInfo("students/link.toml")
        info.external_attr = (kind | 0o777) << 16
        refused(zipped(entries(data) | {info: b"/etc/passwd"}), "is a link or a device")
    with pytest.warns(UserWarning, match="Duplicate"):
        twice = zipped(entries(data) | {zipfile.ZipInfo("class.toml"): b""})
    refused(twice, "'class.toml' twice")


def test_bombs_are_refused_before_anything_is_unpacked(monkeypatch):
    monkeypatch.setattr(zipfile.ZipFile, "read", None)
    refused(zipped({"class.toml": b"\x00" * (3 << 20)}), "at most 2,097,152")
    many = {f"plots/{k}.png": b"\x00" * (PICTURE - 1) for k in range(OPENED // PICTURE + 1)}
    refused(zipped(many), "holds")
    refused(zipped({f"students/{k}.toml": b"" for k in range(MOST_ENTRIES + 1)}), "entries")
    refused(b"PK" * (17 << 20), "33,554,432 at most")


def test_a_zip_that_lies_about_sizes_unpacks_no_more_than_it_says():
    made_of = bytearray(zipped({"class.toml": b"\x00" * (1 << 20)}))
    for head, at in ((b"PK\x03\x04", 22), (b"PK\x01\x02", 24)):
        place = made_of.index(head) + at
        made_of[place : place + 4] = (100).to_bytes(4, "little")
    refused(bytes(made_of), "class.toml is damaged")


def test_locked_or_otherwise_packed_is_refused(data):
    locked = bytearray(zipped(entries(data)))
    at = locked.index(b"PK\x01\x02") + 8
    locked[at] |= 1
    refused(bytes(locked), "packed in a way")
    made_of = io.BytesIO()
    with zipfile.ZipFile(made_of, "w", zipfile.ZIP_LZMA) as pack:
        pack.writestr("class.toml", "format = 1")
    refused(made_of.getvalue(), "packed in a way")


Q1 = "questions/01-order-against-noise.toml"
R1 = "results/01-order-against-noise"
C1 = "curves/01-order-against-noise.toml"


@pytest.mark.parametrize(
    ("entry", "before", "after", "said"),
    [
        ("class.toml", "format = 1", "format = 2", "has the format 2"),
        ("class.toml", "format = 1", "format =", "is not TOML"),
        ("class.toml", "format = 1", "format = 1\nmore = 1", "unknown key 'more'"),
        ("class.toml", "seats = 30", "seats = 0", "seats = 0 is not allowed"),
        ("class.toml", "seats = 30", "seats = true", "seats = True is not allowed"),
        ("class.toml", 'title = "Monday"', "title = 7", "title = 7 is no text"),
        ("class.toml", 'role = "watching"', 'role = "teacher"', "unknown role 'teacher'"),
        ("class.toml", 'name = "B"', 'name = "ada"', "'ada' is there twice"),
        ("class.toml", 'name = "B"', 'name = "=B"', "formula"),
        ("class.toml", 'name = "B"', 'name = " B"', "not written as it is shown"),
        ("class.toml", "students/001-Ada.toml", "students/x.toml", "has no 'students/x.toml'"),
        ("class.toml", "students/001-Ada.toml", "../../x.toml", "no name of an entry"),
        ("class.toml", "seed = 1", "seed = -1", "is no seed"),
        ("class.toml", "value = 0.0", "value = 0.7", "none of the question's"),
        ("class.toml", "value = 0.0", "", "value is missing"),
        ("scene.toml", 'model = "vem"', 'model = "none"', "'none'"),
        ("scene.toml", 'model = "vem"', 'model = "hwvem"', "not that of the scene"),
        ("scene.toml", 'world = "wrap"', 'world = "/etc/passwd"', "unknown world"),
        ("students/001-Ada.toml", "eta = 0.4", "eta = 9.0", "eta = 9.0"),
        (Q1, "ticks = 40", "ticks = 900000", "20000"),
        (Q1, 'parameter = "eta"', 'parameter = "p2"', "'p2'"),
        (f"{R1}.csv", ",ok,", ",good,", "no status"),
        (f"{R1}.csv", "1,Ada,0.0,", "1,Ada,1.5,", "is not the run of its row"),
        (f"{R1}/0001.toml", "seed = 1", "seed = 2", "is not the run of its row"),
        (f"{R1}/0001.toml", 'model = "vem"', 'model = "x.py"', "x.py"),
        (C1, "0.5", "1.5", "polarisation = 1.5 is not allowed"),
        (C1, "0.5", "nan", "results.1 = nan is not allowed"),
        (C1, "value = 1.5", "value = 0.0", "the values of groups do not rise"),
        (C1, "gave_up = 1", "gave_up = -1", "gave_up = -1 is not allowed"),
        (C1, 'sweep = "vem-eta"', 'sweep = "a\\nb"', "one line of plain text"),
        (C1, 'sweep = "vem-eta"', "", "has no sweep"),
    ],
)
def test_what_a_stranger_has_changed_is_refused_in_one_line(data, entry, before, after, said):
    contents = entries(data)
    text = contents[entry].decode()
    assert before in text
    refused(zipped(contents | {entry: text.replace(before, after, 1).encode()}), said)


@pytest.mark.parametrize("entry", ["class.toml", "scene.toml", "students/001-Ada.toml", Q1,
                                   f"{R1}.csv", f"{R1}/0002.toml"])  # fmt: skip
def test_what_lacks_an_entry_or_has_no_text_is_refused(data, entry):
    contents = entries(data)
    refused(zipped({name: one for name, one in contents.items() if name != entry}), "has no")
    refused(zipped(contents | {entry: b"\xff\xfe"}), "not a text")


@given(st.data())
@settings(max_examples=60)
def test_a_file_with_bytes_changed_is_the_class_or_refused(data, draw):
    broken = bytearray(data)
    for _ in range(draw.draw(st.integers(1, 4))):
        broken[draw.draw(st.integers(0, len(data) - 1))] = draw.draw(st.integers(0, 255))
    cut = draw.draw(st.sampled_from([0, 0, 1, 22, len(data) // 2]))
    said = "in one line"
    try:
        assert isinstance(open_class("class.zip", bytes(broken[: len(data) - cut])), ClassState)
    except InputError as refusal:
        said = str(refusal)
    assert "\n" not in said


def test_only_plain_files_are_read(tmp_path):
    for place, said in ((tmp_path, "it is no file"), ("/dev/zero", "it is no file"),
                        (tmp_path / "none", "No such file"), ("a\0b", "no name")):  # fmt: skip
        with pytest.raises(InputError, match=said):
            load(place)


def test_a_class_that_is_too_large_is_not_saved(tmp_path):
    whole = ClassState("Big", SavedScene("Order", SCENE))
    whole.questions.append(
        Collection(ORDER, [made(1.5), told(1.5, 0.5, "b", spec="x" * (3 << 20))])
    )
    with pytest.raises(InputError, match="at most 2,097,152"):
        save(whole, tmp_path / "class.zip")
    assert not list(tmp_path.iterdir())


def test_a_result_that_no_run_has_is_refused_and_no_text_is_a_formula():
    point = told(0.0, 0.5, reason="=1+1", differs=("-x", "@y"))
    text = to_csv(Collection(ORDER, [point]))
    assert ",'-x; @y,'=1+1," in text
    spec = {1: point.spec}
    assert points_from_csv(text, ORDER, spec.get, "a table") == [point]
    for result in ("-5", "1.1"):
        with pytest.raises(
            InputError, match=rf"polarisation = {result} is not allowed: .* \[0, 1\]"
        ):
            points_from_csv(text.replace(",0.5,", f",{result},"), ORDER, spec.get, "a table")
