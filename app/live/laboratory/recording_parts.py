"""The parts of a recording: a room that runs for days has its newest ones.

The first lies in the recording's folder itself, so that a short recording is nothing but its
tables; those that follow lie in it as `0002`, `0003` and so on.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from pydantic import Field, model_validator

from app.strict_table import StrictTable

MB = 1_000_000
RESERVE = 3.0
"""Parts for which there must be space when one begins: itself, the one before, its tables."""


class RecordingLimits(StrictTable):
    """How much of a recording is kept on the disk, MB."""

    part: float = Field(default=200.0, ge=1.0, le=10_000.0)
    """A new part begins when one has come to so much."""
    most: float = Field(default=20_000.0, ge=4.0, le=10_000_000.0)
    """The oldest parts are removed before all of it comes to more."""

    @model_validator(mode="after")
    def _holds_four_parts(self) -> RecordingLimits:
        least = (RESERVE + 1.0) * self.part
        if self.most < least:
            raise ValueError(f"most must be at least four parts, {least:g}")
        return self


@dataclass(frozen=True)
class RecordingPart:
    """One part of a recording."""

    number: int
    """From 1."""
    folder: Path

    def table(self, name: str) -> Path:
        """Where a table of it is, once it is finished."""
        return self.folder / f"{name}.parquet"

    def stream(self, name: str) -> Path:
        """Where a table of it is while it is written."""
        return self.folder / f"{name}.parquet.part"

    @property
    def has_begun(self) -> bool:
        """Whether anything of it counts: its ticks are begun last, and removed first."""
        return self.table("ticks").exists() or self.stream("ticks").exists()

    def size(self) -> int:
        """Bytes on the disk."""
        return sum(file.stat().st_size for file in self.folder.glob("*.parquet*"))

    def remove(self) -> None:
        """Delete its tables. Raises OSError."""
        self.table("ticks").unlink(missing_ok=True)
        for file in self.folder.glob("*.parquet*"):
            file.unlink()
        if self.number > 1:
            self.folder.rmdir()


def part_of(folder: Path, number: int) -> RecordingPart:
    """Part `number` of the recording in a folder, whether it is there or not."""
    return RecordingPart(number, folder if number == 1 else folder / f"{number:04d}")


def parts_of(folder: Path) -> list[RecordingPart]:
    """The parts of a recording that are there, the oldest first; empty if it is none."""
    numbers = [1]
    if folder.is_dir():
        numbers += [
            int(path.name) for path in folder.iterdir() if re.fullmatch(r"[0-9]{4,9}", path.name)
        ]
    parts = [part_of(folder, number) for number in sorted(set(numbers)) if number > 0]
    return [part for part in parts if part.has_begun]
