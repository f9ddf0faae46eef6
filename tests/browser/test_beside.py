"""Two models side by side as a browser shows them."""

from __future__ import annotations

import io
import zipfile

import numpy as np

from tests.browser.window import is_compiled, on_page
from tests.viewer.waiting import COMPILED, until


def column(window, name: str) -> list[str]:
    """What the table of both flocks says in a row."""
    return window.page.evaluate(
        """name => [...document.querySelectorAll('.fs-pair tr')]
        .filter(row => row.cells[0].textContent === name)
        .flatMap(row => [...row.cells].slice(1).map(cell => cell.textContent))""",
        name,
    )


def halves(window) -> list[float]:
    """Share of saturated pixels in the upper and in the lower half of the picture, which is higher
    than wide."""
    picture = window.pixels()
    vivid = picture.max(axis=2) - picture.min(axis=2) > 60
    middle = vivid.shape[0] // 2
    return [float(np.mean(half)) for half in (vivid[:middle], vivid[middle:])]


def test_a_second_model_flies_beside_the_first_until_it_is_taken_away(window, laboratory, tmp_path):
    page, simulation = window.page, laboratory.simulation
    window.tab("Setup")
    page.get_by_label("Beside", exact=True).click()
    page.get_by_role("option", name="Improved Vicsek model", exact=True).click()
    page.get_by_text("Changed: beside").wait_for()
    window.press("Setup")
    until(lambda: simulation.state.models[1] == "ivem", 60)
    until(lambda: is_compiled(simulation), COMPILED)
    until(lambda: laboratory.scene._sights[1:], 60)
    titles = page.locator(".fs-pair-titles")
    titles.wait_for(timeout=20_000)
    assert "Improved Vicsek model" in titles.inner_text()
    until(lambda: min(halves(window)) > 0.002, 20, "a flock in each half")
    assert column(window, "polarisation")[0] == column(window, "polarisation")[1]

    window.tab("Rule")
    page.get_by_text("These act on both models").wait_for()
    window.enter(laboratory.parameters.controls["eta"], "1.5")
    until(lambda: [one.values["eta"] for one in simulation.run.both] == [1.5, 1.5])
    for _ in range(4):
        window.press("Step")
    until(lambda: window.card("tick") == "4", 90, "the fourth tick of both")
    until(lambda: len(set(column(window, "polarisation"))) == 2)

    page.wait_for_timeout(1000)
    page.mouse.click(*on_page(window, laboratory, 1, 30))
    until(lambda: laboratory.selected_beside, 10, "a click on an agent of the second flock")
    page.get_by_text("Listens to").wait_for(timeout=60_000)
    assert simulation.frame.inspected is None
    page.wait_for_timeout(500)
    in_sight = "([x, y]) => document.elementFromPoint(x, y).matches('canvas')"
    places = [on_page(window, laboratory, 0, row) for row in range(len(simulation.frame.ids))]
    clear = next(place for place in places if page.evaluate(in_sight, list(place)))
    page.mouse.click(*clear)
    until(lambda: laboratory.selected is not None and not laboratory.selected_beside)
    window.press("Close")

    window.tab("Save")
    with page.expect_download() as download:
        window.press("Download spec (TOML)")
    file = tmp_path / download.value.suggested_filename
    download.value.save_as(file)
    assert file.name.startswith("hwvem-beside-ivem-seed")
    with zipfile.ZipFile(io.BytesIO(file.read_bytes())) as pack:
        assert pack.namelist() == ["1-hwvem.toml", "2-ivem.toml"]

    window.tab("Setup")
    page.get_by_label("Beside", exact=True).click()
    page.get_by_role("option", name="none", exact=True).click()
    window.press("Setup")
    until(lambda: simulation.state.models[1] is None, 60)
    until(lambda: is_compiled(simulation), COMPILED)
    until(lambda: window.card("groups") != "", 20, "cards again")
    assert column(window, "polarisation") == []
    until(lambda: len(laboratory.scene._sights) == 1)
    window.tab("Rule")
