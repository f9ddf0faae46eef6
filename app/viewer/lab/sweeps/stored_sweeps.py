"""What the page shows of the sweeps in a folder, read from their stores."""

from __future__ import annotations

import tempfile
import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from agents.catalogue import FILES
from agents.catalogue import model as find_model
from agents.flock_world import find_world
from app.strict_table import Value
from app.studies.charts.axis_limits import observable_of
from app.studies.charts.run_group import CellRuns, is_number
from app.studies.run_axes import AxisModels
from app.studies.runs.database import FILE
from app.studies.runs.store_reader import StoreReader
from app.studies.study_runner import SPEC
from app.studies.sweeps.sweep_picture import draw
from app.studies.sweeps.sweep_table import (
    as_csv,
    axes_of,
    groups_of,
    measured_columns,
    places_of,
    spec_at,
    status_of,
    wide_table,
    write_table,
)
from app.viewer.gallery.saved_scene import TEXTS, SavedScene
from app.viewer.measuring.observable_curves import chart_title
from app.viewer.measuring.observable_format import format_short
from app.viewer.run.run_preset import preset_spec
from worlds.input_error import InputError
from worlds.text_file import read_text

MOST_SWEEPS = 50
"""Sweeps that are named, the newest ones."""
MOST_SHOWN = 20_000
"""Runs of a sweep that the page draws."""


@dataclass(frozen=True)
class ListedSweep:
    """How far a sweep is."""

    name: str
    state: str
    """running, stopped, done; begins, until there is a store."""
    done: int = 0
    of: int = 0
    counts: dict[str, int] = field(default_factory=dict)
    rate: float | None = None
    """Runs a second."""
    left: float | None = None
    """Seconds."""

    @property
    def runs(self) -> bool:
        """Whether a process makes runs of it."""
        return self.state in ("running", "begins")


@dataclass(frozen=True)
class DrawnSweep:
    """What is drawn of a sweep: its cells with their runs, by their places in the plan."""

    name: str
    models: AxisModels
    """Of its runs."""
    axes: dict[str, list[Value]]
    """What it is swept over, each with its values in order."""
    columns: tuple[str, ...]
    column: str
    cells: dict[int, CellRuns]
    """With and without runs."""
    ticks: int
    """Of a run, at most."""


def named_in(results: Path) -> list[str]:
    """The folders of stores in a folder, the newest first."""
    if not results.is_dir():
        return []
    found = [one for one in results.iterdir() if (one / FILE).is_file()]
    found.sort(key=lambda one: (one / FILE).stat().st_mtime, reverse=True)
    return [one.name for one in found[:MOST_SWEEPS]]


def listed(folder: Path) -> ListedSweep | None:
    """How far a sweep is; None for a store of anything else. Raises InputError."""
    if StoreReader(folder).state.get("kind") != "sweep":
        return None
    made = status_of(folder)
    return ListedSweep(
        folder.name,
        made["state"],
        made["done"],
        made["of"] or 0,
        made["runs"],
        made["rate"],
        made["seconds_left"],
    )


def read_drawn_sweep(folder: Path, column: str | None = None) -> DrawnSweep:
    """The cells of a sweep, by its first column or another. Raises InputError."""
    kept = StoreReader(folder)
    state = kept.state
    if state.get("runs", 0) > MOST_SHOWN:
        raise InputError(
            f"{state['runs']:,} runs are not drawn in the page: flockscope sweep plot {folder.name}"
        )
    columns, places, cells = measured_columns(kept), places_of(kept), kept.cells
    if not columns:
        raise InputError("nothing with one value for each run is measured: take the table")
    name = column if column in columns else columns[0]
    axes = {
        axis: in_order([cell["axes"].get(axis) for cell in cells.values()])
        for axis in axes_of(kept)
    }
    found = {places[number]: CellRuns(cell["axes"], number) for number, cell in cells.items()}
    if any(kept.counts.values()):
        found |= {places[group.number]: group for group in groups_of(kept, name)[1]}
    return DrawnSweep(
        folder.name,
        AxisModels.of_table(tomllib.loads(state["base"])),
        {axis: values for axis, values in axes.items() if len(values) > 1},
        tuple(columns),
        name,
        found,
        int(state.get("limit", 0)),
    )


def in_order(values: list[Value | None]) -> list[Value]:
    """Each value once: numbers rising, words as they come."""
    once = [one for one in dict.fromkeys(values) if one is not None]
    return sorted(once) if all(map(is_number, once)) else once


def typical(group: CellRuns) -> int | None:
    """The seed of the run that is nearest to the mean of its cell; None without any."""
    if not group.values:
        return None
    nearest = min(range(len(group.values)), key=lambda k: abs(group.values[k] - group.mean))
    return group.seeds[nearest]


def scene_of(folder: Path, place: int, seed: int | None, column: str | None) -> SavedScene:
    """A run of a cell as a scene, by default the one nearest to the cell's mean. Raises
    InputError."""
    made = read_drawn_sweep(folder, column)
    if place not in made.cells:
        raise InputError(f"cell {place} is not in {folder.name}: it has {len(made.cells)}")
    group = made.cells[place]
    if seed is None:
        seed = typical(group)
    if seed is None:
        row = next((row for row in StoreReader(folder).runs([]) if row[0] == group.number), None)
        if row is None:
            raise InputError(f"cell {place} of {folder.name} has no run yet")
        seed = int(row[1])
    spec = spec_at(StoreReader(folder), place, seed)
    for name in spec.models:
        if name in FILES:
            raise InputError(f"{name} is a model of a file: the page does not open it")
    if isinstance(spec.world, str) and spec.world.endswith(".toml"):
        whole = preset_spec(**dict(spec))
        spec = spec.but(world=find_world(whole, find_model(spec.model)), size=None)
    where = ", ".join(f"{axis} = {few_of(value)}" for axis, value in group.axes.items())
    values = {
        "title": f"{folder.name}: {where}, seed {seed}"[: TEXTS["title"]],
        "watch": describe_run(made, group, seed)[: TEXTS["watch"]],
        "plots": plots_of(made.column),
        "run": tomllib.loads(spec.to_toml()),
    }
    return SavedScene.from_values(values, folder.name)


def describe_run(made: DrawnSweep, group: CellRuns, seed: int) -> str:
    """What the sweep has of a run, in a sentence."""
    where = ", ".join(f"{axis} = {few_of(value)}" for axis, value in group.axes.items())
    said = f"Run of {made.name}: {where}, seed {seed}."
    value = dict(zip(group.seeds, group.values, strict=True)).get(seed)
    if value is None:
        return f"{said} It has no value there."
    return f"{said} There {made.column} came to {format_short(value)} within {made.ticks} ticks."


def plots_of(column: str) -> list[str]:
    """The plot of a column that is an observable."""
    name = observable_of(column)
    return [chart_title((name,))] if name else []


def few_of(value: Any) -> str:
    """A value of an axis for people."""
    return f"{value:.3g}" if isinstance(value, float) else str(value)


# What can be taken along of a sweep: its table, its picture, its file.

TABLES, PICTURES, SPEC_FILE = ("CSV", "Parquet"), ("PNG", "SVG"), "Spec"


def content(folder: Path, kind: str, column: str | None = None) -> tuple[str, bytes]:
    """Name and bytes of one of its files. Raises InputError."""
    if kind == SPEC_FILE:
        path = folder / SPEC
        return f"{folder.name}.toml", read_text(f"sweep {str(path)!r}", path).encode()
    kept = StoreReader(folder)
    if kind == "CSV":
        return f"{folder.name}.csv", as_csv(wide_table(kept)).encode()
    if kind not in (*TABLES, *PICTURES):
        raise InputError(f"{kind!r} is not one of {', '.join((*TABLES, *PICTURES, SPEC_FILE))}")
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / f"{folder.name}.{kind.lower()}"
        if kind == "Parquet":
            write_table(wide_table(kept), path, False)
        else:
            draw(kept, path, column)
        return path.name, path.read_bytes()
