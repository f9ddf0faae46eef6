"""A class as a value: its scene, who is in it, what it was asked and what came of that."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from pydantic import ConfigDict, Field

from app.classroom.collect.collection import Collection
from app.strict import Strict
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.run.home import MOST_AGENTS

Role = Literal["watching", "own flock"]
"""What a student has: the teacher's run to look at, or a laboratory of the class's scene."""
MOST_STUDENTS = 1_000
MOST_QUESTIONS = 50


class Limits(Strict):
    """What the students of a class may have."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, strict=True)

    students: int = Field(default=40, ge=1, le=MOST_STUDENTS)
    agents: int = Field(default=2_000, ge=1, le=MOST_AGENTS)
    """Of a student's flock."""


USUAL = Limits()


@dataclass(frozen=True)
class Student:
    """A student of a class."""

    role: Role
    scene: SavedScene | None = None
    """Their flock as it was last; None: they have had none."""


@dataclass
class ClassState:
    """A whole class."""

    title: str
    scene: SavedScene
    students: dict[str, Student] = field(default_factory=dict)
    """By name, in the order in which they came."""
    questions: list[Collection] = field(default_factory=list)
    limits: Limits = USUAL
