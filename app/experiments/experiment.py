"""An experiment: a table or a figure of a paper, as sets of runs to make."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from app.experiments.file import File, Published, Row, Said, Sweep
from app.experiments.folder import experiments_folder
from app.experiments.kinds import KINDS, Settings
from app.experiments.kinds.settings import Measure
from app.experiments.lines import place
from app.experiments.strict import Value
from worlds.refusal import Refusal, unknown


@dataclass(frozen=True)
class Cell:
    """One set of runs that differ by their seed only."""

    model: str
    agents: int
    """N as the paper counts it."""
    size: float | None
    """Side of the box; None for the world's own."""
    parameters: dict[str, Value] = field(hash=False)
    row: Row | None = field(default=None, hash=False)
    sweep: Sweep | None = field(default=None, hash=False)

    @property
    def label(self) -> str:
        """Its name in a table."""
        return (self.row.label if self.row else "") or self.model

    @property
    def value(self) -> Value | None:
        """The value of the swept parameter."""
        return self.parameters[self.sweep.parameter] if self.sweep else None

    def published(self, measure: str) -> Published | None:
        """What the paper prints of a measure."""
        return self.row.published.get(measure) if self.row else None


@dataclass(frozen=True)
class Experiment:
    """A table or a figure as cells to run."""

    name: str
    title: str
    source: str
    picture: str
    runs: int
    settings: Settings
    measures: list[Measure]
    """Those to report, the main one first."""
    not_reproduced: dict[str, str]
    not_compared: dict[str, str]
    notes: dict[str, str]
    cells: list[Cell]
    said: list[Said]
    """What the paper claims."""

    def narrowed(self, models: list[str], agents: list[int]) -> Experiment:
        """Only some models (or labels) and sizes; empty lists keep all.

        Raises Refusal for unknown ones.
        """
        named = {name for cell in self.cells for name in (cell.model, cell.label)}
        for kind, asked, known in (
            ("model", models, named),
            ("agents", agents, {cell.agents for cell in self.cells}),
        ):
            for one in asked:
                if one not in known:
                    names = [str(name) for name in sorted(known)]
                    raise unknown(kind, str(one), names, self.name)
        kept = [
            cell
            for cell in self.cells
            if (not models or cell.model in models or cell.label in models)
            and (not agents or cell.agents in agents)
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
        values = tomllib.loads(text)
    except OSError as error:
        raise Refusal(f"{str(path)!r} cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise Refusal(f"{path} is not TOML: {error}") from None
    kind = values.get("kind", "convergence")
    if kind not in KINDS:
        raise unknown("kind of experiment", str(kind), KINDS, place(path, text, "kind"))
    try:
        of_kind: Any = File.__class_getitem__(KINDS[kind])
        file: File = of_kind(**values)
    except ValidationError as error:
        first = error.errors()[0]
        keys = [str(part) for part in first["loc"] if not isinstance(part, int)]
        where = place(path, text, keys[-1], ".".join(keys[:-1]))
        raise Refusal(f"{'.'.join(keys)}: {first['msg']} ({where})") from None
    check_sizes(file, path)
    check_measures(file, path)
    main = file.settings.measures[0].name
    return Experiment(
        path.stem,
        file.title,
        file.source,
        file.picture,
        file.runs,
        file.settings,
        [file.settings.measure(name) for name in file.report or [main]],
        file.not_reproduced,
        file.not_compared,
        file.notes,
        cells_of(file),
        list(file.claims),
    )


def check_sizes(file: File, path: Path) -> None:
    """Refuse a file that gives sizes, but not for all rows."""
    if file.sizes or file.settings.kind == "convergence":
        for n in [row.agents for row in file.rows] + [n for one in file.sweeps for n in one.agents]:
            if str(n) not in file.sizes:
                raise Refusal(f"agents = {n} has no side in [sizes] ({path})")


def check_measures(file: File, path: Path) -> None:
    """Refuse a file that names a measure which its kind of runs does not have."""
    known = [one.name for one in file.settings.measures]
    named: list[Iterable[str]] = [file.report, file.not_reproduced, file.not_compared]
    named += [row.published for row in file.rows]
    named.append(claim.measure for claim in file.claims)
    for names in named:
        for name in names:
            if name not in known:
                raise unknown("measure", name, known, str(path))


def cells_of(file: File) -> list[Cell]:
    """The rows and the sweeps' points, in the order of the file."""
    shared = file.settings.parameters
    cells = [
        Cell(row.model, row.agents, file.sizes.get(str(row.agents)), shared | row.parameters, row)
        for row in file.rows
    ]
    for sweep in file.sweeps:
        for n in sweep.agents:
            for value in sweep.values:
                given: dict[str, Any] = shared | sweep.fixed | {sweep.parameter: value}
                size = file.sizes.get(str(n))
                cells.append(Cell(sweep.model, n, size, given, sweep=sweep))
    return cells
