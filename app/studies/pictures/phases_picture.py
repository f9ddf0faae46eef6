"""Maps of polarisation and angular momentum with the phases, and both there and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.pictures.boxes import explain
from app.studies.verdicts.phase_map import PhasePoint, map_of, ways_of
from app.studies.verdicts.verdict import Verdict

P_COLOURS, M_COLOURS = "Blues", "Purples"
THERE, BACK = "#2166ac", "#c0392b"
LETTERS = {
    "fragments": "F",
    "swarm": "S",
    "torus": "T",
    "dynamic parallel": "D",
    "highly parallel": "H",
}
WORDS = (
    "S swarm, T torus, D dynamic parallel, H highly parallel, F (hatched) fragments: the "
    "phase of most runs; small letters: of less than 80 % of them"
)
HATCH = "#8a93a077"
SURE = 0.8
"""Share of the runs from which on a letter is large."""


def draw_phases(figure: Any, made: list[Verdict]) -> None:
    """Draw the maps above, the ways there and back below."""
    found, ways = map_of(made), ways_of(made)
    rows = [names for names, there in ((["p", "m"], found), (["up", "um"], ways)) if there]
    figure.set_size_inches(12.4, 1.0 + (4.6 if found else 0.0) + (3.4 if ways else 0.0))
    heights = [4.6 if "p" in names else 3.4 for names in rows]
    panels = figure.subplot_mosaic(rows, height_ratios=heights)
    if found:
        draw_map(figure, panels["p"], found, [s.p.mean for s in found], P_COLOURS, "polarisation p")
        draw_map(
            figure, panels["m"], found, [s.m.mean for s in found], M_COLOURS, "angular momentum m"
        )
    if ways:
        draw_ways(panels["up"], ways, "p")
        draw_ways(panels["um"], ways, "m")
        handles = panels["up"].get_legend_handles_labels()[0]
        explain(figure, handles, f"{WORDS}; bars: two standard errors")


def draw_map(
    figure: Any, axes: Any, found: list[PhasePoint], values: list[float], colours: str, title: str
) -> None:
    """Draw a map as equal squares, whatever the steps between the values."""
    from matplotlib.patches import Rectangle

    xs, ys = sorted({spot.x for spot in found}), sorted({spot.y for spot in found})
    grid = np.full((len(ys), len(xs)), np.nan)
    for spot, value in zip(found, values, strict=True):
        grid[ys.index(spot.y), xs.index(spot.x)] = value
    shown = axes.pcolormesh(grid, cmap=colours, vmin=0.0, vmax=1.0, edgecolors="white", linewidth=1)
    for spot, value in zip(found, values, strict=True):
        letter = LETTERS[spot.phase] if spot.share >= SURE else LETTERS[spot.phase].lower()
        x, y = xs.index(spot.x), ys.index(spot.y)
        if spot.phase == "fragments":
            axes.add_patch(
                Rectangle((x, y), 1.0, 1.0, fill=False, hatch="///", linewidth=0, edgecolor=HATCH)
            )
        axes.text(
            x + 0.5,
            y + 0.5,
            f"{letter}\n{value:.2f}",
            ha="center",
            va="center",
            fontsize=8,
            linespacing=1.1,
            color="white" if value > 0.55 else "#2b3138",
        )
    sweep = found[0].case.sweep
    assert sweep is not None
    axes.grid(visible=False)
    axes.set_xticks(np.arange(len(xs)) + 0.5, [f"{x:g}" for x in xs])
    axes.set_yticks(np.arange(len(ys)) + 0.5, [f"{y:g}" for y in ys])
    axes.tick_params(length=0)
    axes.set_xlabel(symbol(sweep.parameter))
    axes.set_ylabel(symbol(sweep.against))
    axes.set_title(title, loc="left")
    for spine in axes.spines.values():
        spine.set_visible(False)
    figure.colorbar(shown, ax=axes, fraction=0.03, pad=0.01)


def draw_ways(axes: Any, ways: list[tuple[PhasePoint, PhasePoint]], name: str) -> None:
    """Draw a measure on the way there and on the way back."""
    for k, (colour, marker, label, arrow) in enumerate(
        [(THERE, "o", "wider and wider", ">"), (BACK, "s", "narrower and narrower", "<")]
    ):
        summaries = [getattr(pair[k], name) for pair in ways]
        axes.errorbar(
            [pair[k].x for pair in ways],
            [s.mean for s in summaries],
            yerr=[2.0 * np.nan_to_num(s.standard_error) for s in summaries],
            color=colour,
            marker=marker,
            markersize=5,
            linewidth=1.8,
            capsize=2.5,
            label=label,
        )
        middle = len(ways) // 2
        (x0, y0), (x1, y1) = [(ways[i][k].x, summaries[i].mean) for i in (middle, middle + 1)]
        axes.plot(0.5 * (x0 + x1), 0.5 * (y0 + y1), arrow, color=colour, markersize=9)
    sweep = ways[0][0].case.sweep
    assert sweep is not None
    fixed = ", ".join(f"{symbol(key)} = {value:g}" for key, value in sweep.fixed.items())
    axes.set_title(f"{symbol(sweep.parameter)} up and down within a run, {fixed}", loc="left")
    axes.set_xlabel(symbol(sweep.parameter))
    axes.set_ylabel(name)
    axes.set_ylim(-0.03, 1.05)


def symbol(parameter: str) -> str:
    """A parameter as a formula writes it."""
    return {"dr_o": r"$\Delta r_o$", "dr_a": r"$\Delta r_a$"}.get(parameter, parameter)
