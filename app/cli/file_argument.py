"""A file where the name of a model may stand: what it is, told by its content."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any, NamedTuple

from agents.catalogue import MODELS
from worlds.input_error import InputError

STATE, TOML = "state", "toml"
RUN = "run"
"""The table of a scene that has its run; a spec has none."""


class FileArgument(NamedTuple):
    """A file that says which run it is."""

    path: Path
    kind: str
    """STATE: a saved state or a recording; TOML: a scene or a spec."""


def is_file(name: str | None) -> bool:
    """Whether it names a file, there or not, and not a model."""
    if name is None or name in MODELS:
        return False
    return bool(Path(name).suffix) or os.sep in name or Path(name).exists()


def file_argument(name: str) -> FileArgument:
    """What a file is, as `flockscope lab` opens it too. Raises InputError for what it cannot be."""
    from app.viewer.gallery.file_opener import demand_kind, head_of
    from app.viewer.run.stored_flock import PARQUET

    head = head_of(name)
    demand_kind(name, head)
    return FileArgument(Path(name), STATE if head.startswith(PARQUET) else TOML)


def scene_run(path: Path, text: str) -> dict[str, Any]:
    """The values of the run of a scene, nothing of it left open. Raises InputError."""
    from app.viewer.gallery.saved_scene import read_scene

    return tomllib.loads(read_scene(str(path), text.encode()).spec.to_toml())


def demand_alone(name: str, others: dict[str, Any]) -> None:
    """Raise InputError if anything else says, beside a file, which run it is."""
    for option, value in others.items():
        if value:
            raise InputError(f"{option} {value} cannot be given with {name}, which says it already")


def compared_model(path: Path) -> str:
    """The model that a scene shows beside its own; empty if there is none, or it is a spec."""
    beside = tomllib.loads(path.read_text("utf-8-sig")).get("beside", {})
    return str(beside.get("model", "")) if isinstance(beside, dict) else ""
