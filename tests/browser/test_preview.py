"""A run that is not compiled yet, as a browser shows it, and how the compiled one takes over."""

from __future__ import annotations

from functools import partial

import pytest

from agents.motion.motion import Motion
from app.viewer.lab.laboratory import Laboratory
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from tests.browser.window import Window
from tests.viewer.stub_flock import StubCompiling
from tests.viewer.waiting import until

WHERE = """() => {
    const place = document.querySelector(".fs-compiling")?.getBoundingClientRect();
    return place?.width > 0 && place.toJSON();
}"""
"""Where the bar is, once it has a place: the page may just be drawing it anew."""


@pytest.fixture
def laboratory(monkeypatch):
    """A laboratory whose model is compiled when the test says so."""
    monkeypatch.setattr(Motion, "is_compiled", property(lambda flock: flock.interpret))
    monkeypatch.setattr(
        "app.viewer.lab.laboratory.Simulation", partial(Simulation, compiling=StubCompiling)
    )
    made = Laboratory(preset_spec("vem", agents=40, seed=3), port=0, speed=30.0)
    yield made
    made.close()


def test_a_preview_moves_and_says_so_and_nothing_jumps_when_it_is_taken_over(laboratory, chromium):
    page = chromium.new_page(viewport={"width": 1000, "height": 640})
    window = Window(page, laboratory)
    bar, pause = page.locator(".fs-compiling"), page.get_by_role("button", name="Pause")
    bar.wait_for()
    assert "Preview until compiled" in bar.inner_text()
    place = page.wait_for_function(WHERE).json_value()
    assert place["x"] > 310
    assert place["x"] + place["width"] < 1000 - 330
    assert 0 < place["y"] < 640 - place["height"]
    assert window.card("polarisation") == "–"
    tick, before = int(window.card("tick")), pause.bounding_box()
    until(lambda: int(window.card("tick")) > tick, 60)
    laboratory.simulation.compiling.ready.set_result(None)
    bar.wait_for(state="detached")
    assert pause.bounding_box() == before
    assert int(window.card("tick")) >= tick
    until(lambda: window.card("polarisation") != "–", 60)
    assert not laboratory.simulation.state.error
    page.close()
