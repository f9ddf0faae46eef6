"""The tab Sweep: begun at a slider, it fills in, a click opens a run, a reload finds it."""

from __future__ import annotations

import pytest

from agents.spec import Spec
from tests.browser.accessibility import find_violations
from tests.browser.window import Window
from tests.viewer.waiting import until


@pytest.fixture
def sweeps(laboratory, tmp_path):
    """The laboratory's sweeps, in an empty folder."""
    before, laboratory.sweeps.results = laboratory.sweeps.results, tmp_path
    yield
    if laboratory.sweeps.making is not None:
        laboratory.sweeps.making.process.kill()
    laboratory.sweeps.results = before


@pytest.mark.usefixtures("sweeps")
def test_a_curve_fills_in_opens_a_run_and_is_there_after_a_reload(laboratory, window):
    page, form = window.page, laboratory.sweep
    window.tab("Rule")
    slider = page.locator(f'[data-of="{laboratory.parameters.controls["eta"]._impl.uuid}"]')
    slider.first.hover()
    page.get_by_role("button", name="Sweep Noise").click()
    page.get_by_role("tab", name="Sweep", exact=True, selected=True).wait_for()
    assert form.first.axis().name == "eta"
    for control, value in ((form.first.count, "3"), (form.runs, "2"), (form.ticks, "40")):
        page.locator(f'[id="{control._impl.uuid}"]').fill(value)
        until(lambda control=control, value=value: control.value == int(value))
    page.get_by_text("6 runs", exact=True).wait_for()
    window.press("Start the sweep")
    points = page.locator(".fs-figure [data-cell]")
    until(lambda: points.count() == 3, 90, "a point for each value")
    page.get_by_text("6 of 6 runs").wait_for(timeout=30_000)
    assert page.locator(".fs-figure .fs-run").count() == 6
    page.mouse.move(640, 60)
    until(lambda: page.get_by_role("tooltip").count() == 0)  # one that fades away is faint
    assert find_violations(page) == []

    spec = laboratory.simulation.state.spec
    points.nth(1).click()
    until(lambda: laboratory.simulation.state.spec != spec)
    opened: Spec = laboratory.simulation.state.spec
    assert opened.parameters["eta"] == 3.1, "round to two figures of their distance"
    assert opened.seed in (1, 2)
    page.get_by_text("came to").first.wait_for()

    page.reload()
    again = Window(page, laboratory)
    again.tab("Sweep")
    until(lambda: page.locator(".fs-figure [data-cell]").count() == 3)
    assert "6 of 6 runs" in again.text()
