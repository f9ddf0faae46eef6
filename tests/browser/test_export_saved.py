"""What a flock's page keeps of a long run, and what it saves."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from agents.flock import Flock
from tests.browser.exported_page import page_text
from tests.browser.test_export_view import DRAWN
from tests.viewer.waiting import until

MOST = 4000
"""Points that a chart keeps."""
LONG = """async () => {
  const { take } = page, [[, start]] = page.charts[0].points, found = { least: start, most: start };
  page.take = (answer) => {
    for (const [, value] of answer.rows) {
      found.least = Math.min(found.least, value);
      found.most = Math.max(found.most, value);
    }
    take.call(page, answer);
  };
  document.getElementById("trails").click();
  for (let k = 0; k < 100; k++) await page.ask({ ticks: 1000 });
  return found;
}"""
"""Flies 100 000 ticks; the least and the greatest value that the first chart is given."""


def test_a_long_run_keeps_its_peaks_and_no_more_points_than_it_should(opened):
    with opened(Flock("vem", agents=3, rng=3, eta=2.0)) as page:
        assert page.locator("#kept").is_hidden()
        found = page.evaluate(LONG)
        points = page.evaluate("page.charts.map((chart) => chart.points)")
        values = [value for _, value in points[0]]
        assert all(len(curve) <= MOST for curve in points)
        assert (min(values), max(values)) == (found["least"], found["most"])
        assert points[0][-1][0] == 100_000
        assert "of every 64 ticks" in page.locator("#kept").inner_text()
        with page.expect_download() as saved:
            page.click("#save")
        assert (
            saved.value.suggested_filename
            == "vem-polarisation-mean-neighbours-extremes-of-64-ticks.csv"
        )
        rows = saved.value.path().read_text().splitlines()[1:]
        assert [float(row.split(",")[1]) for row in rows if row.split(",")[1]] == values
        assert page.evaluate("page.requests.waiting.size") == 0
        assert page.evaluate("page.view.trail.lines") == 3
        page.click("#reset")
        page.evaluate("page.ask({})")
        assert page.locator("#kept").is_hidden()


def test_a_curve_keeps_every_tick_until_it_is_long_and_then_a_peak_of_one(opened):
    add = """([ticks, peak]) => {
      const [chart] = page.charts;
      chart.clear();
      for (let tick = 0; tick <= ticks; tick++)
        chart.add(tick, tick === peak ? 9 : tick % 3 ? 0.5 : NaN);
      return chart.points.map(([tick, value]) => [tick, Number.isFinite(value) ? value : null]);
    }"""
    with opened(Flock("vem", agents=3, rng=3)) as page:
        points = page.evaluate(add, [MOST - 1, 77])
        assert [tick for tick, _ in points] == list(range(MOST))
        assert points[3][1] is None
        points = page.evaluate(add, [1_000_000, 77])
        assert MOST / 4 < len(points) <= MOST
        assert [77, 9] in points
        assert [tick for tick, _ in points] == sorted(tick for tick, _ in points)


@pytest.mark.parametrize("ticks", [0, 1])
def test_an_answer_for_the_newest_tick_takes_the_place_of_the_one_before(opened, ticks):
    with opened(Flock("vem", agents=3, rng=3)) as page:
        found = page.evaluate(
            """(ticks) => {
              const [chart] = page.charts;
              chart.clear();
              for (let tick = 0; tick <= ticks; tick++) chart.add(tick, 1);
              chart.add(ticks, 2);
              return chart.points;
            }""",
            ticks,
        )
        assert found == [[tick, 1] for tick in range(ticks)] + [[ticks, 2]]


def saved_image(page, button: str, frame=None) -> tuple[str, np.ndarray]:
    """What a button saves: its name, and its colours (height, width, 3)."""
    with page.expect_download() as saved:
        (frame or page).click(button)
    return saved.value.suggested_filename, np.asarray(Image.open(saved.value.path()).convert("RGB"))


def pixels_of(image: np.ndarray, colour: str) -> np.ndarray:
    """Where an image has a colour #rrggbb, bool (height, width)."""
    return np.all(image == [int(colour[k : k + 2], 16) for k in (1, 3, 5)], axis=-1)


@pytest.mark.parametrize(
    ("theme", "card", "ink"), [("light", "#ffffff", "#2f6fed"), ("dark", "#1a2029", "#7aa7ff")]
)
def test_both_charts_are_saved_in_the_colours_of_the_page(opened, theme, card, ink):
    with opened(Flock("vem", agents=30, rng=3)) as page:
        page.evaluate(f"location.hash = 'theme={theme}'")
        page.evaluate("page.ask({ ticks: 40 })")
        until(lambda: page.evaluate("isDark()") == (theme == "dark"), 60, "the theme")
        name, image = saved_image(page, "#save-charts")
        assert name == "vem-polarisation-mean-neighbours.png"
        assert image.shape == (1080, 1280, 3)
        assert pixels_of(image, card).mean() > 0.8
        curves = pixels_of(image, ink)
        assert curves[120:600].sum() > 1000
        assert curves[600:].sum() > 1000
        assert curves[:120].sum() == 0


def test_the_picture_is_saved_as_it_is_shown(opened):
    with opened(Flock("vem", agents=30, rng=3)) as page:
        page.evaluate("page.ask({ ticks: 40 })")
        name, image = saved_image(page, "#save-picture")
        shown = page.evaluate("[page.view.canvas.height, page.view.canvas.width]")
        drawn = ~pixels_of(image, "#fbfcfe")
        assert name == "vem-tick-40.png"
        assert list(image.shape[:2]) == shown
        assert drawn.sum() == pytest.approx(page.evaluate(DRAWN), rel=0.1)
        page.evaluate("page.view.picked = 1n; page.view.changed()")
        _, marked = saved_image(page, "#save-picture")
        assert (~pixels_of(marked, "#fbfcfe")).sum() > drawn.sum() + 50


def test_it_saves_in_a_frame_that_may_download(chromium, tmp_path):
    file, outer = tmp_path / "inner.html", tmp_path / "outer.html"
    file.write_text(page_text(Flock("vem", agents=30, rng=3)), encoding="utf-8")
    frame = '<iframe sandbox="allow-scripts allow-downloads" width="900" height="700" src="{}">'
    outer.write_text(frame.format(file.as_uri()), encoding="utf-8")
    page = chromium.new_page()
    try:
        page.goto(outer.as_uri())
        inner = page.frames[1]
        until(lambda: inner.evaluate("'page' in globalThis"), 60, "the flock to be there")
        assert saved_image(page, "#save-charts", inner)[1].shape == (1080, 1280, 3)
        _, image = saved_image(page, "#save-picture", inner)
        assert (~pixels_of(image, "#fbfcfe")).any()
        with page.expect_download() as saved:
            inner.click("#save")
        assert saved.value.path().read_text().startswith("tick,")
    finally:
        page.close()
