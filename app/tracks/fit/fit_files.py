"""What a fit leaves in a folder: numbers as JSON and CSV, the costs as pictures."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from app.figure import NAMED, new_figure, write_figure
from app.results_folder import make_folder, picture_files
from app.studies.charts.colour_table import COLOURS, EMPTY, PALE, RULER
from app.studies.charts.value_map import COLOUR_MAP, name_ticks
from app.tracks.fit.approximate_bayes import AbcFit, AbcResult
from app.tracks.fit.fit_api import AnyResult
from app.tracks.fit.fit_result import FitResult, ModelFit
from app.tracks.fit.vicsek_likelihood import LikelihoodFit
from worlds.file_writer import csv_text, write_text

NUMBERS, TABLE = "fit.json", "costs.csv"


def write_fit(result: AnyResult, folder: Path) -> list[Path]:
    """Write numbers and pictures of a fit; the files. Files of their names are replaced.

    Raises InputError.
    """
    make_folder(folder)
    values = finite_values(result.to_dict())
    write_text("fit", folder / NUMBERS, json.dumps(values, indent=1, allow_nan=False) + "\n")
    write_text("costs", folder / TABLE, csv_text(*cost_table(result)))
    files = [folder / NUMBERS, folder / TABLE]
    for fit in result.fits:
        for name in picture_files(f"fit-{fit.model}"):
            draw_fit(fit, result.tracks, folder / name)
            files.append(folder / name)
    return files


def finite_values(value: Any) -> Any:
    """Values as JSON has them: what is not finite is null, NumPy's numbers are numbers."""
    if isinstance(value, dict):
        return {str(key): finite_values(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite_values(item) for item in value]
    if isinstance(value, np.ndarray | np.generic):
        return finite_values(value.tolist())
    return None if isinstance(value, float) and not np.isfinite(value) else value


def cost_table(result: AnyResult) -> tuple[list[str], Iterator[list[Any]]]:
    """Names of columns and rows: a row for each cell of each model, or each draw."""
    names = list(dict.fromkeys(name for fit in result.fits for name in fitted_names(fit)))
    columns = {
        FitResult: ["cost", "cost_second_window", "in_region", "in_region_second_window"],
        AbcResult: [f"summary_{k}" for k in range(1, 12)],
    }.get(type(result), ["variance"])

    def rows() -> Iterator[list[Any]]:
        for fit in result.fits:
            own = fitted_names(fit)
            points = fit.draws if isinstance(fit, AbcFit) else fit.points
            if isinstance(fit, ModelFit):
                first, second = fit.first, fit.second
                values: Any = zip(
                    first.costs.tolist(), second.costs.tolist(),
                    first.in_region.tolist(), second.in_region.tolist(), strict=True,
                )  # fmt: skip
            else:
                values = fit.summaries if isinstance(fit, AbcFit) else fit.variances[:, None]
                values = values.tolist()
            for point, more in zip(points.tolist(), values, strict=True):
                place = dict(zip(own, point, strict=True))
                yield [fit.model, *(place.get(name) for name in names), *more]

    return ["model", *names, *columns], rows()


def fitted_names(fit: ModelFit | LikelihoodFit | AbcFit) -> list[str]:
    """The names of the parameters in question."""
    return [one.name for one in (fit.posteriors if isinstance(fit, AbcFit) else fit.parameters)]


def draw_fit(fit: ModelFit | LikelihoodFit | AbcFit, tracks: str, path: Path) -> None:
    """Draw the costs of a model over its parameters: PNG, SVG or PDF. Raises InputError."""
    with new_figure(NAMED) as figure:
        if isinstance(fit, AbcFit):
            draw_posteriors(figure, fit)
        elif isinstance(fit, ModelFit) and len(fit.parameters) == 2:
            draw_surfaces(figure, fit)
        else:
            draw_profiles(figure, fit)
        first = fit.sentences()[0]
        figure.suptitle(f"{fit.model} fitted to {tracks}\n{first}", x=0.01, ha="left", wrap=True)
        write_figure(figure, path)


def draw_surfaces(figure: Any, fit: ModelFit) -> None:
    """Draw the costs of two parameters as a map for each window, best and region marked."""
    figure.set_size_inches(10.4, 5.0)
    first, second = fit.parameters
    shape = len(first.values), len(second.values)
    for axes, window in zip(figure.subplots(1, 2), (fit.first, fit.second), strict=True):
        ratio = (window.costs / window.null_cost).reshape(shape)
        mesh = axes.pcolormesh(
            np.ma.masked_invalid(ratio.T), cmap=COLOUR_MAP, edgecolors="face", linewidth=0.4,
            gid="fs-cell",
        )  # fmt: skip
        axes.set_facecolor(EMPTY)
        axes.grid(False)
        inside = window.in_region.reshape(shape)
        at = np.argwhere(inside) + 0.5
        axes.plot(at[:, 0], at[:, 1], "s", markersize=4, color="white", markeredgecolor="black",
                  markeredgewidth=0.4, label="like the best")  # fmt: skip
        best = np.array(np.unravel_index(window.best, shape)) + 0.5
        axes.plot(*best, "o", markersize=10, markerfacecolor="none", markeredgecolor=COLOURS[1],
                  markeredgewidth=2.0, label="best")  # fmt: skip
        name_ticks(axes.set_xticks, first.values)
        name_ticks(axes.set_yticks, second.values)
        axes.set_xlabel(axis_label(first.name, first.unit))
        axes.set_ylabel(axis_label(second.name, second.unit))
        axes.set_title(f"window {window.window:.3g} s")
        axes.legend(loc="upper right", fontsize=8, frameon=True)
        figure.colorbar(mesh, ax=axes, label="cost / cost of keeping the heading")


def draw_profiles(figure: Any, fit: ModelFit | LikelihoodFit) -> None:
    """Draw the least cost at each value of each parameter, the region and the null."""
    columns = max(1, len(fit.parameters))
    figure.set_size_inches(max(6.4, 4.2 * columns), 4.4)
    panels = figure.subplots(1, columns, squeeze=False)[0]
    if isinstance(fit, ModelFit):
        curves = [
            (fit.first.costs, f"window {fit.first.window:.3g} s", COLOURS[0]),
            (fit.second.costs, f"window {fit.second.window:.3g} s", PALE),
        ]
        null, regions, label = fit.first.null_cost, fit.first.regions, "cost, rad²"
    else:
        curves = [(fit.variances, "residuals", COLOURS[0])]
        null, regions, label = fit.null_cost, fit.regions, "mean square of residuals, rad²"
    for column, (axes, region) in enumerate(zip(panels, regions, strict=False)):
        axes.axvspan(region.low, region.high, color=PALE, alpha=0.35, label="region")
        for costs, words, colour in curves:
            values = np.unique(fit.points[:, column])
            least = [np.nanmin(costs[fit.points[:, column] == value]) for value in values]
            axes.plot(values, least, "o-", markersize=3, color=colour, label=words)
        axes.axhline(null, color=RULER, linestyle=(0, (4, 3)), label="keeps its heading")
        axes.axvline(region.best, color=COLOURS[1], linewidth=1.0, label="best")
        axes.set_xlabel(axis_label(region.name, region.unit))
        axes.set_ylabel(label)
    if not fit.parameters and isinstance(fit, ModelFit):
        panels[0].bar(
            ["keeps its heading", fit.model], [fit.null_cost, fit.cost], color=(RULER, COLOURS[0])
        )
        panels[0].set_ylabel(label)
    else:
        panels[0].legend(fontsize=8)


def draw_posteriors(figure: Any, fit: AbcFit) -> None:
    """Draw what is left of the range of each parameter."""
    columns = len(fit.posteriors)
    figure.set_size_inches(max(6.4, 4.2 * columns), 4.2)
    for column, (axes, posterior) in enumerate(
        zip(figure.subplots(1, columns, squeeze=False)[0], fit.posteriors, strict=True)
    ):
        drawn = fit.draws[:, column]
        edges = np.linspace(drawn.min(), drawn.max(), 31)
        share = np.histogram(fit.kept[:, column], edges, weights=fit.weights)[0]
        if share.sum() > 0.0:  # else all that is kept was brought beyond what was drawn
            axes.stairs(share / share.sum(), edges, fill=True, color=PALE)
        axes.axvspan(posterior.low, posterior.high, color=COLOURS[0], alpha=0.12, label="90 %")
        axes.axvline(posterior.median, color=COLOURS[1], label="median")
        axes.set_xlabel(axis_label(posterior.name, posterior.unit))
        axes.set_ylabel("share of the draws kept")
        axes.legend(fontsize=8)


def axis_label(name: str, unit: str) -> str:
    """A parameter with its unit."""
    return name if unit == "1" else f"{name} ({unit})"


def format_table(result: AnyResult) -> list[list[str]]:
    """The rules on the frames held back, or the parameters of ABC, as rows of texts; head first."""
    if isinstance(result, AbcResult):
        rows = [["model", "parameter", "median", "90 %", "held the truth"]]
        return rows + [
            [
                fit.model, posterior.name, f"{posterior.median:.4g}",
                f"{posterior.low:.4g} to {posterior.high:.4g}", f"{100 * posterior.coverage:.0f} %",
            ]
            if fit.is_like_tracks
            else [fit.model, posterior.name, "not told", "", ""]
            for fit in result.fits
            for posterior in fit.posteriors
        ]  # fmt: skip
    rows = [["rule", "cost held back", "explains", "shuffled", "best"]]
    for row in result.table():
        shuffled = "" if row["shuffled"] is None else f"{100 * row['shuffled']:.1f} %"
        share = "" if row["explains"] is None else f"{100 * row['skill']:.1f} %"
        share += " (nothing)" if row["explains"] is False else ""
        rows.append([row["rule"], f"{row['cost']:.4g}", share, shuffled, row["parameters"]])
    return rows
