"""A simulator as a source: it lives in the child process and keeps to the wall clock."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

from app.live.control.pose import MocapFrame, Sighting
from worlds.input_error import InputError


class Simulator(Protocol):
    """A room with cars that are computed: plant, tracking noise, dropouts and all."""

    def advance(self, seconds: float) -> None:
        """Let it live on until `seconds` after its start; what drives its cars is its own matter,
        e.g. the emulated firmware at the end of a link."""
        ...

    def sightings(self) -> tuple[Sighting, ...]:
        """What tracking says of its cars now."""
        ...

    def close(self) -> None:
        """Give back what it holds, such as the end of a link."""
        ...


@dataclass(frozen=True)
class SimulatedSource:
    """A simulator that is tracked at a steady rate.

    A machine too slow for it loses frames, as a camera would, never time: numbers leap.
    """

    build: Callable[[], Simulator]
    """Makes the simulator in the child process: a function of a module, which can be pickled."""
    rate: float = 100.0
    """Frames per second."""
    title: str = "simulated cars"
    name: str = "simulated"
    longest_gap: float = math.inf

    def __post_init__(self) -> None:
        if not 1.0 <= self.rate <= 1000.0:
            raise InputError(f"rate = {self.rate:g} Hz is outside [1, 1000]")

    def describe(self) -> str:
        """What it is in a few words."""
        return f"{self.title} at {self.rate:g} Hz"

    def frames(self, stop: threading.Event) -> Iterator[MocapFrame]:
        """Build the simulator, then give a frame per period; see `Source.frames`."""
        return self._tracked(self.build(), stop)

    def _tracked(self, simulator: Simulator, stop: threading.Event) -> Iterator[MocapFrame]:
        try:
            began = time.monotonic()
            number = 0
            while not stop.wait(max(0.0, began + number / self.rate - time.monotonic())):
                simulator.advance(number / self.rate)
                yield MocapFrame(
                    number, time.monotonic(), simulator.sightings(), number / self.rate
                )
                number = max(number, int((time.monotonic() - began) * self.rate)) + 1
        finally:
            simulator.close()
