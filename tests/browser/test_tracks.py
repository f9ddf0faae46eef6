"""Tracks of a file, opened from the page, dragged, looked at, and set beside a model."""

from __future__ import annotations

import numpy as np

from agents.spec import DEFAULT
from tests.browser.test_time_line import drag
from tests.tracks.playing.ring_tracks import COUNT, FRAMES, GAP, ring_tracks
from tests.viewer.waiting import COMPILED, until


def written(path, with_time: bool = True):
    """The ring as a plain table."""
    tracks = ring_tracks()
    lines = ["time,id,x,y" if with_time else "frame,id,x,y"]
    for k in range(FRAMES):
        for row in np.flatnonzero(tracks.seen[k]):
            x, y = tracks.position[k, row]
            when = tracks.time[k] if with_time else tracks.frame[k]
            lines.append(f"{when:g},fish {row},{x:.6f},{y:.6f}")
    path.write_text("\n".join(lines) + "\n")
    return path


def choose(window, label: str, path) -> None:
    """Choose a file behind a button."""
    with window.page.expect_file_chooser() as choosing:
        window.press(label)
    choosing.value.set_files(path)


def test_tracks_are_asked_for_what_is_missing_then_played_and_dragged(window, laboratory, tmp_path):
    simulation, panel = laboratory.simulation, laboratory.tracks
    window.tab("Tracks")
    choose(window, "Open tracks ...", written(tmp_path / "ring.csv", with_time=False))
    window.page.get_by_text("Not read.").first.wait_for()
    until(lambda: panel.again.visible)
    panel.rate.value, panel.unit.value, panel.origin.value = 25.0, "m", "bottom-left"
    window.press("Read the file with these")
    window.page.get_by_text("Tracks ring.csv:").wait_for()
    window.press("Pause")
    until(lambda: not simulation.state.running)
    drag(window, laboratory.time_line.slider, (GAP.start + 3) / FRAMES)
    until(lambda: GAP.start < simulation.frame.tick < GAP.stop)
    window.page.get_by_text("1 in a gap (hollow)").wait_for()
    until(lambda: window.card("seen now") == str(COUNT - 1))
    window.press("Start a model here")
    until(lambda: simulation.state.models == ("tracks", "couzin"), COMPILED)
    until(lambda: simulation.frame.beside is not None, COMPILED)
    window.page.get_by_text("1 s is 10 ticks (a tick is 0.1 s)").first.wait_for()
    until(lambda: np.isfinite(simulation.readings.values.get("divergence", np.nan)))
    window.press("Tracks alone")
    until(lambda: simulation.frame.beside is None)
    laboratory.tracks.plain = None


def test_a_foreign_file_changes_nothing_and_is_told_in_one_line(window, laboratory, tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("nothing of this is a place\n")
    window.tab("Tracks")
    choose(window, "Open tracks ...", path)
    window.page.get_by_text("Not read.").first.wait_for()
    until(lambda: "notes.txt" in laboratory.tracks.fault.content)
    assert not laboratory.tracks.again.visible
    assert laboratory.simulation.state.spec.model == DEFAULT
