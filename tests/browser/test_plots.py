"""The plots as a browser shows them: values under the mouse, large, and taken along."""

from __future__ import annotations

import io

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


def test_a_plot_whose_axis_follows_its_values_shows_its_curve(measured, laboratory):
    """One without marks, and beside a curve without values: the axis has ends nevertheless."""
    plot = measured.page.locator(".u-wrap").nth(1)
    plot.scroll_into_view_if_needed()
    until(lambda: drawn(plot, COLOURS[0]) > 60)
    chart = laboratory.plots.charts[1].plot.chart
    values = np.linspace(2.0, 7.0, 50)
    curves = (
        ChartCurve(COLOURS[0], values, "some"),
        ChartCurve(COLOURS[1], np.full(50, np.nan), "none"),
    )
    chart.show(
        ChartContents("", np.arange(50.0), curves, ("tick", "both"), uplot.Scale(range=(0.0, None)))
    )
    until(lambda: drawn(plot, COLOURS[0]) > 60)
    assert drawn(plot, COLOURS[1]) == 0
