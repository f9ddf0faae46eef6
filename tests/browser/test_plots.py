"""The plots as a browser shows them: values under the mouse, large, and taken along."""

from __future__ import annotations

import io
from unittest.mock import Mock

import numpy as np
import pandas as pd
import pytest
from PIL import Image
from viser import uplot

from app.viewer.lab.panels.laboratory_plots import COLOURS
from app.viewer.panels.chart import ChartContents, ChartCurve
from tests.viewer.waiting import until

LARGE = ".mantine-Modal-content"
EDGE = {"x": 5, "y": 300}
"""Beside what is shown large, in the window."""


def newest(chart) -> float:
    """The last tick of the run that goes on, whose curve is the last one."""
    at, *_, values = chart.plot.data
    return at[np.isfinite(values)][-1]


@pytest.fixture
def measured(window, laboratory):
    """The window, with a flock that has run for some ticks, and no run before it."""
    for run in laboratory.plots.runs.rows:
        laboratory.plots.runs.delete(run.number)
    laboratory.simulation.go()
    until(lambda: laboratory.simulation.frame.tick > 60)
    laboratory.simulation.pause()
    until(lambda: window.card("tick") == str(laboratory.simulation.frame.tick))
    chart = laboratory.plots.charts[0].plot.chart
    until(lambda: newest(chart) == laboratory.simulation.frame.tick)
    return window


def test_the_values_under_the_mouse_are_told_and_nothing_moves(measured):
    page = measured.page
    plot, told = page.locator(".u-over").first, page.locator(".u-legend").first
    plot.scroll_into_view_if_needed()
    before = plot.bounding_box()
    assert before["height"] > 100
    assert not told.is_visible()
    plot.hover(position={"x": 120, "y": 40})
    told.wait_for()
    until(lambda: "polarisation" in told.inner_text())
    shown = told.locator(".u-series:not(.fs-mark) .u-value")
    tick, value, *_ = [float(one) for one in shown.all_inner_texts()]
    assert 0 < tick < 100
    assert 0.0 <= value <= 1.0
    assert len(str(value)) > 5
    assert plot.bounding_box() == before
    page.mouse.move(500, 300)
    until(lambda: not told.is_visible())


def test_a_plot_is_shown_large_and_goes_on_until_it_is_closed(measured, laboratory):
    page, simulation = measured.page, laboratory.simulation
    page.locator(".u-over").first.click(position={"x": 120, "y": 40})
    large = page.locator(f"{LARGE} .u-over")
    large.wait_for()
    until(lambda: large.bounding_box()["height"] > 300)
    chart = next(iter(laboratory.plots.charts[0].plot.sheets.open.values()))
    tick = simulation.frame.tick
    page.keyboard.press("t")
    until(lambda: newest(chart) == tick + 1)
    page.keyboard.press("Escape")
    until(lambda: large.count() == 0)
    assert not laboratory.plots.charts[0].plot.sheets.open
    tick = simulation.frame.tick
    page.keyboard.press("t")
    until(lambda: simulation.frame.tick == tick + 1)
    measured.press("Table")
    page.locator(f"{LARGE} .fs-numbers").wait_for()
    assert "polarisation" in page.locator(".fs-numbers").inner_text()
    page.mouse.click(*EDGE.values())
    until(lambda: page.locator(LARGE).count() == 0)


def test_a_plot_and_the_numbers_are_taken_along(measured, laboratory):
    page = measured.page
    with page.expect_download() as download:
        measured.press("CSV")
    name = download.value.suggested_filename
    assert name.startswith("hwvem-seed3-tick")
    table = pd.read_csv(download.value.path()).query("run == 'now'")
    series = laboratory.simulation.readings.series("polarisation").recorded()
    assert table.tick.tolist() == series[0].tolist()
    assert table.polarisation.dropna().tolist() == series[1].tolist()
    with page.expect_download() as download:
        measured.press("PNG")
    picture = Image.open(io.BytesIO(download.value.path().read_bytes()))
    assert picture.size == (1280, 800)
    with page.expect_download() as download:
        page.get_by_role("button", name="CSV", exact=True).last.click()
    numbers = pd.read_csv(download.value.path(), index_col="name")
    assert numbers.value["polarisation"] == laboratory.simulation.readings.values["polarisation"]


def drawn(plot, colour: str) -> int:
    """Pixels of a colour in a plot, as the browser shows it."""
    picture = plot.page.screenshot(clip=plot.bounding_box())  # the page may make it anew meanwhile
    shown = np.array(Image.open(io.BytesIO(picture)).convert("RGB"), int)
    wanted = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
    return int((np.abs(shown - wanted).max(axis=-1) < 40).sum())


FIND = "([name, act]) => Object.values(window.__viserTestpoints.uplots)\
.map(({ chart }) => chart).filter((chart) => chart.series[1]?.label === name).map(eval(act))[0]"
"""Does something with the chart whose first curve has a name, as viser's own tests find it."""


@pytest.fixture
def chart(measured, laboratory, monkeypatch):
    """The second chart of the page, which nothing but the test draws."""
    plot = laboratory.plots.charts[1].plot
    chart = plot.chart
    monkeypatch.setattr(plot, "chart", Mock())
    measured.page.locator(".u-wrap").nth(1).scroll_into_view_if_needed()
    return chart


def show(chart, name: str, first: float, last: float, more: tuple[ChartCurve, ...] = ()) -> None:
    """Draw a curve from 2 to 7 that has a value every tick; its axis follows its values."""
    at = np.arange(first, last + 1.0)
    curves = (ChartCurve(COLOURS[0], np.linspace(2.0, 7.0, len(at)), name), *more)
    scale = uplot.Scale(range=(0.0, None))
    chart.show(ChartContents("", at, curves, ("tick", "both"), scale))


def shown_times(page, name: str) -> tuple[float, ...] | None:
    """The ends of the axis of times of the chart with that curve; None while there is none."""
    ends = page.evaluate(FIND, [name, "({ scales }) => [scales.x.min, scales.x.max]"])
    return ends and tuple(ends)


def test_a_plot_whose_axis_follows_its_values_shows_its_curve(measured):
    """One without marks."""
    plot = measured.page.locator(".u-wrap").nth(1)
    plot.scroll_into_view_if_needed()
    until(lambda: drawn(plot, COLOURS[0]) > 60)


@pytest.mark.parametrize("values", [[np.nan] * 50, [np.nan, *[3.0] * 49]], ids=["none", "late"])
def test_a_curve_that_begins_without_a_value_leaves_the_axis_its_ends(measured, chart, values):
    show(chart, "some", 0, 49, (ChartCurve(COLOURS[1], np.array(values), "other"),))
    plot = measured.page.locator(".u-wrap").nth(1)
    until(lambda: shown_times(measured.page, "some") == (0, 49))
    until(lambda: drawn(plot, COLOURS[0]) > 60)
    assert (drawn(plot, COLOURS[1]) > 60) == np.isfinite(values).any()


def test_a_plot_shows_all_its_times_however_often_it_is_made_anew(measured, chart):
    """Each name makes it anew, with other ends; each twice as the page gets what comes at once."""
    for turn in range(6):
        show(chart, f"first {turn}", 0, 49 + turn)
        show(chart, f"other {turn}", 100 * turn + 100, 100 * turn + 249)
        ends = 100 * turn + 100, 100 * turn + 249
        until(lambda name=f"other {turn}", ends=ends: shown_times(measured.page, name) == ends)


def test_a_plot_that_has_lost_the_ends_of_its_times_has_them_again(measured, chart):
    """As happens where its first data come before it was drawn once, on a page that is busy."""
    show(chart, "some", 0, 49)
    until(lambda: shown_times(measured.page, "some") == (0, 49))
    lose = "(chart) => { chart.scales.x.min = chart.scales.x.max = null; chart.redraw(); }"
    measured.page.evaluate(FIND, ["some", lose])
    until(lambda: shown_times(measured.page, "some") == (0, 49))


def test_who_has_zoomed_in_goes_on_to_see_that_share_until_a_double_click(measured, chart):
    page = measured.page
    show(chart, "some", 0, 100)
    until(lambda: shown_times(page, "some") == (0, 100))
    box = page.locator(".u-over").nth(1).bounding_box()
    page.mouse.move(box["x"] + box["width"] / 4, box["y"] + 40)
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + 60, steps=4)
    page.mouse.up()
    near = pytest.approx((25, 50), abs=2)
    until(lambda: shown_times(page, "some") == near)
    show(chart, "some", 0, 200)
    twice = pytest.approx((50, 100), abs=4)
    until(lambda: shown_times(page, "some") == twice)
    show(chart, "anew", 0, 100)
    until(lambda: shown_times(page, "anew") == near)
    page.mouse.dblclick(box["x"] + box["width"] / 2, box["y"] + 40)
    until(lambda: shown_times(page, "anew") == (0, 100))
    show(chart, "anew", 0, 300)
    until(lambda: shown_times(page, "anew") == (0, 300))
