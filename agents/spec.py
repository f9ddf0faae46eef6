"""A run as a value: everything that makes its numbers, to TOML and back."""

from __future__ import annotations

import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal

import tomlkit
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from worlds.reading import read_text, toml
from worlds.refusal import Refusal, needed, shortened, unknown

Activation = Literal["synchronous", "random", "sequential"]
Noise = Literal["angular", "vectorial"]
LARGEST_SEED = 2**63 - 1
ACTIVATIONS: tuple[Activation, ...] = ("synchronous", "random", "sequential")
NOISES: tuple[Noise, ...] = ("angular", "vectorial")


def versions() -> dict[str, str]:
    """Versions of what the numbers depend on."""
    packages = {name: version(name) for name in ("flockscope", "mesa", "numba", "numpy")}
    return {"python": platform.python_version(), **packages}


class Spec(BaseModel):
    """A run: the same spec gives the same numbers, to the bit, on the same machine.

    `start = "given"` marks a run that began from a user's arrays: its spec describes it, but only a
    saved state can begin it again.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, strict=False, allow_inf_nan=False)

    model: str
    agents: int = Field(ge=1)
    informed: int = Field(ge=0)
    seed: int = Field(ge=0, le=LARGEST_SEED)
    world: str
    size: tuple[float, ...]
    activation: Activation = "synchronous"
    noise: Noise = "angular"
    start: Literal["random", "given"] = "random"
    spacing: float | None = Field(default=None, ge=0.0)
    """Least distance at the start between agents and of agents to what is solid; None: none."""
    parameters: dict[str, bool | float | str] = Field(default_factory=dict)
    layout: dict[str, Any] | None = None
    """The world itself, where it is none of the built-in ones."""
    versions: dict[str, str] = Field(default_factory=dict)

    @property
    def dim(self) -> int:
        """2 or 3."""
        return len(self.size)

    def to_toml(self) -> str:
        """The spec as TOML; floats are written so that they come back to the bit."""
        return tomlkit.dumps(self.model_dump(mode="json", exclude_none=True))

    @classmethod
    def from_toml(cls, text: str, origin: str = "TOML text") -> Spec:
        """A spec from TOML. Raises Refusal naming the line or the key that is wrong."""
        return cls.from_values(toml(text, origin), origin)

    @classmethod
    def from_values(cls, values: dict[str, Any], origin: str) -> Spec:
        """A spec from a dictionary. Raises Refusal naming the key that is wrong."""
        for key in values:
            if key not in cls.model_fields:
                raise unknown("key", key, cls.model_fields, origin)
        try:
            return cls(**values)
        except ValidationError as error:
            first = error.errors()[0]
            key = ".".join(str(part) for part in first["loc"])
            if first["type"] == "missing":
                raise Refusal(f"{key} is missing ({origin})") from None
            raise Refusal(
                f"{key} = {shortened(first['input'])} is not allowed: {needed(first)} ({origin})"
            ) from None

    @classmethod
    def read(cls, path: str | Path) -> Spec:
        """A spec from a TOML file. Raises Refusal."""
        return cls.from_toml(read_text(f"spec {str(path)!r}", path), str(path))
