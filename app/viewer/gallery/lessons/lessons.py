"""Lessons by name: a scene that leads through steps, and that suits forty flocks at once."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from app.viewer.gallery.saved_scene import SavedScene

FOLDER = Path(__file__).parent
FIRST = "order-against-noise"
"""What a class opens on that asks for nothing."""


@cache
def lesson_names() -> tuple[str, ...]:
    """Names of the lessons, the first one first."""
    return tuple(dict.fromkeys((FIRST, *sorted(path.stem for path in FOLDER.glob("*.toml")))))


@cache
def built_in_lesson(name: str) -> SavedScene:
    """The scene of a lesson, by one of `lesson_names`."""
    return SavedScene.from_toml((FOLDER / f"{name}.toml").read_text("utf-8"), f"lesson {name}")


@cache
def lesson_titles() -> dict[str, str]:
    """Names of the lessons by their titles."""
    return {built_in_lesson(name).title: name for name in lesson_names()}


def lesson_of(scene: SavedScene) -> str:
    """The lesson that a scene was opened from, whatever has been changed since; else nothing."""
    return lesson_titles().get(scene.title, "")
