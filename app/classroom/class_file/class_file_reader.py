"""A class from its file, whoever wrote it: all of it is checked before anything is opened."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from agents.spec import LARGEST_SEED, CompleteSpec
from app.classroom.class_file.archive import ClassArchive, content_of
from app.classroom.class_file.class_file_writer import FORMAT
from app.classroom.class_file.state import (
    MOST_QUESTIONS,
    MOST_STUDENTS,
    ClassState,
    SavedStudent,
)
from app.classroom.collect.class_table import points_from_csv
from app.classroom.collect.collection import MOST_GIVEN, Collection, StudentAssignment
from app.classroom.collect.hand_in import Point
from app.classroom.collect.question import Question, question_from_toml, titled
from app.classroom.names import same, student_name
from app.classroom.student import Role
from app.viewer.gallery.saved_scene import TEXTS, SavedScene, read_scene
from worlds.input_error import InputError, shortened, unknown
from worlds.text_file import toml

KEYS = ("format", "title", "seats", "students", "questions")
OF_STUDENT, OF_QUESTION, OF_GIVEN = ("name", "role", "file"), ("file", "given"), (
    "student", "value", "seed",
)  # fmt: skip


def load(path: str | Path) -> ClassState:
    """The class of a file. Raises InputError in one line, having opened nothing."""
    return opened(Path(path).name, content_of(Path(path)))


def opened(name: str, data: bytes) -> ClassState:
    """The class in the bytes of a file. Raises InputError in one line."""
    pack = ClassArchive(name, data)
    said = toml(pack.text("class.toml"), f"class.toml of {name}")
    demand_keys(said, KEYS, "class.toml")
    if said.get("format") != FORMAT:
        raise InputError(
            f"{name} has the format {shortened(said.get('format'))}: this flockscope opens {FORMAT}"
        )
    scene = read_scene(f"scene.toml of {name}", pack.text("scene.toml").encode())
    return ClassState(
        title_of(said),
        scene,
        students_of(said, pack),
        questions_of(said, scene, pack),
        seats_of(said),
    )


def title_of(said: Mapping[str, Any]) -> str:
    """The class's title. Raises InputError."""
    title = said.get("title")
    if not isinstance(title, str) or len(title) > TEXTS["title"]:
        raise InputError(
            f"title = {shortened(title)} is no text of at most {TEXTS['title']} letters"
        )
    return titled(title)


def seats_of(said: Mapping[str, Any]) -> int:
    """How many students there may be. Raises InputError."""
    seats = said.get("seats")
    if isinstance(seats, bool) or not isinstance(seats, int) or not 1 <= seats <= MOST_STUDENTS:
        raise InputError(
            f"seats = {shortened(seats)} is not allowed: 1 to {MOST_STUDENTS} (class.toml)"
        )
    return seats


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
        question = question_from_toml(pack.text(entry), scene.spec, f"{entry} of {pack.name}")
        given: dict[str, StudentAssignment] = {}
        for one in tables(row, "given", MOST_GIVEN, OF_GIVEN):
            name = checked_name(one.get("student"))
            if name in given:
                raise InputError(f"given: {name!r} is there twice (class.toml)")
            given[name] = given_of(one, question)
        made.append(Collection(question, points_of(key, question, pack), given))
    return made


def given_of(row: Mapping[str, Any], question: Question) -> StudentAssignment:
    """What a student was given. Raises InputError."""
    value, seed = row.get("value"), row.get("seed")
    if value is not None and (isinstance(value, bool) or value not in question.values):
        raise InputError(
            f"given: value = {shortened(value)} is none of the question's (class.toml)"
        )
    if value is None and question.values:
        raise InputError("given: value is missing (class.toml)")
    if isinstance(seed, bool) or not isinstance(seed, int) or not 0 <= seed <= LARGEST_SEED:
        raise InputError(f"given: seed = {shortened(seed)} is no seed (class.toml)")
    return StudentAssignment(None if value is None else float(value), seed)


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
        raise InputError(f"{key} = {shortened(found)} is no list of tables (class.toml)")
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
        raise InputError(f"name = {shortened(text)} is not written as it is shown, {name!r}")
    return name


def text_of(value: Any, pattern: str) -> str:
    """The name of an entry. Raises InputError."""
    if not isinstance(value, str) or not re.fullmatch(pattern, value):
        raise InputError(f"file = {shortened(value)} is no name of an entry (class.toml)")
    return value
