"""The plots of the laboratory: runs before this one, two clocks, and what is taken home."""

from __future__ import annotations

import io
import math
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from PIL import Image
from viser import uplot

from agents.flock import Flock
from agents.spec import Spec
from app.front.server import admit_browsers, close_server, open_server
from app.viewer.lab.panels.laboratory_plots import Overlay
from app.viewer.lab.panels.numbers_table import NumbersTable, numbers_html
from app.viewer.measuring.flock_numbers import Number, numbers
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.kept_runs import KeptRuns
from app.viewer.measuring.observable_curves import ObservableHistory, overlay_curves, thin_ticks
from app.viewer.measuring.run_conditions import MOST, ConditionHistory, RunConditions, Stretch
from app.viewer.panels.chart import KINDS, Chart, ChartContents, ChartCurve
from app.viewer.panels.sending import Sender
from app.viewer.run.paired_run import companion

ORDER = ("polarisation", "angular-momentum")


@pytest.fixture
def server():
    made = open_server(port=0)
    admit_browsers(made)
    yield made
    close_server(made)


def read(flock: Flock, ticks: int, each: int = 5) -> FlockReadings:
    """A flock that has run, measured now and then."""
    readings = FlockReadings(flock, watched=frozenset({"nearest-neighbour"}))
    readings.read(at_once=True)
    for _ in range(ticks // each):
        flock.advance(each)
        readings.read(at_once=True)
    return readings


def run(seed: int, ticks: int = 20, model: str = "vem", **given) -> FlockReadings:
    return read(Flock(model, agents=12, seed=seed, **given), ticks)


def overlay(*runs: FlockReadings, earlier: KeptRuns | None = None, last=math.inf) -> Overlay:
    return Overlay(runs, earlier or KeptRuns(), last)


def taken(made: Overlay, *names: str) -> pd.DataFrame:
    return pd.read_csv(io.BytesIO(made.plot_contents(names).content("CSV")))


def test_a_table_has_every_value_as_it_was_measured():
    readings = run(seed=4)
    table = taken(overlay(readings), *ORDER)
    own = ["world", "agents", "informed", *readings.flock.parameters.model_dump()]
    first = ["run", "model", "seed", "tick", "polarisation", "angular momentum"]
    assert list(table) == [*first, *own]
    assert table.run.unique().tolist() == ["now"]
    assert table.seed.unique().tolist() == [4]
    ticks, values = readings.series("polarisation").recorded()
    assert table.tick.tolist() == ticks.tolist() == [0, 5, 10, 15, 20]
    assert table.polarisation.tolist() == values.tolist()


def test_a_table_says_units_and_time():
    readings = run(seed=4, model="olfati-saber", ticks=10)
    made = overlay(readings)
    table = taken(made, "nearest-neighbour")
    dt = readings.flock.dt
    assert {"time (s)"} < set(table)
    column = next(name for name in table if name.startswith("nearest neighbour ("))
    np.testing.assert_allclose(table["time (s)"], table.tick * dt)
    shown = made.chart_contents(("nearest-neighbour",), keyed=False)
    assert shown.titles == ("time (s)", column)
    assert shown.at[-1] == pytest.approx(10 * dt)
    assert overlay(run(seed=4)).chart_contents(ORDER, keyed=False).titles[0] == "tick"


def test_a_table_counts_crashes_to_the_tick():
    flock = Flock("safe", agents=30, rng=3)
    readings = FlockReadings(flock)
    flock.arrays.crash_record[:3, :2] = [[2, 1], [2, 1], [7, 2]]
    flock.tick = 9
    readings.read(at_once=True)
    table = taken(overlay(readings), "crashes")
    assert table.tick.tolist() == [0, 2, 7, 9]
    assert table["crashes (agents)"].tolist() == [0, 2, 3, 3]


def test_a_value_stands_only_where_it_was_measured():
    readings = run(seed=4)
    readings.series("groups").add(22, 2.0)
    table = taken(overlay(readings), "polarisation", "groups")
    later = table[table.tick == 22]
    assert later.groups.tolist() == [2.0]
    assert later.polarisation.isna().all()


def test_two_clocks_are_one_time():
    first = Flock(Spec("olfati-saber", agents=12, seed=2))
    second = companion(first, Spec("reynolds"))
    runs = read(first, 10), read(second, 10)
    dts = [one.flock.dt for one in runs]
    made = overlay(*runs)
    table = taken(made, "polarisation")
    for name, dt in zip(("now", "beside"), dts, strict=True):
        rows = table[table.run == name]
        assert rows.tick.tolist() == [0, 5, 10]
        if runs[name == "beside"].flock.model.body.unit == "s":
            np.testing.assert_allclose(rows["time (s)"], rows.tick * dt)
    shown = made.chart_contents(("polarisation",), keyed=True)
    lines = [curve for curve in shown.curves if not curve.dots]
    assert [line.label for line in lines] == [
        "polarisation, olfati-saber",
        "polarisation, reynolds",
    ]
    assert [bool(line.dash) for line in lines] == [False, True]
    lines = made.plot_contents(("polarisation",)).lines
    for line, readings, each in zip(lines, runs, made.each, strict=True):
        np.testing.assert_allclose(line.at, np.array([0, 5, 10]) * each * dts[0])
        assert line.values.tolist() == readings.series("polarisation").recorded()[1].tolist()


def test_a_run_that_is_over_lies_under_the_next():
    runs = KeptRuns()
    before, now = run(seed=1, ticks=40), run(seed=2, ticks=20)
    runs.follow([before])
    assert runs.rows == ()
    runs.follow([now])
    assert [one.course.conditions.seed for one in runs.rows] == [1]
    made = overlay(now, earlier=runs)
    earlier, dots, current = made.chart_contents(("polarisation",), keyed=False).curves
    assert earlier.label == "polarisation, run 1"
    assert np.isnan(dots.values).all()
    at = made.chart_contents(("polarisation",), keyed=False).at
    assert at[-1] == 40
    assert np.isnan(current.values[at > 20]).all()
    assert np.isfinite(current.values[at <= 20]).all()
    assert earlier.values.tolist() == before.series("polarisation").recorded()[1].tolist()
    assert "run 1: seed 1" in made.head(("polarisation",), keyed=True)
    table = taken(made, "polarisation")
    assert table.groupby("run").tick.max().to_dict() == {"now": 20, "run 1: seed 1": 40}
    assert (
        overlay(now, earlier=runs, last=15).chart_contents(("polarisation",), keyed=False).at[-1]
        == 20
    )
    runs.show(1, False)
    alone = overlay(now, earlier=runs).chart_contents(("polarisation",), keyed=False)
    assert len(alone.curves) == 2


def test_a_run_of_which_nothing_was_seen_is_not_kept():
    runs = KeptRuns()
    runs.follow([FlockReadings(Flock("vem", agents=4, seed=1))])
    runs.follow([run(2, ticks=0)])
    runs.follow([run(3)])
    assert runs.rows == ()


def begun(model="vem", **given) -> ConditionHistory:
    return ConditionHistory.begin(Flock(model, **{"agents": 12, "seed": 1} | given))


def test_what_differs_between_runs_is_told():
    now = begun()
    assert now.differences(now) == ""
    assert begun(seed=3).differences(now) == "seed 3"
    assert begun(eta=0.25).differences(now) == "eta 0.25"
    other = begun(agents=9, noise="vectorial", size=4.0)
    assert "9 agents" in other.differences(now)
    assert "noise vectorial" in other.differences(now)
    assert "wrap as it was" in other.differences(now)
    assert now.differences(other).count(",") <= 3
    more = replace(now.first, seed=2, agents=3, parameters=dict.fromkeys(now.first.parameters, 9.0))
    assert ConditionHistory((Stretch(0, more),)).differences(now).endswith("…")


def changed(readings: FlockReadings, ticks: int = 10, **values) -> None:
    """Change parameters of a run as it goes, and run on."""
    readings.flock.set(**values)
    readings.note_conditions()
    readings.flock.advance(ticks)
    readings.read(at_once=True)


def test_a_run_keeps_the_parameters_that_it_was_made_with():
    """The first exercise of the first scene: a parameter is moved, Reset is pressed."""
    runs = KeptRuns()
    before = run(seed=1, eta=0.5)
    runs.follow([before])
    before.flock.set(eta=2.0)
    before.note_conditions()
    now = run(seed=1, eta=2.0)
    runs.follow([now])
    assert [one.label for one in overlay(now, earlier=runs).before] == ["run 1: eta 0.5"]
    table = taken(overlay(now, earlier=runs), "polarisation")
    assert table.groupby("run").eta.unique().map(list).to_dict() == {
        "now": [2.0],
        "run 1: eta 0.5": [0.5],
    }
    lines = overlay(now, earlier=runs).plot_contents(("polarisation",)).caption.split("\n")
    assert lines[1:] == ["eta 2"]


def test_a_change_is_a_mark_on_the_curve_and_a_step_in_the_table():
    runs = KeptRuns()
    before, now = run(seed=1, eta=0.5), run(seed=1, eta=0.5)
    changed(before, eta=2.0)
    runs.follow([before])
    runs.follow([now])
    made = overlay(now, earlier=runs)
    (label,) = [one.label for one in made.before]
    assert label == "run 1: eta 0.5 → 2 at tick 20"
    assert label in made.head(("polarisation",), keyed=True)
    rows = taken(made, "polarisation").query("run != 'now'")
    assert rows[rows.eta == 0.5].tick.tolist() == [0, 5, 10, 15, 20]
    assert rows[rows.eta == 2.0].tick.tolist() == [30]
    curves = made.chart_contents(("polarisation",), keyed=True)
    dots, _, none, _ = curves.curves
    assert np.isnan(none.values).all()
    assert curves.at[np.isfinite(dots.values)].tolist() == [20]
    at, values = before.series("polarisation").recorded()
    assert dots.values[curves.at == 20] == values[at == 20]
    changed(now, eta=0.7, ticks=3)
    changed(now, eta=0.9)
    made = overlay(now)
    assert made.changes() == ["eta 0.5 → … → 0.9 from tick 20 to tick 23"]
    assert "eta 0.5 → … → 0.9" in made.plot_contents(("polarisation",)).caption
    line = made.plot_contents(("polarisation",)).lines[0]
    assert line.marks[0].tolist() == [20, 23]
    assert np.isfinite(line.marks[1]).all()
    assert made.plot_contents(ORDER).content("SVG") != overlay(run(seed=1)).plot_contents(
        ORDER
    ).content("SVG")


def test_a_chart_is_not_made_anew_by_a_change():
    """A browser that makes a chart anew while the run goes on may lose the end of its time."""
    runs = KeptRuns()
    runs.keep(ObservableHistory.of(run(seed=1)))
    now = run(seed=2)
    pens = [one.pen for one in overlay(now, earlier=runs).chart_contents(ORDER, keyed=True).curves]
    changed(now, eta=2.0)
    after = overlay(now, earlier=runs)
    assert [one.pen for one in after.chart_contents(ORDER, keyed=True).curves] == pens
    assert "eta 0 → 2 at tick 20" in after.head(ORDER, keyed=True)
    assert "eta 0 → 2 at tick 20" not in after.head(ORDER, keyed=True, changes=False)


def test_a_mark_stands_on_the_curve_where_nothing_was_measured():
    now = run(seed=1, ticks=10)
    now.flock.advance(2)
    changed(now, eta=1.0, ticks=8)
    curves = overlay(now).chart_contents(("polarisation",), keyed=True)
    dots, line = curves.curves
    place = np.flatnonzero(np.isfinite(dots.values))
    assert curves.at[place].tolist() == [12]
    values = now.series("polarisation").recorded()[1]
    expected = values[2] + 0.2 * (values[3] - values[2])
    assert line.values[place] == dots.values[place] == pytest.approx(expected)


def test_changes_that_come_to_nothing_are_none():
    readings = run(seed=1, ticks=5, eta=0.5)
    begin = readings.conditions
    for eta in (0.7, 0.5):
        readings.flock.set(eta=eta)
        readings.note_conditions()
    assert readings.conditions == begin
    readings.flock.set(eta=0.7)
    readings.note_conditions()
    assert readings.conditions.at_end(readings.tick) == begin
    readings.flock.advance(5)
    readings.flock.set(eta=0.5)
    readings.note_conditions()
    assert readings.conditions.marks.tolist() == [5, 10]
    readings.flock.tick = 5
    readings.cut(5)
    assert readings.conditions == begin


def test_what_somebody_moves_by_hand_is_told():
    readings = run(seed=1, ticks=5)
    readings.note_conditions(by_hand=True)
    readings.flock.advance(5)
    readings.read(at_once=True)
    assert readings.conditions.changes() == ["agents moved by hand at tick 5"]
    assert readings.conditions.differences(begun()) == "agents moved by hand at tick 5"
    table = taken(overlay(readings), "polarisation")
    assert table["moved by hand"].tolist() == [False, False, True]


def test_a_changed_world_is_another_one_in_the_table():
    readings = run(seed=1, ticks=5, world="obstacles", size=None)
    world = readings.flock.world
    readings.flock.change_world(replace(world, obstacles=world.obstacles[1:]))
    readings.note_conditions()
    readings.flock.advance(5)
    readings.read(at_once=True)
    assert readings.conditions.changes() == ["obstacles changed at tick 5"]
    table = taken(overlay(readings), "polarisation")
    assert table.world.tolist() == ["obstacles", "obstacles", "obstacles #2"]


def test_of_too_many_changes_no_value_is_told_that_was_not():
    flock = Flock("vem", agents=3, seed=1)
    history = ConditionHistory.begin(flock)
    last = MOST + 9
    for tick in range(1, last + 1):
        flock.parameters = flock.parameters.model_copy(update={"eta": tick / 1000})
        history = history.with_change(tick, RunConditions.of(flock))
    assert len(history.stretches) == MOST
    ticks = np.arange(1, last + 2)
    told = [
        history.stretches[place].conditions.parameters["eta"]
        for place in history.stretch_indices(ticks)
    ]
    right = [0.0, *(tick / 1000 for tick in range(1, last + 1))]
    assert all(one in (None, value) for one, value in zip(told, right, strict=True))
    assert sum(one is None for one in told) >= 9


def test_curves_of_now_end_and_those_before_go_on():
    at, (now,), (old,) = overlay_curves(
        np.array([0.0, 2.0]), [np.array([1.0, 3.0])], [(np.array([1.0, 5.0]), np.ones(2))], True
    )
    assert at.tolist() == [0, 1, 2, 5]
    np.testing.assert_array_equal(now, [1, 2, 3, np.nan])
    np.testing.assert_array_equal(old, [np.nan, 1, 1, 1])


@pytest.mark.parametrize("moved", [0.0, 1.0, 17.0, 300.0])
def test_the_points_that_are_drawn_stay_while_the_curve_moves_on(moved):
    first, later = np.arange(3000.0), np.arange(3000.0) + moved
    drawn = [at[thin_ticks(at, 200)] for at in (first, later)]
    assert all(100 <= len(one) <= 202 for one in drawn)
    both = [one[(one > moved + 16) & (one < 2980)] for one in drawn]
    assert both[0].tolist() == both[1].tolist()
    assert drawn[1][-1] == later[-1]


def test_a_plot_is_taken_as_a_figure():
    runs = KeptRuns()
    runs.keep(ObservableHistory.of(run(seed=1)))
    plotted = overlay(run(seed=2), earlier=runs).plot_contents(ORDER)
    assert plotted.file("PNG") == "vem-seed2-tick20-polarisation-angular-momentum.png"
    picture = Image.open(io.BytesIO(plotted.content("PNG")))
    assert picture.size == (1280, 800)
    root = ElementTree.fromstring(plotted.content("SVG"))
    assert root.tag.endswith("svg")
    assert plotted.titles == ("tick", "polarisation, angular momentum")
    assert "seed 2, tick 20" in plotted.caption
    assert len({line.strength for line in plotted.lines}) == 2
    assert len(plotted.lines) == 4
    assert set(KINDS) == {"CSV", "PNG", "SVG"}


class NoMore:
    """Nobody has asked for more numbers."""

    def values(self, _readings: FlockReadings, _last: float) -> dict[str, Number]:
        return {}


def test_all_numbers_are_told_in_full_with_their_units():
    readings = run(seed=4, model="olfati-saber", ticks=10)
    found = numbers(readings, {"more": Number(0.5, "1")})
    assert found["tick"] == (10, "ticks")
    assert found["time"] == (pytest.approx(10 * readings.flock.dt), "s")
    assert found["polarisation"] == (readings.flock.observe("polarisation"), "1")
    assert found["gyration radius"] == (readings.flock.observe("gyration-radius"), "m")
    assert found["group 1"].value == found["largest group"].value
    assert found["more"] == (0.5, "1")
    led = numbers(run(seed=4, model="hwvem"), {})
    layers = [number.value for name, number in led.items() if name.startswith("layer ")]
    assert layers[0] == 1
    assert sum(layers) + led.get("in no layer", Number(0, "")).value == 13


def test_a_table_of_two_flocks_has_a_column_for_each(server):
    table = NumbersTable(server, NoMore(), Sender())
    table.refresh((run(seed=5), run(seed=5, model="safe")), math.inf)
    read_back = pd.read_csv(io.BytesIO(table.csv()), index_col="name")
    assert list(read_back) == ["vem", "safe", "unit"]
    first, second = table.runs
    assert read_back.vem["polarisation"] == first.values["polarisation"]
    assert read_back.safe["polarisation"] == second.values["polarisation"]
    assert np.isnan(read_back.vem["crashes"])
    assert read_back.unit["crashes"] == "agents"
    table.refresh((first,), math.inf)
    alone = pd.read_csv(io.BytesIO(table.csv()), index_col="name")
    assert list(alone) == ["value", "unit"]
    assert repr(first.values["polarisation"]) in numbers_html(table.header, table.rows)


def shown(at, *labels: str) -> ChartContents:
    curves = tuple(ChartCurve("#000000", np.arange(float(len(at))), label) for label in labels)
    return ChartContents("", np.array(at, float), curves, ("tick", ""), uplot.Scale())


def test_a_chart_has_all_that_it_is_given_at_once(server):
    chart = Chart(server.gui)
    chart.show(shown([0], "a"))
    assert chart.plot.data[0].tolist() == [0, 1], "a chart needs some time to show"
    chart.show(shown([0, 5, 9], "a"))
    assert chart.plot.data[0].tolist() == [0, 5, 9]
    chart.show(shown([0, 2], "a", "b"))
    assert len(chart.plot.series) == len(chart.plot.data) == 3
    assert chart.plot.data[0].tolist() == [0, 2]
    assert chart.plot.data[2].tolist() == [0, 1]
    chart.show(shown([0, 1, 2], "a", "c"))
    assert chart.plot.data[0].tolist() == [0, 1, 2]


def test_a_chart_has_few_points_but_the_last_of_every_curve(server):
    chart = Chart(server.gui, points=100)
    at = np.arange(5000.0)
    ended = np.where(at <= 1234, at, np.nan)
    pens = ChartCurve("#000000", at, "a"), ChartCurve("#000000", ended, "b")
    chart.show(ChartContents("", at, pens, ("tick", ""), uplot.Scale()))
    drawn = chart.plot.data[0]
    assert len(drawn) <= 103
    assert {0.0, 1234.0, 4999.0} <= set(drawn)
