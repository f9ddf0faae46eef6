"""A class from its file, whoever wrote it: all of it is checked before anything is opened."""

from __future__ import annotations

import io
import os
import re
import stat
import zipfile
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import tomlkit

from agents.spec import LARGEST_SEED, CompleteSpec
from app.classroom.collect.class_curve import ClassCurve, curve_from_toml
from app.classroom.collect.class_picture import picture
from app.classroom.collect.class_table import demand_in_range, points_from_csv, to_csv
from app.classroom.collect.collection import MOST_GIVEN, Collection, StudentAssignment
from app.classroom.collect.hand_in import Point
from app.classroom.collect.question import Question, clean_title, question_from_toml
from app.classroom.lesson_prediction import (
    LessonPrediction,
    predictions_from_csv,
    predictions_to_csv,
)
from app.classroom.student import Role, same, student_name
from app.viewer.editing.layout_file import plain_name
from app.viewer.gallery.saved_scene import TEXTS, SavedScene, read_scene
from worlds.file_writer import demand_writable, writing
from worlds.input_error import InputError, shorten, unknown
from worlds.text_file import toml

# A class as a value: its scene, who is in it, what it was asked and what came of that.

MOST_STUDENTS = 1_000
MOST_QUESTIONS = 50
SEATS = 40


@dataclass(frozen=True)
class SavedStudent:
    """A student as the file of a class has them."""

    role: Role
    scene: SavedScene | None = None
    """Their flock as it was last; None: they have had none."""
    predictions: dict[int, LessonPrediction] = field(default_factory=dict)
    """In the steps of the class's scene, by the number of the step."""


@dataclass
class ClassState:
    """A whole class."""

    title: str
    scene: SavedScene
    students: dict[str, SavedStudent] = field(default_factory=dict)
    """By name, in the order in which they came."""
    questions: list[Collection] = field(default_factory=list)
    seats: int = SEATS
    """Students at most, 1 to 1000."""
    step: int = 0
    """Of the scene, from 1, that all students see; 0: each goes their own way."""


# A ZIP from a stranger: what may be in it, how much, and its texts, read within bounds.

LARGEST = 32 * 2**20
"""Bytes of a class's file."""
OPENED = 128 * 2**20
"""Bytes of all that is in it."""
MOST_ENTRIES = 12_000
TEXT, TABLE, PICTURE = 2 * 2**20, 8 * 2**20, 32 * 2**20
"""Bytes of what is in it, by kind."""
ENTRY = b"PK\x01\x02"
"""Stands before each entry in a ZIP's list of them."""
NAME = r"[^/\\:\0]{1,100}"
KINDS = {
    r"(class|scene)\.toml": TEXT,
    r"predictions\.csv": TABLE,
    rf"(students|questions|scenes)/{NAME}\.toml": TEXT,
    rf"results/{NAME}\.csv": TABLE,
    rf"curves/{NAME}\.toml": TEXT,
    rf"results/{NAME}/[0-9]{{4}}\.toml": TEXT,
    rf"plots/{NAME}\.(svg|png)": PICTURE,
}
"""What a class's file has, and how large it may be."""
PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
LOCKED = 0x1
"""The flag of an entry that needs a password."""
BROKEN = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError,
          ValueError, OverflowError)  # fmt: skip
"""What the library raises for ZIPs that are none."""


class ClassArchive:
    """The texts of a ZIP by their names. Raises InputError for what is no class's file."""

    def __init__(self, name: str, data: bytes):
        self.name = name
        if len(data) > LARGEST:
            raise InputError(
                f"{name} has {len(data):,} bytes: a class's file has {LARGEST:,} at most"
            )
        listed = data.count(ENTRY)
        if listed > MOST_ENTRIES:
            raise InputError(f"{name} has {listed:,} entries: a class's file has {MOST_ENTRIES:,}")
        try:
            self.pack = zipfile.ZipFile(io.BytesIO(data))
        except BROKEN:
            raise InputError(f"{name} is not a class's file, which is a ZIP") from None
        demand_sound(name, self.pack.infolist())
        self.names = frozenset(one.filename for one in self.pack.infolist())

    def text(self, entry: str) -> str:
        """A text in UTF-8. Raises InputError."""
        if entry not in self.names:
            raise InputError(f"{self.name} has no {shorten(entry)}")
        try:
            data = self.pack.read(entry)
        except BROKEN:
            raise InputError(f"{self.name}: {entry} is damaged") from None
        try:
            return data.decode("utf-8")
        except UnicodeDecodeError:
            raise InputError(f"{self.name}: {entry} is not a text") from None


def demand_sound(name: str, entries: list[zipfile.ZipInfo]) -> None:
    """Refuse entries that no class's file has, before any is read. Raises InputError."""
    twice = [one for one, count in Counter(one.filename for one in entries).items() if count > 1]
    if twice:
        raise InputError(f"{name} has {shorten(twice[0])} twice")
    for one in entries:
        where = shorten(one.filename)
        if one.is_dir() and one.filename.count("/") <= 2 and ".." not in one.filename:
            continue
        largest = allowed(one.filename)
        if largest is None:
            raise InputError(f"{name}: {where} is nothing that a class's file has")
        mode = one.external_attr >> 16
        if stat.S_IFMT(mode) not in (0, stat.S_IFREG):
            raise InputError(f"{name}: {where} is a link or a device, not a file")
        if one.flag_bits & LOCKED or one.compress_type not in PACKED:
            raise InputError(f"{name}: {where} is packed in a way that is not read here")
        if one.file_size > largest:
            raise InputError(f"{name}: {where} has {one.file_size:,} bytes: at most {largest:,}")
    if (total := sum(one.file_size for one in entries)) > OPENED:
        raise InputError(f"{name} holds {total:,} bytes: a class's file holds {OPENED:,} at most")


def allowed(entry: str) -> int | None:
    """The most bytes of an entry of that name; None where there is none in a class's file."""
    if entry != entry.strip() or any(part.startswith(".") for part in entry.split("/")):
        return None
    if not entry.isprintable():
        return None
    return next((most for kind, most in KINDS.items() if re.fullmatch(kind, entry)), None)


def content_of(path: Path) -> bytes:
    """The bytes of a plain file, not without end. Raises InputError."""
    named = f"class {str(path)!r}"
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise InputError(f"{named} cannot be read: it is no file")
        with open(path, "rb") as file:
            return file.read(LARGEST + 1)
    except OSError as error:
        raise InputError(f"{named} cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{named} is no name that a file can have") from None


# A class written into a ZIP that a person can unpack and read, whole or not at all.

FORMAT = 1
"""Of the file; a newer flockscope may write another."""
ENDINGS = (".zip",)
PICTURES = ("svg", "png")
PREDICTIONS = "predictions.csv"
"""What students have predicted in the steps of the lesson; not there where nobody has."""
RIGHTS = 0o100644 << 16
"""Of a file when it is unpacked: its owner writes, all read."""


def save(state: ClassState, path: str | Path, overwrite: bool = True) -> None:
    """Write a class; its pictures take some tenths of a second each. Raises InputError.

    It is made whole before its place is touched; a full disk leaves what was there.
    """
    demand_writable("class", path, overwrite, ENDINGS)
    data = packed(state, str(path))
    with writing("class", path, overwrite, ENDINGS) as file:
        file.write(data)


def packed(state: ClassState, name: str = "the class") -> bytes:
    """The bytes of the file; the same class makes the same ones. Raises InputError if too many."""
    made = io.BytesIO()
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as pack:
        for entry, content in entries(state):
            info = zipfile.ZipInfo(entry)
            info.external_attr = RIGHTS
            pack.writestr(info, content, zipfile.ZIP_DEFLATED)
        demand_sound(name, pack.infolist())
    data = made.getvalue()
    if len(data) > LARGEST:
        raise InputError(f"{name} has {len(data):,} bytes: a class's file has {LARGEST:,} at most")
    return data


def entries(state: ClassState) -> Iterator[tuple[str, str | bytes]]:
    """Names and contents of all that is in the file."""
    said: dict[str, Any] = {
        "format": FORMAT,
        "title": state.title,
        "seats": state.seats,
        "students": [],
        "questions": [],
    } | ({"step": state.step} if state.step else {})
    own: list[tuple[str, str]] = []
    for number, (name, student) in enumerate(state.students.items(), 1):
        row = {"name": name, "role": student.role.value}
        if student.scene is not None:
            row["file"] = f"students/{number:03d}-{plain_name(name)}.toml"
            own.append((row["file"], student.scene.to_toml()))
        said["students"].append(row)
    for number, collection in enumerate(state.questions, 1):
        key = f"{number:02d}-{slug(collection.question.title)}"
        given = [
            {"student": name, "seed": one.seed}
            | ({} if one.value is None else {"value": one.value})
            | ({"kind": one.kind} if one.kind else {})
            for name, one in collection.given.items()
        ]
        said["questions"].append({"file": key, "given": given})
        own += answers(key, collection)
        if collection.scene not in (None, state.scene):
            own.append((f"scenes/{key}.toml", collection.scene.to_toml()))
    yield "class.toml", tomlkit.dumps(said)
    yield "scene.toml", state.scene.to_toml()
    predictions = {name: one.predictions for name, one in state.students.items()}
    if any(predictions.values()):
        yield PREDICTIONS, predictions_to_csv(state.scene.steps, predictions)
    yield from own
    for row, collection in zip(said["questions"], state.questions, strict=True):
        if collection.points:
            for kind in PICTURES:
                yield f"plots/{row['file']}.{kind}", picture(collection, kind)


def answers(key: str, collection: Collection) -> Iterator[tuple[str, str]]:
    """A question, its results, the runs that they are of, and the curve of a sweep."""
    yield f"questions/{key}.toml", collection.question.to_toml()
    yield f"results/{key}.csv", to_csv(collection)
    for number, point in enumerate(collection.points, 1):
        yield f"results/{key}/{number:04d}.toml", point.spec
    if collection.curve is not None:
        yield f"curves/{key}.toml", collection.curve.to_toml()


def slug(title: str) -> str:
    """A title as part of a file's name.

    >>> slug("Who leads? Ticks until all agree against p2")
    'who-leads-ticks-until-all-agree-against'
    """
    return re.sub(r"[^a-z0-9]+", "-", title.lower())[:40].strip("-") or "question"


KEYS = ("format", "title", "seats", "step", "students", "questions")
OF_STUDENT, OF_QUESTION, OF_GIVEN = ("name", "role", "file"), ("file", "given"), (
    "student", "value", "seed", "kind",
)  # fmt: skip


def load(path: str | Path) -> ClassState:
    """The class of a file. Raises InputError in one line, having opened nothing."""
    return open_class(Path(path).name, content_of(Path(path)))


def open_class(name: str, data: bytes) -> ClassState:
    """The class in the bytes of a file. Raises InputError in one line."""
    pack = ClassArchive(name, data)
    said = toml(pack.text("class.toml"), f"class.toml of {name}")
    demand_keys(said, KEYS, "class.toml")
    if said.get("format") != FORMAT:
        raise InputError(
            f"{name} has the format {shorten(said.get('format'))}: this flockscope opens {FORMAT}"
        )
    scene = read_scene(f"scene.toml of {name}", pack.text("scene.toml").encode())
    return ClassState(
        title_of(said),
        scene,
        with_predictions(students_of(said, pack), scene, pack),
        questions_of(said, scene, pack),
        seats_of(said),
        step_of(said, scene),
    )


def title_of(said: Mapping[str, Any]) -> str:
    """The class's title. Raises InputError."""
    title = said.get("title")
    if not isinstance(title, str) or len(title) > TEXTS["title"]:
        raise InputError(f"title = {shorten(title)} is no text of at most {TEXTS['title']} letters")
    return clean_title(title)


def seats_of(said: Mapping[str, Any]) -> int:
    """How many students there may be. Raises InputError."""
    seats = said.get("seats")
    if isinstance(seats, bool) or not isinstance(seats, int) or not 1 <= seats <= MOST_STUDENTS:
        raise InputError(
            f"seats = {shorten(seats)} is not allowed: 1 to {MOST_STUDENTS} (class.toml)"
        )
    return seats


def step_of(said: Mapping[str, Any], scene: SavedScene) -> int:
    """The step that all students see. Raises InputError."""
    step, most = said.get("step", 0), len(scene.steps)
    if isinstance(step, bool) or not isinstance(step, int) or not 0 <= step <= most:
        raise InputError(f"step = {shorten(step)} is not allowed: 0 to {most} (class.toml)")
    return int(step)


def with_predictions(
    students: dict[str, SavedStudent], scene: SavedScene, pack: ClassArchive
) -> dict[str, SavedStudent]:
    """The students with what they have predicted; old files have nothing of it. Raises
    InputError."""
    if PREDICTIONS not in pack.names:
        return students
    origin = f"{PREDICTIONS} of {pack.name}"
    made = predictions_from_csv(pack.text(PREDICTIONS), scene.steps, students, origin)
    return {
        name: replace(student, predictions=made.get(name, {})) for name, student in students.items()
    }


def students_of(said: Mapping[str, Any], pack: ClassArchive) -> dict[str, SavedStudent]:
    """The students by name. Raises InputError."""
    made: dict[str, SavedStudent] = {}
    alike: set[str] = set()
    for row in tables(said, "students", MOST_STUDENTS, OF_STUDENT):
        name = checked_name(row.get("name"))
        if same(name) in alike:
            raise InputError(f"students: {name!r} is there twice (class.toml)")
        alike.add(same(name))
        role: Any = row.get("role")
        if role not in list(Role):
            raise unknown("role", role, list(Role), "class.toml")
        scene: SavedScene | None = None
        if "file" in row:
            entry = text_of(row["file"], r"students/[^/]+\.toml")
            scene = read_scene(f"{entry} of {pack.name}", pack.text(entry).encode())
        made[name] = SavedStudent(Role(role), scene)
    return made


def questions_of(
    said: Mapping[str, Any], scene: SavedScene, pack: ClassArchive
) -> list[Collection]:
    """The questions with their results. Raises InputError."""
    made = []
    for row in tables(said, "questions", MOST_QUESTIONS, OF_QUESTION):
        key = text_of(row.get("file"), r"[^/]+")
        entry = f"questions/{key}.toml"
        asked = asked_scene(key, pack)
        spec = (asked or scene).spec
        question = question_from_toml(pack.text(entry), spec, f"{entry} of {pack.name}")
        given: dict[str, StudentAssignment] = {}
        for one in tables(row, "given", MOST_GIVEN, OF_GIVEN):
            name = checked_name(one.get("student"))
            if name in given:
                raise InputError(f"given: {name!r} is there twice (class.toml)")
            given[name] = given_of(one, question)
        points, curve = points_of(key, question, pack), saved_curve(key, question, pack)
        made.append(Collection(question, points, given, curve, asked))
    return made


def asked_scene(key: str, pack: ClassArchive) -> SavedScene | None:
    """What the class had when it was asked; None: what it has now. Raises InputError."""
    entry = f"scenes/{key}.toml"
    if entry not in pack.names:
        return None
    return read_scene(f"{entry} of {pack.name}", pack.text(entry).encode())


def saved_curve(key: str, question: Question, pack: ClassArchive) -> ClassCurve | None:
    """The curve of a question; None where the file has none. Raises InputError."""
    entry = f"curves/{key}.toml"
    if entry not in pack.names:
        return None
    origin = f"{entry} of {pack.name}"
    curve = curve_from_toml(pack.text(entry), origin)
    for group in curve.groups:
        for result in group.values:
            demand_in_range(result, question, origin)
    return curve


def given_of(row: Mapping[str, Any], question: Question) -> StudentAssignment:
    """What a student was given. Raises InputError."""
    value, seed, kind = row.get("value"), row.get("seed"), row.get("kind", "")
    if value is not None and (isinstance(value, bool) or value not in question.values):
        raise InputError(f"given: value = {shorten(value)} is none of the question's (class.toml)")
    if value is None and question.values:
        raise InputError("given: value is missing (class.toml)")
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed <= LARGEST_SEED:
        raise InputError(f"given: seed = {shorten(seed)} is no seed (class.toml)")
    if kind not in (question.kinds or [""]):
        raise InputError(f"given: kind = {shorten(kind)} is none of the question's (class.toml)")
    return StudentAssignment(None if value is None else float(value), seed, kind)


def points_of(key: str, question: Question, pack: ClassArchive) -> list[Point]:
    """The results of a question, each with its run. Raises InputError."""
    entry = f"results/{key}.csv"

    def run(number: int) -> str:
        return f"results/{key}/{number:04d}.toml"

    points = points_from_csv(
        pack.text(entry), question, lambda number: pack.text(run(number)), f"{entry} of {pack.name}"
    )
    for number, point in enumerate(points, 1):
        demand_same_run(point, question, f"{run(number)} of {pack.name}")
    return points


def demand_same_run(point: Point, question: Question, origin: str) -> None:
    """Refuse a spec that is not the run of its row, or that could not be opened. Raises
    InputError."""
    spec: CompleteSpec = read_scene(origin, point.spec.encode()).spec
    values = tuple(question.value_of(spec, name) for name in question.free)
    if (spec.seed, question.value_of(spec), values) != (point.seed, point.value, point.free):
        raise InputError(f"{origin} is not the run of its row: seed or {question.parameter} differ")


def tables(
    values: Mapping[str, Any], key: str, most: int, keys: tuple[str, ...]
) -> list[Mapping[str, Any]]:
    """A list of tables with no other keys than these. Raises InputError."""
    found = values.get(key, [])
    if not isinstance(found, list) or not all(isinstance(one, dict) for one in found):
        raise InputError(f"{key} = {shorten(found)} is no list of tables (class.toml)")
    if len(found) > most:
        raise InputError(f"{key}: {len(found):,} are there, at most {most:,} (class.toml)")
    for one in found:
        demand_keys(one, keys, f"{key} of class.toml")
    return found


def demand_keys(values: Mapping[str, Any], keys: tuple[str, ...], origin: str) -> None:
    """Refuse a key that is none of these. Raises InputError."""
    for key in values:
        if key not in keys:
            raise unknown("key", key, keys, origin)


def checked_name(text: Any) -> str:
    """A student's name, written as it is shown. Raises InputError."""
    name = student_name(text)
    if name != text:
        raise InputError(f"name = {shorten(text)} is not written as it is shown, {name!r}")
    return name


def text_of(value: Any, pattern: str) -> str:
    """The name of an entry. Raises InputError."""
    if not isinstance(value, str) or not re.fullmatch(pattern, value):
        raise InputError(f"file = {shorten(value)} is no name of an entry (class.toml)")
    return value
