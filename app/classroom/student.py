"""A student of a class: who, in what role, with which flock."""

from __future__ import annotations

import asyncio
import time
from dataclasses import dataclass, field
from enum import StrEnum

from app.classroom.workers.worker_process import WorkerProcess


class Role(StrEnum):
    """What a student does."""

    WATCHING = "watching"
    """The teacher's run, with a camera of one's own and nothing that changes it."""
    OWN = "own"
    """A flock of one's own, from the teacher's scene."""


@dataclass(frozen=True)
class LaboratoryAddress:
    """Where a laboratory is."""

    worker: WorkerProcess
    address: str
    """Where the front finds it, with the secret of its process."""


@dataclass
class Student:
    """One student. `key` is the hash of their cookie; the cookie itself is kept nowhere."""

    number: int
    name: str
    key: str
    role: Role
    scene: str = ""
    """What their own flock ran when it was last looked at, TOML; empty: they have had none."""
    frozen: bool = False
    """Whether their flock is held by the teacher: nothing but their camera is heard."""
    value: float | None = None
    """What the question has given them to try."""
    place: LaboratoryAddress | None = None
    """Where their own flock is, while it is anywhere."""
    worker: WorkerProcess | None = None
    """The process that has it, or is about to."""
    lines: int = 0
    """Pages that are connected."""
    left: float = field(default_factory=time.monotonic)
    """When the last page went, s."""
    came: bool = False
    """Whether a page of theirs was ever connected."""
    moves: int = 0
    """Counts the changes of what their page shows: each has it connect anew."""
    opening: asyncio.Lock = field(default_factory=asyncio.Lock)

    @property
    def is_here(self) -> bool:
        """Whether a page of theirs is connected."""
        return self.lines > 0
