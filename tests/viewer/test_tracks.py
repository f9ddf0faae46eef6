"""Tracks in the laboratory: played, sought in, looked at, and set beside a model."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import viser

from agents.catalogue import MODELS
from agents.spec import Spec
from app.tracks.playing.played_tracks import PlayedTracks
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.panels.inspector import facts
from app.viewer.lab.panels.laboratory_plots import Overlay
from app.viewer.lab.panels.run_panel import describe_time_line
from app.viewer.lab.panels.tracks_panel import OVER, describe_tracks
from app.viewer.measuring.kept_runs import KeptRuns
from app.viewer.run import tracks_run
from app.viewer.run.frame_builder import FrameRequest
from app.viewer.run.simulation import Simulation
from app.viewer.run.stored_tracks import (
    ModelStart,
    StoredTracks,
    proposed_length,
    proposed_ticks,
    start_model,
)
from app.viewer.scene.draw.drawn_frame import picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks.agents import dart_rows
from app.viewer.scene.marks.flock_marks import OUTLINE, HollowMarks
from app.viewer.scene.scene import find_clicked, offset, sights
from app.viewer.scene.shown.drawing_style import DrawingStyle
from tests.tracks.playing.ring_tracks import (
    COUNT,
    FRAMES,
    GAP,
    GONE,
    LATE,
    RADIUS,
    RATE,
    TURN,
    ring_tracks,
)
from tests.viewer.waiting import COMPILED, until
from worlds.input_error import InputError

START = 50


@pytest.fixture(scope="module")
def played():
    return PlayedTracks(ring_tracks())


@pytest.fixture
def simulate():
    """Makes paused simulations of tracks, and closes them."""
    made = []

    def make(stored: StoredTracks) -> Simulation:
        simulation = Simulation(stored.spec, stored.beside, math.inf, running=False, stored=stored)
        made.append(simulation)
        until(lambda: simulation.frame and simulation.state.compiling is None, COMPILED)
        return simulation

    yield make
    for simulation in made:
        simulation.close()


def seek(simulation: Simulation, tick: int) -> None:
    simulation.time_line.seek(tick).result(60)
    until(lambda: simulation.frame.tick == tick)


def started(played: PlayedTracks, model: str, ticks: float | None = None, **more) -> StoredTracks:
    spec = Spec(model, parameters=more.pop("parameters", {}))
    ticks = proposed_ticks(played, spec) if ticks is None else ticks
    return StoredTracks(played).with_model(ModelStart(spec, START, ticks, **more))


# Played.


def test_tracks_are_played_to_their_end_and_stop_there(simulate, played):
    simulation = simulate(StoredTracks(played))
    assert (simulation.frame.tick, simulation.state.line.recording) == (0, "ring.csv")
    simulation.go()
    until(lambda: not simulation.state.running)
    until(lambda: simulation.frame.tick == FRAMES - 1)
    last = played.at(FRAMES - 1)
    assert np.array_equal(simulation.frame.position, last.position)
    assert simulation.readings.values["number-seen"] == COUNT - 1
    at, values = simulation.readings.series("number-seen").arrays()
    assert at[-1] == FRAMES - 1
    assert values[-1] == COUNT - 1


def test_a_frame_says_who_is_seen_and_who_is_hollow(simulate, played):
    simulation = simulate(StoredTracks(played))
    seek(simulation, GAP.start + 2)
    frame = simulation.frame
    assert np.flatnonzero(~frame.seen).tolist() == [3]
    assert np.flatnonzero(frame.outlined).tolist() == [3]
    assert frame.names[3] == "fish 3"
    assert "1 in a gap (hollow)" in describe_time_line(simulation.state.line, frame)
    seek(simulation, LATE - 5)
    assert not simulation.frame.outlined.any()
    assert "11 of 12 individuals seen" in describe_time_line(
        simulation.state.line, simulation.frame
    )


def test_speeds_of_pixels_are_in_pixels(simulate):
    played = PlayedTracks(ring_tracks("px"))
    simulation = simulate(StoredTracks(played))
    assert simulation.frame.pace_unit == "px/s"
    simulation.set_request(FrameRequest(row=0))
    until(lambda: simulation.frame.inspected is not None)
    told = facts(simulation.frame, simulation.frame.inspected)
    assert told["speed"].endswith(" px/s")
    assert "position (px)" in told


def test_nothing_in_tracks_can_be_changed_but_what_counts_as_near(simulate, played):
    simulation = simulate(StoredTracks(played))
    with pytest.raises(InputError, match="Start a model here"):
        simulation.set("frame_time", 1.0).result(60)
    with pytest.raises(InputError, match="nothing can be changed"):
        simulation.place(0, np.zeros(2), np.array([1.0, 0.0])).result(60)
    with pytest.raises(InputError, match="tracks follow no rule"):
        simulation.time_line.go_on().result(60)
    with pytest.raises(InputError, match="there is no spec"):
        simulation.spec().result(60)
    with pytest.raises(InputError, match="which no page can run"):
        simulation.flocks().result(60)
    assert simulation.readings.values["groups"] == 1.0
    simulation.set("within", 0.1).result(60)
    until(lambda: simulation.readings.values.get("groups") == COUNT - 1)


def test_order_of_too_few_is_not_told(simulate):
    tracks = ring_tracks()
    tracks.position[60:, 4:] = np.nan
    simulation = simulate(StoredTracks(PlayedTracks(tracks)))
    seek(simulation, 50)
    until(lambda: "polarisation" in simulation.readings.values)
    seek(simulation, 70)
    until(lambda: simulation.readings.values.get("number-seen") == 4.0)
    assert "polarisation" not in simulation.readings.values
    at, values = simulation.readings.series("polarisation").recorded()
    assert np.isnan(values[at > 60]).all()
    assert np.isfinite(values[at == 50]).all()
    pair = ring_tracks().individuals([0, 1])
    alone = simulate(StoredTracks(PlayedTracks(pair)))
    assert "polarisation" in alone.readings.values  # there are never more


def test_curves_have_a_gap_where_much_is_left_out(simulate, played):
    simulation = simulate(StoredTracks(played))
    for tick in (0, 5, 100):
        seek(simulation, tick)
        until(lambda: simulation.time_line.moved is None)
    at, values = simulation.readings.series("number-seen").arrays()
    assert np.isnan(values[(at > 5) & (at < 100)]).any()
    content = Overlay((simulation.readings,), KeptRuns(), math.inf).chart_contents(
        ("number-seen",), keyed=False
    )
    curve = next(curve for curve in content.curves if curve.label)
    assert np.isnan(curve.values).any()
    assert np.isfinite(curve.values[[0, -1]]).all()
    assert math.isfinite(simulation.readings.over("susceptibility"))


def test_an_individual_is_inspected_without_a_rule(simulate, played):
    simulation = simulate(StoredTracks(played))
    simulation.set_request(FrameRequest(row=3))
    seek(simulation, GAP.start + 5)
    until(lambda: simulation.frame.inspected is not None)
    told = facts(simulation.frame, simulation.frame.inspected)
    assert told["seen now"] == "no, 0.24 s ago"
    assert told["gaps"] == "1"
    assert told["seen"] == "83.3 % of frames"
    assert "listens to" not in told
    assert "m/s" in told["speed"]


# A model that starts in them.


def test_a_model_starts_from_places_headings_and_speeds_of_those_seen(played):
    for name in ("couzin", "reynolds", "dorsogna", "vem"):
        stored = started(played, name)
        flock = start_model(played, stored.start)
        then = played.at(START)
        rows = np.flatnonzero(then.seen)
        assert flock.ids.tolist() == (rows + 1).tolist(), name
        assert np.array_equal(flock.position, then.position[rows])
        assert np.allclose(flock.heading, then.heading[rows], atol=1e-6)
        if MODELS[name].body.speed is None:
            assert flock.speed == pytest.approx(then.speed[rows], rel=1e-6)
            assert flock.speed.min() > 0.0


def test_ticks_of_a_model_are_such_that_it_goes_as_fast_as_the_tracks(played):
    ticks = proposed_ticks(played, Spec("vem", parameters={"v0": 0.5}))
    assert ticks * 0.5 == pytest.approx(RADIUS * TURN, rel=0.01)
    assert proposed_ticks(played, Spec("couzin")) == pytest.approx(10.0)  # it counts seconds
    assert proposed_ticks(played, Spec("vem", parameters={"v0": 0.0})) == pytest.approx(RATE)
    assert proposed_length(played) == 1.0
    pixels = PlayedTracks(ring_tracks("px"))
    assert proposed_length(pixels) == pytest.approx(pixels.spacing, rel=0.01)


def test_the_model_has_the_ticks_that_the_time_of_the_tracks_takes(simulate, played):
    stored = started(played, "vem", ticks=60.0)
    simulation = simulate(stored)
    assert simulation.frame.tick == START
    begin = simulation.frame.beside.tick
    assert begin == START / RATE * 60.0
    seek(simulation, START + 7)
    assert simulation.frame.beside.tick == begin + int(7 / RATE * 60.0)
    simulation.time_line.seek(START - 20).result(60)  # there is no model before it starts
    until(lambda: simulation.frame.tick == START)


def seek_until(simulation: Simulation, tick: int) -> np.ndarray:
    seek(simulation, tick)
    until(lambda: simulation.time_line.moved is None)
    return simulation.frame.beside.position.copy()


def test_to_go_back_and_on_again_gives_the_same_to_the_bit(simulate, played):
    simulation = simulate(started(played, "couzin"))
    first = seek_until(simulation, START + 60)
    seek(simulation, START + 25)
    seek(simulation, START)
    assert np.array_equal(seek_until(simulation, START + 60), first)
    simulation.reset().result(60)
    until(lambda: simulation.frame.tick == START)
    assert np.array_equal(seek_until(simulation, START + 60), first)


def test_divergence_is_the_mean_distance_of_those_who_are_paired_and_seen(simulate, played):
    simulation = simulate(started(played, "couzin"))
    assert simulation.readings.values["divergence"] == pytest.approx(0.0, abs=1e-9)
    seek(simulation, GONE + 10)
    until(lambda: simulation.time_line.moved is None)
    until(lambda: simulation.readings.tick == GONE + 10)
    frame = simulation.frame
    rows = frame.beside.ids - 1
    seen = frame.seen[rows]
    assert 3 not in rows  # it was in its gap when the model started
    apart = np.linalg.norm(frame.position[rows] - frame.beside.position, axis=1)[seen]
    assert simulation.readings.values["divergence"] == pytest.approx(float(apart.mean()))
    assert simulation.readings.values["divergence"] > 0.1


def test_agents_of_the_model_are_as_large_as_the_individuals(simulate):
    played = PlayedTracks(ring_tracks().individuals([0, 1, 2]))
    simulation = simulate(started(played, "couzin"))
    frame = simulation.frame
    sizes = {picture(one, DrawingStyle(), Stage.of(one)).length for one in (frame, frame.beside)}
    assert len(sizes) == 1


def test_parameters_of_the_model_can_be_changed_and_stay_when_one_goes_back(simulate, played):
    simulation = simulate(started(played, "couzin"))
    seek(simulation, START + 20)
    simulation.set("r_r", 0.4, beside=True).result(60)
    assert simulation.state.beside_values["r_r"] == 0.4
    seek(simulation, START + 5)
    assert simulation.run.model.parameters.r_r == 0.4
    with pytest.raises(InputError, match="Couzin's zones: r_r = -1"):
        simulation.set("r_r", -1.0, beside=True).result(60)


def test_a_model_that_takes_long_comes_as_far_as_a_second_allows(simulate, played, monkeypatch):
    monkeypatch.setattr(tracks_run, "LONGEST", -1.0)
    simulation = simulate(started(played, "couzin"))
    simulation.time_line.seek(START + 60).result(60)
    until(lambda: simulation.frame.tick == START + tracks_run.KEPT)
    assert simulation.state.line.sought == START + 60
    simulation.time_line.seek(START + 60).result(60)
    until(lambda: simulation.frame.tick == START + 2 * tracks_run.KEPT)


def test_what_is_kept_of_a_model_is_bounded(simulate, played, monkeypatch):
    monkeypatch.setattr(tracks_run, "KEPT", 1)
    monkeypatch.setattr(tracks_run, "MEMORY", 20_000)
    simulation = simulate(started(played, "couzin"))
    end = seek_until(simulation, FRAMES - 1)
    kept = simulation.run.kept
    assert len(kept) < 20
    assert kept[0][0] == START
    assert simulation.run.apart > 1
    seek(simulation, START + 3)
    assert np.array_equal(seek_until(simulation, FRAMES - 1), end)


def test_tracks_without_their_file_are_no_run(simulate, played):
    simulation = simulate(StoredTracks(played))
    before = simulation.state.run
    simulation.setup(played.spec).result(60)
    until(lambda: not simulation.notices.empty())
    assert "open their file again" in simulation.notices.get()
    assert simulation.state.run == before


def test_curves_of_both_go_over_the_same_seconds(simulate, played):
    simulation = simulate(started(played, "vem", ticks=60.0))
    for tick in range(START, START + 30, 10):
        seek(simulation, tick)
        until(lambda: simulation.time_line.moved is None)
    both = simulation.readings, simulation.readings_beside
    overlay = Overlay(both, KeptRuns(), math.inf)
    assert overlay.clock == (1.0 / RATE, "time (s)")
    assert overlay.each == pytest.approx([1.0, RATE / 60.0])
    content = overlay.chart_contents(("polarisation",), keyed=True)
    assert content.at[0] == pytest.approx(START / RATE, abs=0.02)
    assert content.at[-1] == pytest.approx((START + 20) / RATE, abs=0.02)
    labelled = [curve for curve in content.curves if curve.label]
    assert all(np.isfinite(curve.values).all() for curve in labelled)


@pytest.mark.parametrize(
    ("model", "ticks", "tick", "says"),
    [
        ("vem", 0.0, START, r"ticks per second = 0 is outside \[1e-06, 10000\]"),
        ("vem", math.nan, START, "ticks per second = nan"),
        ("vem", 1e9, START, "ticks per second"),
    ],
)
def test_a_model_that_cannot_start_is_refused_in_one_line(played, model, ticks, tick, says):
    start = ModelStart(Spec(model), tick, ticks)
    with pytest.raises(InputError, match=says) as refused:
        start_model(played, start)
    assert "\n" not in str(refused.value)


def test_a_flat_model_does_not_start_in_space():
    tracks = ring_tracks()
    place = np.concatenate([tracks.position, np.ones((FRAMES, COUNT, 1))], axis=2)
    played = PlayedTracks(ring_tracks(position=place))
    flat = next(name for name, one in MODELS.items() if one.dimensions == (2,))
    with pytest.raises(InputError, match="not defined in 3 dimensions"):
        start_model(played, ModelStart(Spec(flat), START, 10.0))


def test_a_model_in_a_frame_with_nobody_is_refused():
    tracks = ring_tracks()
    tracks.position[10] = np.nan
    played = PlayedTracks(tracks)
    with pytest.raises(InputError, match=r"nobody is seen at 0.4 s in ring.csv"):
        start_model(played, ModelStart(Spec("vem"), 10, 25.0))


def test_who_stands_in_a_wall_starts_beside_it():
    hole = "POLYGON ((-7 -7, 7 -7, 7 7, -7 7, -7 -7), (4 -1, 6 -1, 6 1, 4 1, 4 -1))"
    played = PlayedTracks(ring_tracks(boundary=hole))
    flock = start_model(played, ModelStart(Spec("couzin"), 0, 10.0))
    assert flock.moved == 1
    inside = (np.abs(flock.position - [5.0, 0.0]) < 1.0).all(axis=1)
    assert not inside.any()


# Drawn.


@pytest.fixture
def shown(played):
    """A frame in which one is in a gap, and its picture."""

    def make(**more):
        then = played.at(GAP.start + 2)
        from app.viewer.pictures.shot import frame_of

        frame = replace(frame_of(then, DrawingStyle(), 0.0), **more)
        return frame, picture(frame, DrawingStyle(), Stage.of(frame))

    return make


def test_only_those_seen_have_bodies_and_those_in_a_gap_an_outline(shown):
    _, made = shown()
    assert 3 not in dart_rows(made)
    assert len(dart_rows(made)) == COUNT - 1
    server = viser.ViserServer(port=0, verbose=False)
    try:
        changes = {name: value for _, name, value in HollowMarks(server.scene).draw(made)}
        assert changes["points"].shape == (len(OUTLINE), 2, 3)
        middle = changes["points"].reshape(-1, 3).mean(axis=0)
        assert np.abs(middle - made.at[3]).max() < made.length
    finally:
        server.stop()
    gone, unseen = shown(hollow=np.zeros(COUNT, bool))
    assert not gone.outlined.any()
    assert not unseen.is_there[3]


def test_a_click_never_hits_who_is_not_there(shown):
    down = np.array([0.0, 0.0, -1.0])
    for hollow, expected in ((None, 3), (np.zeros(COUNT, bool), None)):
        _, made = shown(**({} if hollow is None else {"hollow": hollow}))
        origin = made.at[3] + [0.0, 0.0, 5.0]
        assert find_clicked(sights(made, None), origin, down, 1e-4)[1] == expected


def test_over_them_the_tracks_are_hollow_and_the_model_in_the_same_room(shown):
    frame, made = shown(is_over=True)
    assert frame.outlined.all()
    assert len(dart_rows(made)) == 0
    assert not offset(made).any()


def test_agents_are_as_large_as_suits_those_seen_at_a_time(shown):
    _, few = shown(usual=30, apart=math.inf)
    _, many = shown(usual=3000, apart=math.inf)
    _, dense = shown(usual=30, apart=0.2)
    assert few.length > many.length
    assert few.length > dense.length


# In the page.


@pytest.fixture
def laboratory(played):
    """A laboratory that plays tracks, paused."""
    made = Laboratory(port=0, opened=StoredTracks(played), running=False)
    until(lambda: made.simulation.frame is not None)
    until(lambda: made.tracks.plain is played)
    yield made
    made.close()


def test_the_page_says_what_is_played_and_saves_no_scene_of_it(laboratory, played):
    until(lambda: "ring.csv" in laboratory.tracks.facts.content)
    assert "12, 12 at a time" in describe_tracks(played)
    assert laboratory.run.speed.value == "25 ticks/s"
    with pytest.raises(InputError, match="a scene holds a model and no tracks"):
        laboratory.now()
    until(lambda: laboratory.tracks.form.visible)
    assert laboratory.setup.model.value in {one.title for one in MODELS.values()}


def test_the_page_starts_a_model_over_the_tracks_and_ends_it(laboratory, played):
    panel, simulation = laboratory.tracks, laboratory.simulation
    seek(simulation, START)
    panel.drawn.value = OVER
    start = ModelStart(Spec("couzin"), START, 10.0, is_over=True)
    laboratory.open_tracks(StoredTracks(played).with_model(start), False)
    until(lambda: simulation.state.models == ("tracks", "couzin"))
    until(lambda: simulation.frame.beside is not None and simulation.frame.is_over, COMPILED)
    until(lambda: panel.stop.visible)
    assert "1 s is 10 ticks (a tick is 0.1 s)" in panel.mapping.content
    until(lambda: laboratory.parameters.beside_controls.keys() >= {"r_r", "dr_o"})
    until(lambda: not laboratory.parameters.beside_controls["r_r"].disabled)
    until(lambda: [chart.names for chart in laboratory.plots.charts][1] == ("divergence",))
    laboratory.open_tracks(StoredTracks(played).without_model(START), False)
    until(lambda: simulation.state.beside is None and simulation.frame.beside is None)
    until(lambda: not panel.stop.visible)


def test_the_page_asks_for_what_a_file_does_not_say(laboratory):
    panel = laboratory.tracks
    panel.refuse("a.npy", b"", "a.npy does not say its rate: give --rate, frames per second")
    assert panel.waiting == ("a.npy", b"")
    assert panel.again.visible
    assert "give Frames per second, frames" in panel.fault.content
    panel.rate.value = 30.0
    assert panel.fields().rate == 30.0
    panel.refuse("b.npy", b"", "b.npy is no file of tracks <b>")
    assert panel.waiting is None
    assert not panel.again.visible
    assert "&lt;b&gt;" in panel.fault.content
