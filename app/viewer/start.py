"""What a flock is set up from."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from agents.flock import Flock

MOST_AGENTS = 200_000
"""More agents than this are set up from the command line or a script, not from a browser."""
WORLDS = {
    "wrap": "wraps around",
    "wrap-plain": "wraps, seam is a wall",
    "open": "open plane",
}
ACTIVATIONS = {
    "synchronous": "all at once",
    "random": "random order",
    "sequential": "one by one",
}
NOISES = {"angular": "angular", "vectorial": "vectorial"}


@dataclass(frozen=True)
class Start:
    """Everything that Setup decides; the same start gives the same run, to the bit."""

    model: str = "hwvem"
    agents: int = 100
    seed: int = 1
    size: float | None = None
    """Side of the world, length; None for the model's own density."""
    dim: int = 2
    world: str = "wrap"
    activation: str = "synchronous"
    noise: str = "angular"
    informed: int | None = None
    """Number of information agents; None for the model's own."""
    threads: int = 1
    parameters: dict[str, Any] = field(default_factory=dict)

    def build(self) -> Flock:
        """The flock at tick 0. Raises Refusal if something is out of range."""
        return Flock(
            self.model,
            agents=self.agents,
            size=self.size,
            dim=self.dim,
            world=self.world,
            activation=self.activation,
            noise=self.noise,
            informed=self.informed,
            rng=self.seed,
            threads=self.threads,
            **self.parameters,
        )

    def but(self, **changes: Any) -> Start:
        """The same start with some things changed."""
        return replace(self, **changes)

    def differs(self, other: Start) -> list[str]:
        """Names of what differs from another start, seed and parameters left out."""
        named = ("model", "agents", "size", "dim", "world", "activation", "noise", "informed")
        return [name for name in named if getattr(self, name) != getattr(other, name)]
