"""Charts of runs: they show what the summary says, end where a quantity ends, and fit a page."""

from __future__ import annotations

import re
import threading
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib import rcParams
from matplotlib.figure import Figure

from app.figure import new_figure
from app.studies.charts.axis_limits import (
    column_bounds,
    measure_limits,
    parameter_bounds,
    parameter_limits,
)
from app.studies.charts.colour_table import CENSORED, COLOURS, FAILED
from app.studies.charts.mean_line import draw_lines, draw_mean_bars, draw_mean_line
from app.studies.charts.page_svg import ShapeLink, page_figure, page_svg
from app.studies.charts.run_group import CellRuns, values_of
from app.studies.charts.value_map import draw_map, place_cells
from app.studies.judge.judge import ranges_of
from app.studies.judge.statistics import summary
from app.studies.run_axes import AxisModels
from app.studies.sensitivity.sensitivity_api import index_limits
from app.studies.sensitivity.sensitivity_result import Index, Influence, Sensitivity
from app.viewer.lab.sweeps.stored_sweeps import DrawnSweep
from app.viewer.lab.sweeps.sweep_chart import picture

HOSTILE = "</text><script>alert(1)</script>\"'&$\\frac{\x07\ud800"
SKEWED = (0.1, 0.2, 0.2, 0.3, 0.9)


def cells(values=(0.0, 2.0, 4.0, 6.0), rows=()):
    """Runs over noise, and over speeds if there are rows of these; some of the second cell gave up,
    all of the third failed."""
    rng = np.random.default_rng(1)
    places = [{"eta": eta} | v0 for v0 in ([{"v0": row} for row in rows] or [{}]) for eta in values]
    found = []
    for number, axes in enumerate(places):
        runs = np.clip(rng.normal(1.0 - axes["eta"] / 7.0, 0.1, 6), 0.0, 1.0).tolist()
        failed = number == 2
        values, seeds = ([], []) if failed else (runs, list(range(6)))
        found.append(CellRuns(axes, number, values, seeds, int(number == 1), int(failed)))
    return found


def drawn_sweep(groups, name="sweep", column="polarisation", axis="eta"):
    axes = {axis: values_of(groups, axis)}
    if "v0" in groups[0].axes:
        axes["v0"] = values_of(groups, "v0")
    return DrawnSweep(
        name, AxisModels("vem"), axes, (column,), column, dict(enumerate(groups, 1)), 10
    )


def page_of(draw):
    with page_figure(300, 200) as figure:
        axes = figure.subplots()
        draw(axes)
        return page_svg(figure, "a label")


# The same numbers.


def test_a_line_shows_the_means_and_the_unlike_sides_of_their_intervals():
    found = summary(ranges_of(SKEWED))
    low, high = found.interval
    assert found.mean - low < high - found.mean, "the runs are to be skewed"
    axes = Figure().subplots()
    draw_mean_line(axes, [1.0, 2.0], [found, found])
    assert axes.lines[0].get_ydata().tolist() == [found.mean] * 2
    band = axes.collections[0].get_paths()[0].vertices
    assert (band[:, 1].min(), band[:, 1].max()) == (low, high)
    draw_mean_bars(axes, [3.0], [found])
    (bar,) = axes.containers[0][2][0].get_segments()
    assert bar[:, 1] == pytest.approx([low, high])


def test_a_bar_has_no_side_of_which_nothing_is_known():
    open_above = summary(ranges_of([1.0, 2.0, 3.0, None], limit=4.0))
    axes = Figure().subplots()
    draw_mean_bars(axes, [0.0, 1.0], [open_above, summary(ranges_of([2.0]))])
    drawn = [segment[:, 1] for segment in axes.containers[0][2][0].get_segments()]
    assert drawn[0] == pytest.approx([open_above.interval[0], open_above.mean])
    assert drawn[1] == pytest.approx([2.0, 2.0])


def test_a_map_shows_the_mean_of_the_summary_of_each_cell():
    groups = cells(rows=(0.1, 0.2))
    across, up = values_of(groups, "eta"), values_of(groups, "v0")
    axes = Figure().subplots()
    shown = draw_map(axes, place_cells(groups, across, up, "eta", "v0"), across, up)
    drawn = shown.get_array().reshape(2, 4)
    for group in groups:
        value = drawn[up.index(group.axes["v0"]), across.index(group.axes["eta"])]
        assert value is np.ma.masked if group.number == 2 else value == group.summary.mean


# Where axes end.


@pytest.mark.parametrize("column", ["polarisation", "consistency-over-50", "angular-momentum"])
def test_a_share_has_the_axis_from_0_to_1_whatever_was_found(column):
    bounds = column_bounds(column)
    for seen in ([], [0.4, 0.41], [0.0, 1.0]):
        assert measure_limits(seen, bounds, [-0.1, 1.2]) == (0.0, 1.0)
    assert measure_limits([0.5, 1.3], bounds)[1] >= 1.3, "a run is seen whatever it came to"


def test_what_cannot_be_below_zero_begins_there_and_what_is_unbounded_does_not():
    assert measure_limits([12.0, 19.0], column_bounds("k"), [-3.0]) == (0.0, 20.0)
    assert measure_limits([0.3, 0.6], column_bounds("binder"), [0.9])[1] == 2.0 / 3.0
    low, high = measure_limits([12.0, 19.0], column_bounds("my.measure"))
    assert 0.0 < low <= 12.0
    assert high >= 19.0


def test_the_axis_of_a_parameter_stays_within_what_it_can_be():
    noise = parameter_bounds("vem", "eta")
    assert parameter_limits([0.0, 2.0], noise)[0] == 0.0
    assert parameter_limits([0.0, noise.high], noise) == (0.0, noise.high)
    low, high = parameter_limits([1.0, 2.0], noise)
    assert 0.0 < low < 1.0
    assert 2.0 < high < noise.high
    low, high = parameter_limits([0.01, 0.1, 1.0, 6.2], noise, log=True)
    assert 0.0 < low < 0.01
    assert high == noise.high


def test_a_mean_is_bounded_as_its_parameter_and_a_spread_from_below():
    assert parameter_bounds("vem", "eta.mean") == parameter_bounds("vem", "eta")
    assert parameter_bounds("vem", "eta.spread") == parameter_bounds("vem", "agents")


def test_lines_of_an_order_parameter_over_noise_have_both_axes_bounded():
    axes = Figure().subplots()
    bounds = parameter_bounds("vem", "eta"), column_bounds("polarisation")
    draw_lines(axes, cells(), "eta", *bounds)
    assert axes.get_ylim() == (0.0, 1.0)
    assert axes.get_xlim()[0] == 0.0
    assert axes.get_xlim()[1] <= bounds[0].high


def test_shares_of_the_variance_go_from_0_to_1_and_estimates_beyond_are_seen():
    def limits(*values):
        influences = [Influence("eta", Index(v, 0.5), Index(v, 0.5)) for v in values]
        one = Sensitivity.__new__(Sensitivity)
        vars(one).update(kind="sobol", influences=influences)
        return index_limits(one)

    assert limits(0.2, 0.9) == (0.0, 1.0)
    low, high = limits(-0.05, 1.1)
    assert low <= -0.05
    assert high >= 1.1


# In a page.


@pytest.mark.parametrize("rows", [(), (0.1, 0.2)])
def test_a_picture_for_a_page_has_no_colour_but_those_of_values(rows):
    drawn = ElementTree.fromstring(f"<div>{picture(drawn_sweep(cells(rows=rows)))}</div>")
    svg = drawn.find("svg")
    assert "width" not in svg.attrib
    assert "height" not in svg.attrib
    for element in svg.iter():
        if element.get("class") != "fs-cell":
            fixed = [v for k, v in element.attrib.items() if k != "href"]
            assert not re.search(r"#[0-9a-f]{3,8}\b|rgb|black|white", " ".join(fixed))
        assert "font-family" not in element.get("style", "")
    assert svg.find(".//style") is None


def test_the_colours_of_all_lines_and_marks_are_the_themes():
    def draw(axes):
        for k, colour in enumerate((*COLOURS, CENSORED, FAILED)):
            axes.plot([0, 1], [k, k], color=colour)

    text = page_of(draw)
    assert not re.search("#[0-9a-f]{6}", text)
    page = (Path(__file__).parents[2] / "static" / "page.css").read_text()
    for name in set(re.findall(r"var\((--fs-[\w-]+)\)", text)):
        assert page.count(f"{name}:") == 2, f"{name} in a light and in a dark theme"


def test_ids_are_unique_in_a_page_of_several_pictures():
    first, second = (picture(drawn_sweep(cells(values))) for values in ((0, 1, 2, 3), (0, 2, 4, 6)))
    ids = Counter(re.findall(r'\bid="([^"]+)"', first + second))
    assert set(ids.values()) == {1}
    used = set(re.findall(r'(?:href="|url\()#([^")]+)', first + second))
    assert used == set(ids)


def test_a_cell_can_be_pressed_and_says_what_it_is():
    drawn = ElementTree.fromstring(f"<div>{picture(drawn_sweep(cells(), 'a sweep'))}</div>")
    buttons = drawn.findall(".//g[@role='button']")
    assert [one.get("data-cell") for one in buttons] == ["1", "2", "3", "4"]
    assert {one.get("data-sweep") for one in buttons} == {"a sweep"}
    assert {one.get("tabindex") for one in buttons} == {"0"}
    titles = [one.findtext("title") for one in buttons]
    mean = cells()[0].summary.mean
    assert titles[0].startswith(f"eta = 0: {mean:.3g} ± ")
    assert "; 1 gave up" in titles[1]
    assert titles[2] == "eta = 4: ; 1 failed. Click: open the run"


@pytest.mark.filterwarnings("ignore:Glyph")
@pytest.mark.parametrize("words", [("ring", HOSTILE), (0.5, 1.5)])
def test_names_of_users_are_text_whatever_they_are(words):
    groups = [CellRuns({HOSTILE: v}, k, [0.5, 0.6], [1, 2]) for k, v in enumerate(words)]
    text = picture(drawn_sweep(groups, HOSTILE, f"m.py:{HOSTILE}", HOSTILE))
    assert "<script" not in text
    drawn = ElementTree.fromstring(f"<div>{text}</div>")
    assert not drawn.findall(".//script")
    assert HOSTILE[:20] in "".join(drawn.itertext())
    name = drawn.find(".//g[@role='button']").get("data-sweep")
    assert name == HOSTILE.replace("\x07", "\ufffd").replace("\ud800", "\ufffd")


def test_links_are_of_as_many_shapes_as_there_are():
    with page_figure(300, 200) as figure:
        figure.subplots().scatter([0, 1], [0, 1], gid="fs-target")
        with pytest.raises(ValueError, match="1 links for 2 shapes of fs-target"):
            page_svg(figure, "", {"fs-target": [ShapeLink("one")]})
        text = page_svg(figure, "", {"fs-target": [ShapeLink("one", {"of": 1}), None]})
    assert text.count("<title>") == 1
    assert 'data-of="1"' in text


def test_one_thread_draws_at_a_time_and_leaves_the_settings_as_they_were():
    before, inside, seen = rcParams["font.size"], threading.Event(), []

    def draw():
        with new_figure({"font.size": 31}):
            seen.append(rcParams["font.size"])

    with new_figure({"font.size": 17}):
        other = threading.Thread(target=lambda: (inside.set(), draw()))
        other.start()
        assert inside.wait(10)
        other.join(0.2)
        assert other.is_alive()
        assert not seen
        assert rcParams["font.size"] == 17
    other.join(10)
    assert seen == [31]
    assert rcParams["font.size"] == before
