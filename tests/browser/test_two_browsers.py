"""Two full browsers at one laboratory that want different things: both see what has come of it."""

from __future__ import annotations

import pytest

from tests.browser.window import Window, is_compiled
from tests.viewer.waiting import COMPILED, until


@pytest.fixture
def windows(window, laboratory, chromium):
    """Two windows on the same laboratory."""
    page = chromium.new_page(viewport={"width": 1000, "height": 640})
    yield window, Window(page, laboratory)
    page.close()


@pytest.fixture
def sweeps(laboratory, tmp_path):
    """The laboratory's sweeps, in an empty folder."""
    before, laboratory.sweeps.results = laboratory.sweeps.results, tmp_path
    yield laboratory.sweeps
    if laboratory.sweeps.making is not None:
        laboratory.sweeps.making.process.kill()
    laboratory.sweeps.results = before


def test_a_slider_that_two_turn_ends_at_one_value_that_both_see(laboratory, windows):
    for window in windows:
        window.tab("Rule")
    control = laboratory.parameters.controls["eta"]

    def all_have(*values: float) -> bool:
        """Whether both windows, and the flock, have one of these."""
        seen = {float(window.number(control).input_value()) for window in windows}
        return len(seen) == 1 and seen <= set(values) and flock() in seen

    def flock() -> float:
        return laboratory.simulation.state.values["eta"]

    for window, value in zip((*windows, *windows), (0.5, 2.5, 3.0, 1.0), strict=True):
        window.enter(control, str(value))
        until(lambda value=value: all_have(value), what=f"{value} in both windows")
    for pair in ((0.5, 2.5), (3.0, 1.5)):  # at once: one of them is the last
        for window, value in zip(windows, pair, strict=True):
            window.enter(control, str(value))
        until(lambda pair=pair: all_have(*pair), what=f"one of {pair} in both windows")


@pytest.mark.usefixtures("sweeps")
def test_a_sweep_goes_on_while_another_browser_sets_up_another_model(laboratory, windows, sweeps):
    first, second = windows
    form, simulation = laboratory.sweep, laboratory.simulation
    first.tab("Sweep")
    for control, value in ((form.first.count, "3"), (form.runs, "2"), (form.ticks, "400")):
        first.page.locator(f'[id="{control._impl.uuid}"]').fill(value)
        until(lambda control=control, value=value: control.value == int(value))
    first.press("Start the sweep")
    until(lambda: sweeps.making is not None, what="a sweep")
    first.page.reload()
    laboratory.setup.model.value = "Vicsek model"
    second.press("Setup")
    until(lambda: simulation.state.spec.model == "vem" and is_compiled(simulation), COMPILED)
    again = Window(first.page, laboratory)
    for window in (again, second):
        window.tab("Sweep")
        window.page.get_by_text("6 of 6 runs").wait_for()
        assert window.page.locator(".fs-figure [data-cell]").count() == 3
    first.page.locator(".fs-figure [data-cell]").nth(1).click()
    first.page.get_by_role("button", name="Open it for all").click()
    until(lambda: simulation.state.spec.model == "hwvem", COMPILED)
