"""The time line under somebody's mouse, and a recording that is opened from the page."""

from __future__ import annotations

import numpy as np

from agents.flock import Flock
from agents.recordings.recorder import Recorder
from tests.viewer.waiting import until


def drag(window, slider, share: float) -> None:
    """Drag a slider's thumb to a share of its way, as a hand does."""
    track = window.page.locator(f'[id="{slider._impl.uuid}"]')
    thumb = track.get_by_role("slider").bounding_box()
    way, mouse = track.bounding_box(), window.page.mouse
    at = way["y"] + 0.5 * way["height"]
    mouse.move(thumb["x"] + 0.5 * thumb["width"], thumb["y"] + 0.5 * thumb["height"])
    mouse.down()
    for step in (0.9, 0.5, 0.0):
        mouse.move(way["x"] + way["width"] * (share + 0.1 * step), at)
    mouse.up()


def test_a_live_run_is_dragged_back_and_forth_and_gone_on_from(window, laboratory):
    simulation, line = laboratory.simulation, laboratory.time_line
    window.press("Go")
    until(lambda: simulation.frame.tick > 60, 60)
    window.press("Pause")
    until(lambda: not simulation.state.running and simulation.state.rate == 0.0)  # the last frame
    until(lambda: line.slider.value == simulation.frame.tick)
    now, there = simulation.frame.tick, simulation.frame.position
    drag(window, line.slider, 0.3)
    window.page.get_by_text("now is tick").wait_for()
    assert simulation.frame.tick < 0.5 * now
    until(lambda: window.card("tick") == str(simulation.frame.tick))
    window.press("Back to now")
    until(lambda: window.card("tick") == str(now))
    assert np.array_equal(simulation.frame.position, there)
    drag(window, line.slider, 0.3)
    until(lambda: simulation.state.line.looks_back)
    window.press("Go on from here")
    until(lambda: simulation.state.line.last < 0.5 * now)
    simulation.step(now - simulation.state.line.last)
    until(lambda: simulation.frame.tick == now)
    assert np.array_equal(simulation.frame.position, there)
    window.page.get_by_text("Back to now").wait_for(state="hidden")


def test_a_recording_is_opened_from_the_page_and_dragged(window, laboratory, tmp_path):
    simulation, line = laboratory.simulation, laboratory.time_line
    path, flock = tmp_path / "flight.parquet", Flock("vem", agents=40, rng=5)
    with Recorder(path, flock) as recorder:
        for _ in range(80):
            recorder.write()
            flock.run(1)
    window.tab("Save")
    with window.page.expect_file_chooser() as choosing:
        window.press("Open a file ...")
    choosing.value.set_files(path)
    window.page.get_by_text("Recording flight.parquet").wait_for()
    window.press("Pause")
    drag(window, line.slider, 0.5)
    until(lambda: 30 < simulation.frame.tick < 50)
    until(lambda: window.card("tick") == str(simulation.frame.tick))
    seen = simulation.frame
    again = Flock("vem", agents=40, rng=5)
    again.run(seen.tick)
    assert np.array_equal(seen.position, again.position)
    window.tab("Rule")
    assert laboratory.parameters.controls["eta"].disabled
