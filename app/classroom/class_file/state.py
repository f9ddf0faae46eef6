"""A class as a value: its scene, who is in it, what it was asked and what came of that."""

from __future__ import annotations

from dataclasses import dataclass, field

from app.classroom.collect.collection import Collection
from app.classroom.student import Role
from app.viewer.gallery.saved_scene import SavedScene

MOST_STUDENTS = 1_000
MOST_QUESTIONS = 50
SEATS = 40


@dataclass(frozen=True)
class SavedStudent:
    """A student as the file of a class has them."""

    role: Role
    scene: SavedScene | None = None
    """Their flock as it was last; None: they have had none."""


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
