"""A class written into a ZIP that a person can unpack and read, whole or not at all."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import tomlkit

from app.classroom.class_file.archive import LARGEST, demand_sound
from app.classroom.class_file.state import ClassState
from app.classroom.collect.class_picture import picture
from app.classroom.collect.class_table import to_csv
from app.classroom.collect.collection import Collection
from app.viewer.editing.layout_file import plain_name
from worlds.file_writer import demand_writable, writing
from worlds.input_error import InputError

FORMAT = 1
"""Of the file; a newer flockscope may write another."""
ENDINGS = (".zip",)
PICTURES = ("svg", "png")
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
    }
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
            for name, one in collection.given.items()
        ]
        said["questions"].append({"file": key, "given": given})
        own += answers(key, collection)
    yield "class.toml", tomlkit.dumps(said)
    yield "scene.toml", state.scene.to_toml()
    yield from own
    for row, collection in zip(said["questions"], state.questions, strict=True):
        if collection.points:
            for kind in PICTURES:
                yield f"plots/{row['file']}.{kind}", picture(collection, kind)


def answers(key: str, collection: Collection) -> Iterator[tuple[str, str]]:
    """A question, its results, and the runs that they are of."""
    yield f"questions/{key}.toml", collection.question.to_toml()
    yield f"results/{key}.csv", to_csv(collection)
    for number, point in enumerate(collection.points, 1):
        yield f"results/{key}/{number:04d}.toml", point.spec


def slug(title: str) -> str:
    """A title as part of a file's name.

    >>> slug("Who leads? Ticks until all agree against p2")
    'who-leads-ticks-until-all-agree-against'
    """
    return re.sub(r"[^a-z0-9]+", "-", title.lower())[:40].strip("-") or "question"
