"""One run: a flock from its set-up to the next, and what is seen of it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from agents.flock import Flock
from app.viewer.frame import Frame
from app.viewer.picture import Camera, Wanted
from app.viewer.readings import Readings


class Run:
    """A flock, its readings and the frames taken of it."""

    def __init__(self, flock: Flock, number: int, wanted: Wanted):
        self.flock = flock
        self.number = number
        self.readings = Readings(flock)
        self.camera = Camera(flock, number, wanted)
        self.compiled = False
        """Whether the flock has run, so that its next tick need not be compiled."""
        self.troubles: list[Exception] = []
        """What went wrong in looking, each kind once; the flock runs on all the same."""

    @property
    def values(self) -> dict[str, Any]:
        """The flock's parameters, name -> value."""
        return self.flock.parameters.model_dump()

    def advance(self, ticks: int) -> None:
        """Run ticks. Raises whatever the rule raises."""
        self.flock.advance(ticks)
        self.compiled = True

    def look(self, closely: bool) -> Frame:
        """Read what is due (everything, if `closely`) and take a frame.

        Raises ArithmeticError, naming the agent, if a position is no finite number.
        """
        flock = self.flock
        lost = ~np.isfinite(flock.position).all(axis=1)
        if lost.any():
            row = int(np.argmax(lost))
            raise ArithmeticError(
                f"agent {flock.ids[row]} has position {flock.position[row].tolist()} at tick "
                f"{flock.tick}: every position must be a finite number"
            )
        self.attempt(lambda: self.readings.read(at_once=closely))
        self.attempt(self.camera.examine)
        self.attempt(self.camera.inspect)
        return self.camera.take()

    def attempt(self, look: Callable[[], None]) -> None:
        """Look; note what goes wrong."""
        try:
            look()
        except Exception as error:
            if repr(error) not in map(repr, self.troubles):
                self.troubles.append(error)

    def place(self, row: int, position: np.ndarray, heading: np.ndarray) -> None:
        """Put an agent somewhere and turn it."""
        self.flock.position[row] = position
        self.flock.heading[row] = heading

    def saved(self) -> bytes:
        """The flock's state as a file."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "flock.parquet"
            self.flock.save(path)
            return path.read_bytes()
