"""Several pages of flocks at once, and one that nobody looks at for a while."""

from __future__ import annotations

import numpy as np
import pytest

from agents.flock import Flock
from tests.browser.exported_page import page_text
from tests.viewer.waiting import until

MODELS = ("vem", "couzin", "hwvem", "reynolds", "dorsogna", "cucker-smale")
FRAME = '<iframe sandbox="allow-scripts" width="420" height="330" src="{}"></iframe>'
HELD = """
globalThis.held = [];
globalThis.requestAnimationFrame = (draw) => held.push(draw);
"""
"""A browser that draws a picture when a test says so."""
DRAWN = """async (pauses) => {
  let now = page.flight.last;
  const ran = [];
  for (const pause of pauses) {
    const before = page.state.tick;
    now += pause;
    await held.shift()(now);
    ran.push(page.state.tick - before);
  }
  return ran;
}"""
"""Draws one picture after each of some pauses, ms; the ticks that each of them runs."""


def test_six_pages_run_beside_each_other(chromium, tmp_path):
    for model in MODELS:
        text = page_text(Flock(model, agents=20, rng=3))
        (tmp_path / f"{model}.html").write_text(text, encoding="utf-8")
    frames = "".join(FRAME.format(f"{model}.html") for model in MODELS)
    (tmp_path / "six.html").write_text(frames, encoding="utf-8")
    page = chromium.new_page(viewport={"width": 1300, "height": 720})
    try:
        page.goto((tmp_path / "six.html").as_uri())
        flocks = page.frames[1:]
        assert len(flocks) == len(MODELS)
        for frame in flocks:
            until(lambda frame=frame: frame.evaluate("'page' in globalThis"), 60, "the flock")
            frame.click("#go")
        for frame in flocks:
            until(lambda frame=frame: frame.evaluate("page.state.tick > 20"), 60, "some ticks")
        for model, frame in zip(MODELS, flocks, strict=True):
            frame.click("#go")
            tick, error, position = frame.evaluate(
                "page.ask({}).then((one) => [one.tick, one.error, [...one.position]])"
            )
            assert error == ""
            flock = Flock(model, agents=20, rng=3)
            assert np.isfinite(position).all()
            assert len(position) == flock.position.size
            points = frame.evaluate("page.charts[0].points.map(([tick]) => tick)")
            assert points == list(range(tick + 1))
    finally:
        page.close()


def test_a_page_that_nobody_sees_goes_on_without_a_burst(opened):
    """A browser draws nothing then: what was missed is not made up for."""
    hour = 3_600_000
    with opened(Flock("vem", agents=20, rng=3), HELD) as page:
        page.evaluate("page.speed = () => 100")
        page.evaluate("page.go(true)")
        ran = page.evaluate(DRAWN, [20, 20, 20, hour, 20, 20, 20])
        tick = sum(ran)
        assert 1 <= ran.pop(3) <= 26  # a quarter of a second, and what was owed before
        assert all(1 <= ticks <= 3 for ticks in ran)
        assert page.locator("#tick").inner_text() == str(tick)
        points = page.evaluate("page.charts[0].points.map(([tick]) => tick)")
        assert points == list(range(tick + 1))
        flock = Flock("vem", agents=20, rng=3)
        flock.run(tick)
        position = np.reshape(page.evaluate("[...page.state.position]"), (20, 2))
        assert position == pytest.approx(flock.position, abs=1e-9)
        page.evaluate("page.go(false)")
