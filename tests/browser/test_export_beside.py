"""Two flocks beside each other in one page, each in a frame of its own."""

from __future__ import annotations

import numpy as np
import pytest

from agents.flock import Flock
from agents.spec import Spec
from app.viewer.lab.flock_page import PageWords, pair_page
from app.viewer.run.paired_run import companion
from tests.viewer.waiting import until


@pytest.fixture
def both(chromium, tmp_path):
    """A page of hwvem beside vem, its two frames, and the flocks here."""
    flock = Flock("hwvem", agents=30, rng=3)
    second = companion(flock, Spec("vem"))
    file = tmp_path / "both.html"
    file.write_text(pair_page(flock, second, PageWords("Two <rules>", "Look & see.")), "utf-8")
    page = chromium.new_page(viewport={"width": 1100, "height": 720})
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda line: errors.append(line.text) if line.type == "error" else None)
    page.goto(file.as_uri())
    frames = [frame for frame in page.frames if frame != page.main_frame]
    for frame in frames:
        frame.wait_for_selector("#go:not([disabled])", timeout=60_000)
    yield page, frames, (flock, second)
    page.close()
    assert errors == []


def ticks(frames) -> list[int]:
    """Where both are."""
    return [int(frame.inner_text("#tick").replace("\u2009", "")) for frame in frames]


def test_both_begin_alike_and_go_pause_step_and_begin_again_together(both):
    page, frames, flocks = both
    assert page.inner_text("h1") == "Two <rules>"
    assert page.inner_text("header p") == "Look & see."
    assert [frame.inner_text("h1") for frame in frames] == [one.model.rule.title for one in flocks]
    for frame, flock in zip(frames, flocks, strict=True):
        assert not frame.is_visible("#anew"), "both keep their one start"
        place = frame.evaluate("[...page.state.position]")
        assert np.reshape(place, (31, 2)) == pytest.approx(flock.position, abs=1e-12)
    page.click("#go")
    until(lambda: min(ticks(frames)) > 3, 60, "both to go")
    assert page.inner_text("#go") == "Pause both"
    page.click("#go")
    until(lambda: not any(frame.evaluate("page.going") for frame in frames), 60, "both to pause")
    page.click("#reset")
    until(lambda: ticks(frames) == [0, 0], 60, "both to begin again")
    page.click("#step")
    until(lambda: ticks(frames) == [1, 1], 60, "a step of both")


def test_what_no_button_says_presses_nothing(both):
    page, frames, _ = both
    page.evaluate(
        """() => {
          const nonsense = [{ press: "constructor" }, { press: "save" }, "go", null, { press: {} }];
          for (const data of nonsense) frames[0].postMessage(data, "*");
        }"""
    )
    frames[0].evaluate("parent.frames[1].postMessage({ press: 'go' }, '*')")
    page.click("#step")
    until(lambda: ticks(frames) == [1, 1], 60, "a step of both")
    assert [frame.evaluate("page.going") for frame in frames] == [False, False]
