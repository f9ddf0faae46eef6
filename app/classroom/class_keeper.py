"""Keeps a class as it goes: in one file that opens it again, and apart the keys of who is in it.

Whoever gets the file gets no way into the class: the hashes of cookies, and the code, lie in a file
of their own beside it that nobody else on the machine may read, and go when the class is over.
"""

from __future__ import annotations

import json
import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from app.classroom.class_file import ClassState, SavedStudent
from app.classroom.class_keys import new_code, normalise_code
from app.classroom.classroom import Classroom
from app.classroom.student import Student
from app.viewer.gallery.saved_scene import SavedScene
from worlds.input_error import InputError

EVERY = 20.0
"""Seconds between two times that a class is kept, if anything has changed."""
LARGEST = 1_000_000
"""Bytes of a file of keys."""


def state_of(classroom: Classroom) -> ClassState:
    """A class as its file has it."""
    return ClassState(
        classroom.title,
        classroom.scene,
        {
            one.name: SavedStudent(
                one.role,
                SavedScene.from_toml(one.scene, one.name) if one.scene else None,
                dict(one.predictions),
            )
            for one in classroom.students.values()
        },
        list(classroom.asking.all),
        classroom.seats,
        classroom.step,
    )


def restore_class(
    state: ClassState, path: Path, workers: int, results: Path, in_browser: bool = False
) -> Classroom:
    """The class of the file at `path`, whose content is `state`, with those who are in it. Raises
    InputError."""
    classroom = Classroom(state.scene, state.seats, workers, results, in_browser)
    classroom.title, classroom.step = state.title, state.step
    classroom.asking.take_over(state.questions, state.scene)
    said = read_keys(keys_of(path))
    keys = said.get("students", {})
    for number, (name, saved) in enumerate(state.students.items(), 1):
        scene = "" if saved.scene is None else saved.scene.to_toml()
        student = Student(number, name, keys.get(name, ""), saved.role, scene, came=True)
        student.predictions = dict(saved.predictions)
        classroom.students[number] = student
        if student.key:
            classroom.by_key[student.key] = student
    classroom.teachers.update(said.get("teachers", []))
    classroom.code = said.get("code") or new_code()
    return classroom


def keys_of(path: Path) -> Path:
    """Where the keys of a class are whose file is at `path`."""
    return path.with_name(f"{path.name}.keys")


def read_keys(path: Path) -> dict[str, Any]:
    """The keys of a class; none where there is no such file. Raises InputError if it is damaged."""
    try:
        with open(path, "rb") as file:
            said = json.loads(file.read(LARGEST))
        students, teachers = said["students"], said["teachers"]
        sound = all(map(is_hash, (*students.values(), *teachers)))
        if not sound or normalise_code(said["code"]) != said["code"]:
            raise ValueError
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise InputError(
            f"{str(path)!r} cannot be read: take it away to let all enter anew"
        ) from None
    return {"students": students, "teachers": teachers, "code": said["code"]}


def is_hash(text: object) -> bool:
    """Whether it is what is kept of a cookie."""
    return isinstance(text, str) and len(text) == 64 and all(c in "0123456789abcdef" for c in text)


def keep_keys(classroom: Classroom, path: Path) -> None:
    """Write the keys, for this user alone; whole or not at all. Raises InputError."""
    said = {
        "code": classroom.code,
        "students": {one.name: one.key for one in classroom.students.values() if one.key},
        "teachers": sorted(classroom.teachers),
    }
    fresh = path.with_name(f"{path.name}.new")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        fresh.unlink(missing_ok=True)  # never one that somebody else has laid there
        number = os.open(fresh, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with open(number, "w", encoding="utf-8") as file:
            json.dump(said, file)
        os.replace(fresh, path)
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be written: {error.strerror or error}") from None


class ClassKeeper:
    """Keeps one class at `path`."""

    def __init__(self, classroom: Classroom, path: Path):
        self.classroom = classroom
        self.path = path
        self.kept: object = None
        """What was kept last, by what tells whether anything has changed."""

    def now(self) -> object:
        """What tells whether anything has changed."""
        room = self.classroom
        students = [
            (one.name, one.key, one.role, one.scene, tuple(one.predictions.items()))
            for one in room.students.values()
        ]
        results = [(id(one), len(one.points), len(one.given), one.curve) for one in room.asking.all]
        return students, results, room.scene, room.code, room.step, len(room.teachers)

    async def keep(self) -> None:
        """Keep the class, if there is anything new in it. Raises InputError."""
        now = self.now()
        if now == self.kept or not self.classroom.students:
            return
        keep_keys(self.classroom, keys_of(self.path))
        await self.classroom.asking.draw("save", state_of(self.classroom), self.path)
        self.kept = now

    def forget_keys(self) -> None:
        """The class is over: nobody comes in by what they have."""
        with suppress(OSError):
            keys_of(self.path).unlink()
