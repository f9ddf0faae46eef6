"""Where searches have ended, and what that is worth: places scatter on a plateau, values agree."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.studies.verdicts.verdict import Verdict, of

FOUND = {"ga": ("genetic algorithm", "#2166ac", "o"), "pso": ("particle swarm", "#b07d12", "^")}
TOLD = {"default": "paper's weights", "ga": "GA", "pso": "PSO", "plateau": "plateau"}
CALM = {10: "within_10", 12: "within_12", 15: "within_15", 20: "within_20"}


def values(made: list[Verdict], name: str) -> np.ndarray:
    """What was measured in each search; nan where one has none."""
    (row,) = of(made, name)[:1]
    return np.array([np.nan if one is None else one for one in row.values], float)


def draw_optima(figure: Any, made: list[Verdict]) -> None:
    """The weights that were found, and k_con there beside the paper's and the plateau's."""
    figure.set_size_inches(9.6, 4.4)
    left, right = figure.subplots(1, 2)
    for name, (label, colour, marker) in FOUND.items():
        places = values(made, f"{name}_p2"), values(made, f"{name}_p1")
        left.plot(*places, marker, color=colour, label=label, alpha=0.8)
    left.set_xlabel("$p_2$")
    left.set_ylabel("$p_1$")
    left.set_title("the best weights of each search", loc="left")
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower left", ncols=2)
    off = np.random.default_rng(0)
    for k, name in enumerate(TOLD):
        there = values(made, name)
        colour = FOUND.get(name, ("", "#555555", ""))[1]
        right.plot(k + off.uniform(-0.15, 0.15, there.size), there, ".", color=colour, alpha=0.7)
        right.hlines(there.mean(), k - 0.3, k + 0.3, color=colour)
    right.set_xticks(range(len(TOLD)), list(TOLD.values()))
    right.set_ylabel("$k_{con}$ / ticks")
    right.set_ylim(bottom=0.0)
    right.set_title("what they are worth, on fresh seeds", loc="left")


def draw_tradeoff(figure: Any, made: list[Verdict]) -> None:
    """The ends of each front, and the most consistency that a time allows."""
    figure.set_size_inches(7.2, 4.6)
    axes = figure.subplots()
    for name, colour, label in (
        ("quick", "#2166ac", "the quick end of a front"),
        ("calm", "#1b7837", "the calm end of a front"),
        ("default", "#b2182b", "the paper's weights"),
    ):
        places = values(made, name), values(made, f"{name}_deg")
        axes.plot(*places, "o", color=colour, label=label, alpha=0.7, markersize=5)
    means = [np.nanmean(values(made, name)) for name in CALM.values()]
    axes.plot(list(CALM), means, "-", color="#555555", label="most of a front in such a time")
    axes.set_xscale("log")
    ticks = (8, 10, 15, 20, 30, 50)
    axes.set_xticks(ticks, list(map(str, ticks)))
    axes.minorticks_off()
    axes.set_xlabel("$k_{con}$ / ticks, without noise")
    axes.set_ylabel("consistency with noise")
    axes.legend()
