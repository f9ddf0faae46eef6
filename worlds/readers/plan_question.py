"""Questions that a drawing leaves open: one line to read, and the choices that answer it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from worlds.input_error import InputError


@dataclass(frozen=True)
class PlanChoice:
    """An answer: what a person reads, and what it adds to the call of `read_geometry`."""

    label: str
    options: Mapping[str, Any] = field(default_factory=dict)
    """Keywords; `roles` are added to those that are given."""
    thickness: bool = False
    """Whether it needs a thickness of walls beside."""


class PlanQuestion(InputError):
    """A drawing that may mean two things; its text says how the command line answers it."""

    def __init__(self, line: str, choices: tuple[PlanChoice, ...]) -> None:
        super().__init__(line)
        self.choices = choices
