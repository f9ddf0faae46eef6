"""What a flock's page keeps of a long run, and what it saves."""

from __future__ import annotations

import pytest

from agents.flock import Flock

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
