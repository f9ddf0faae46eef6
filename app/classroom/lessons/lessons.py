"""Lessons by name: a scene that suits forty flocks at once, and whose question is ready."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.gallery.scene_collection import find_scene, scene_names
from worlds.input_error import unknown

FOLDER = Path(__file__).parent
FIRST = "order-against-noise"
"""What a class opens on that asks for nothing."""


@cache
def lesson_names() -> tuple[str, ...]:
    """Names of the lessons, the first one first."""
    return tuple(dict.fromkeys((FIRST, *sorted(path.stem for path in FOLDER.glob("*.toml")))))


def find_lesson(name: str) -> SavedScene:
    """The scene of a lesson, or a scene of the gallery. Raises InputError."""
    if name in lesson_names():
        return SavedScene.from_toml((FOLDER / f"{name}.toml").read_text("utf-8"), name)
    if ":" not in name and name not in scene_names():
        raise unknown("lesson or scene", name, (*lesson_names(), *scene_names()))
    return find_scene(name)


@cache
def lesson_titles() -> dict[str, str]:
    """Names of the lessons by their titles."""
    return {find_lesson(name).title: name for name in lesson_names()}


def lesson_of(scene: SavedScene) -> str:
    """The lesson that a scene was opened from, whatever has been changed since; else nothing."""
    return lesson_titles().get(scene.title, "")
