"""Crashes, groups and energy as a browser shows them."""

from __future__ import annotations

from tests.browser.window import Window, is_compiled
from tests.viewer.waiting import COMPILED, until


def chosen(window: Window, number: int) -> str:
    """What a plot shows."""
    return window.page.get_by_role("combobox", name=f"Plot {number}").input_value()


def choose(window: Window, label: str, option: str) -> None:
    """Choose from a list."""
    window.page.get_by_role("combobox", name=label).click()
    window.page.get_by_role("option", name=option, exact=True).click()


def test_a_flock_that_can_crash_is_watched_and_another_is_not(window, laboratory, chromium):
    page, simulation = window.page, laboratory.simulation
    assert "Crashed" not in window.text()
    assert chosen(window, 1) == "polarisation, consistency"
    window.tab("Setup")
    choose(window, "Model", "Zones of the thesis")
    page.get_by_text("only looked at as the run starts").wait_for()
    until(lambda: page.get_by_label("Dimension", exact=True).input_value() == "3-D")
    window.press("Setup")
    until(lambda: simulation.state.spec.model == "thesis" and is_compiled(simulation), COMPILED)
    until(lambda: [chosen(window, n) for n in (1, 2, 3)] == ["groups", "polarisation", "crashes"])
    until(lambda: "Crashed 0 of 50" in window.text())
    assert window.card("drag saved") == "–"
    simulation.step(2).result(120)
    crashed = simulation.run.flock.crashes
    assert len(crashed) > 3
    page.get_by_text(f"of 50 ({len(crashed)} at the start)").wait_for()
    page.get_by_text("Latest crashes").wait_for()
    until(lambda: window.card("drag saved") != "–")

    newest = crashed.id[-1]
    page.get_by_role("button", name=str(newest), exact=True).click()
    until(lambda: laboratory.selected == crashed.row[-1])
    page.get_by_text(f"Agent {newest}").first.wait_for()

    page.get_by_text("More numbers").click()
    page.get_by_label("correlation length").check()
    page.get_by_label("binder").check()
    until(lambda: window.card("correlation length") not in ("", "–"), 60)
    choose(window, "Plot 3", "largest group")
    until(lambda: "largest-group" in laboratory.plots.names)

    other = Window(chromium.new_page(viewport={"width": 1100, "height": 600}), laboratory)
    assert other.page.get_by_role("combobox", name="Plot 3").input_value() == "largest group"
    choose(other, "Plot 3", "crashes")
    until(lambda: chosen(window, 3) == "crashes")
    other.page.close()

    window.tab("Rule")
    window.enter(laboratory.parameters.controls["d_r"], "4")
    page.get_by_text("d_r stops at 2.5").first.wait_for()
    until(lambda: window.number(laboratory.parameters.controls["d_r"]).input_value() == "2.5")
    assert simulation.run.flock.parameters.d_r == 2.5

    page.get_by_label("correlation length").uncheck()
    page.get_by_label("binder").uncheck()
    until(lambda: window.card("correlation length") == "")
    laboratory.select(None)
    window.tab("Setup")
    choose(window, "Model", "Hierarchical weighting Vicsek model")
    until(lambda: page.get_by_label("Dimension", exact=True).input_value() == "2-D")
    window.press("Setup")
    until(lambda: "Crashed" not in window.text(), 60)
    until(lambda: chosen(window, 1) == "polarisation, consistency")
    assert "Latest crashes" not in window.text()
    window.tab("Rule")
