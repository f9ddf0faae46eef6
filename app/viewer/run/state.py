"""How the simulation stands."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from app.viewer.run.start import Start


@dataclass(frozen=True)
class State:
    """How the simulation stands; replaced as a whole, never changed."""

    start: Start
    """What the flock was set up from."""
    run: int = 0
    """Counts the set-ups."""
    running: bool = False
    busy: bool = False
    """Whether a flock is being set up or compiled."""
    error: str = ""
    """What stopped the run; Setup or Reset mends it."""
    speed: float = 15.0
    """Wanted ticks per second; infinity for as fast as it goes."""
    rate: float = 0.0
    """Ticks per second as they happen."""
    agents: int = 0
    """Rows of the flock, information agents among them."""
    values: dict[str, Any] = field(default_factory=dict)
    """The flock's parameters, name -> value."""
    beside_values: dict[str, Any] = field(default_factory=dict)
    """Those that only the flock beside it has."""

    def again(self) -> Start:
        """The start of this run with the parameters as they are now."""
        start = self.start
        return start.but(
            parameters=dict(self.values) or start.parameters,
            beside_parameters=dict(self.beside_values) or start.beside_parameters,
        )
