"""The tables of a map of phases and of the ways there and back, within 80 columns."""

from __future__ import annotations

from typing import Any

from app.studies.verdicts.phase_map import PhasePoint, map_of, ways_of
from app.studies.verdicts.statistics import MeasureSummary
from app.studies.verdicts.verdict import Verdict

SHORT = {
    "fragments": "frag",
    "swarm": "swarm",
    "torus": "torus",
    "dynamic parallel": "dyn",
    "highly parallel": "high",
    "disperses": "apart",
    "flock": "flock",
    "ring": "ring",
    "mill": "mill",
    "double mill": "2mill",
    "disordered": "dis",
}
STYLES = {
    "fragments": "dim",
    "swarm": "yellow",
    "torus": "magenta",
    "dynamic parallel": "cyan",
    "highly parallel": "blue",
    "disperses": "dim",
    "flock": "blue",
    "ring": "green",
    "mill": "magenta",
    "double mill": "cyan",
    "disordered": "yellow",
}


def phase_tables(made: list[Verdict]) -> Any:
    """Both tables, as far as there are places of their kind."""
    from rich.console import Group

    tables = [map_table(map_of(made)), ways_table(ways_of(made))]
    return Group(*(table for table in tables if table is not None))


def map_table(found: list[PhasePoint]) -> Any | None:
    """Three lines for each value of the second parameter: p, m and the commonest phase."""
    if not found:
        return None
    sweep = found[0].case.sweep
    assert sweep is not None
    xs = sorted({spot.x for spot in found})
    table = blank("", *(f"{x:g}" for x in xs))
    table.title = f"columns: {sweep.parameter}, rows: {sweep.against}"
    for y in sorted({spot.y for spot in found}, reverse=True):
        row = {spot.x: spot for spot in found if spot.y == y}
        line = [row.get(x) for x in xs]
        table.add_row(f"{y:g} p", *(mean(spot.p if spot else None) for spot in line))
        table.add_row("m", *(mean(spot.m if spot else None) for spot in line))
        table.add_row("", *(short(spot) for spot in line), end_section=True)
    return table


def ways_table(pairs: list[tuple[PhasePoint, PhasePoint]]) -> Any | None:
    """A line for each value: p, m and the commonest phase on the way there and back."""
    if not pairs:
        return None
    sweep = pairs[0][0].case.sweep
    assert sweep is not None
    heads = ("p", "m", "there", "p", "m", "back")
    table = blank(sweep.parameter, *heads)
    for up, down in pairs:
        cells = [text for spot in (up, down) for text in (mean(spot.p), mean(spot.m), short(spot))]
        table.add_row(f"{up.x:g}", *cells)
    return table


def blank(*columns: str) -> Any:
    """An empty table."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, padding=0, pad_edge=False, title_justify="left")
    for column in columns:
        table.add_column(column, justify="right", no_wrap=True)
    return table


def mean(one: MeasureSummary | None) -> str:
    """A mean to two digits."""
    return "" if one is None else f"{one.mean:.2f}"


def short(spot: PhasePoint | None) -> str:
    """The commonest phase in its colour."""
    return "" if spot is None else f"[{STYLES[spot.phase]}]{SHORT[spot.phase]}[/]"
