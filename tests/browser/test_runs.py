"""The tab Runs: a run that is over is a row, ticked, named, opened again, deleted, taken along."""

from __future__ import annotations

import re

import pytest

from tests.browser.accessibility import find_violations
from tests.browser.window import Window
from tests.viewer.waiting import until


@pytest.fixture
def rows(laboratory, window):
    """The rows of the laboratory, with none of an earlier test; their tab is open."""
    for run in laboratory.plots.runs.rows:
        laboratory.plots.runs.delete(run.number)
    window.tab("Runs")
    yield lambda: laboratory.plots.runs.rows
    window.tab("Monitors")


def finish(laboratory, ticks: int) -> None:
    """Run a while, and set up another seed: the run before is over."""
    simulation = laboratory.simulation
    begun = simulation.state.run
    simulation.step(ticks)
    until(lambda: laboratory.drawing.drawn[0].tick == ticks)
    simulation.setup(simulation.state.spec.with_values(seed=simulation.state.spec.seed + 1))
    until(lambda: simulation.state.run > begun and not simulation.state.busy)


def test_a_run_is_ticked_named_opened_again_and_deleted(laboratory, window, rows):
    page, runs = window.page, laboratory.plots.runs
    for ticks in (20, 30):
        before = len(rows())
        finish(laboratory, ticks)
        until(lambda before=before: len(rows()) == before + 1)
    last, first = rows()
    assert (first.ticks, last.ticks) == (20, 30)
    box = page.get_by_role("checkbox", name=f"Lay run {first.number} under the plots")
    box.wait_for()
    assert box.get_attribute("aria-checked") == "false"
    box.click()
    until(lambda: runs.find(first.number).is_shown)
    page.get_by_role("checkbox", name=box.get_attribute("aria-label"), checked=True).wait_for()

    page.get_by_role("button", name=f"Name run {first.number}", exact=True).click()
    page.get_by_label("Name", exact=True).fill("<b>first</b>")
    page.keyboard.press("Enter")
    until(lambda: runs.find(first.number).name == "<b>first</b>")
    page.locator(".fs-kept").get_by_text("<b>first</b>").wait_for()
    assert find_violations(page) == []

    page.reload()
    again = Window(page, laboratory)
    again.tab("Runs")
    page.get_by_role("button", name=re.compile(f"^Open run {first.number},")).click()
    until(lambda: laboratory.simulation.state.spec.seed == first.course.conditions.seed)

    page.get_by_role("button", name=re.compile(f"^Delete run {last.number}")).click()
    page.get_by_role("button", name="Delete it").click()
    until(lambda: last.number not in [run.number for run in rows()])


def test_keys_on_a_row_are_not_the_flocks(laboratory, window, rows):
    page, simulation = window.page, laboratory.simulation
    finish(laboratory, 10)
    until(lambda: rows())
    number = rows()[0].number
    box = page.get_by_role("checkbox", name=f"Lay run {number} under the plots")
    box.focus()
    page.keyboard.press("Space")
    until(lambda: not laboratory.plots.runs.find(number).is_shown)
    assert not simulation.state.running


def test_all_runs_are_taken_along(laboratory, window, rows):
    page = window.page
    finish(laboratory, 10)
    until(lambda: rows())
    for kind, begins in (
        ("CSV", b"run,name,model"),
        ("Parquet", b"PAR1"),
        ("JSONL", b'{"flockscope"'),
    ):
        with page.expect_download() as waiting:
            page.get_by_role("button", name=kind, exact=True).click()
        with open(waiting.value.path(), "rb") as file:
            assert file.read().startswith(begins)
    page.get_by_role("button", name="Table", exact=True).click()
    page.get_by_role("dialog").get_by_role("cell", name="vem").first.wait_for()
    page.keyboard.press("Escape")
