"""An experiment: a table or a figure of a paper, read from its TOML file."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from app.experiments.folder import experiments_folder
from app.experiments.lines import place
from worlds.refusal import Refusal, unknown

Value = bool | float | str


class Strict(BaseModel):
    """A table of the file; keys that it does not have are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Settings(Strict):
    """What all rows share: the world, when a flock counts as consistent, parameters."""

    world: str
    desired: float = Field(gt=0.0, lt=1.0)
    hold: int = Field(ge=1)
    limit: int = Field(ge=1)
    parameters: dict[str, Value] = Field(default_factory=dict)


class Row(Strict):
    """One row of a table, with the published mean and quartiles."""

    model: str
    agents: int = Field(ge=1)
    parameters: dict[str, Value] = Field(default_factory=dict)
    mean: float | None = None
    quartiles: tuple[float, float, float] | None = None
    not_reproduced: str = ""
    """Why this row does not come out; empty where it does."""
    remark: str = ""
    """What else is known of it."""


class Sweep(Strict):
    """One parameter over several values, for several sizes of flock."""

    model: str
    agents: list[int] = Field(min_length=1)
    parameter: str
    values: list[Value] = Field(min_length=1)
    fixed: dict[str, Value] = Field(default_factory=dict)
    trend: Literal["rises", "falls"] | None = None
    """What the paper says the time does along the values."""
    flat_from: float | None = None
    """The value from which on, the paper says, it hardly changes."""


class File(Strict):
    """A whole file."""

    title: str
    source: str
    picture: Literal["models", "sweeps", "pairs"]
    runs: int = Field(ge=2)
    settings: Settings
    sizes: dict[str, float]
    notes: dict[str, str] = Field(default_factory=dict)
    rows: list[Row] = Field(default_factory=list)
    sweeps: list[Sweep] = Field(default_factory=list)


@dataclass(frozen=True)
class Cell:
    """One set of runs that differ by their seed only."""

    model: str
    agents: int
    size: float
    parameters: dict[str, Value] = field(hash=False)
    published: Row | None = field(default=None, hash=False)
    sweep: Sweep | None = field(default=None, hash=False)

    @property
    def value(self) -> Value | None:
        """The value of the swept parameter."""
        return self.parameters[self.sweep.parameter] if self.sweep else None


@dataclass(frozen=True)
class Experiment:
    """A table or a figure as cells to run."""

    name: str
    title: str
    source: str
    picture: str
    runs: int
    settings: Settings
    notes: dict[str, str]
    cells: list[Cell]

    def narrowed(self, models: list[str], agents: list[int]) -> Experiment:
        """Only some models and sizes; empty lists keep all. Raises Refusal for unknown ones."""
        for kind, asked, known in (
            ("model", models, {cell.model for cell in self.cells}),
            ("agents", agents, {cell.agents for cell in self.cells}),
        ):
            for one in asked:
                if one not in known:
                    names = [str(name) for name in sorted(known)]
                    raise unknown(kind, str(one), names, self.name)
        kept = [
            cell
            for cell in self.cells
            if (not models or cell.model in models) and (not agents or cell.agents in agents)
        ]
        return replace(self, cells=kept)


def experiment_names() -> list[str]:
    """Names of all experiments."""
    return sorted(path.stem for path in experiments_folder().glob("*.toml"))


def read_experiment(name: str) -> Experiment:
    """The experiment of that name. Raises Refusal."""
    if name not in experiment_names():
        raise unknown("paper", name, experiment_names())
    return read_file(experiments_folder() / f"{name}.toml")


def read_file(path: Path) -> Experiment:
    """The experiment of a TOML file. Raises Refusal naming file and line."""
    try:
        text = path.read_text(encoding="utf-8")
        file = File(**tomllib.loads(text))
    except OSError as error:
        raise Refusal(f"{str(path)!r} cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise Refusal(f"{path} is not TOML: {error}") from None
    except ValidationError as error:
        first = error.errors()[0]
        keys = [str(part) for part in first["loc"] if not isinstance(part, int)]
        where = place(path, text, keys[-1], ".".join(keys[:-1]))
        raise Refusal(f"{'.'.join(keys)}: {first['msg']} ({where})") from None
    for n in [row.agents for row in file.rows] + [n for one in file.sweeps for n in one.agents]:
        if str(n) not in file.sizes:
            raise Refusal(f"agents = {n} has no side in [sizes] ({path})")
    return Experiment(
        path.stem,
        file.title,
        file.source,
        file.picture,
        file.runs,
        file.settings,
        file.notes,
        cells_of(file),
    )


def cells_of(file: File) -> list[Cell]:
    """The rows and the sweeps' points, in the order of the file."""
    shared = file.settings.parameters
    cells = [
        Cell(row.model, row.agents, file.sizes[str(row.agents)], shared | row.parameters, row)
        for row in file.rows
    ]
    for sweep in file.sweeps:
        for n in sweep.agents:
            for value in sweep.values:
                given: dict[str, Any] = shared | sweep.fixed | {sweep.parameter: value}
                cells.append(Cell(sweep.model, n, file.sizes[str(n)], given, sweep=sweep))
    return cells
