"""Fits in the page: a process that tells how far it is, the map of costs, and what is begun."""

from __future__ import annotations

import re

import numpy as np
import pytest

from agents.flock import Flock
from app.tracks.fit.fit_request import FitRequest
from app.tracks.playing.played_tracks import PlayedTracks
from app.tracks.tracks import Tracks
from app.viewer.lab.fits.cost_map import cost_map, outline, places
from app.viewer.lab.fits.fit_worker import TracksFit, fit_folder
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.panels.fit_panel import describe_progress, describe_result, fitted_start
from app.viewer.run.stored_tracks import StoredTracks
from tests.viewer.waiting import COMPILED, until
from worlds.input_error import InputError

PARAMETERS = ("dr_o=1:5:3", "dr_a=6:14:3")


@pytest.fixture(scope="module")
def mill():
    """Tracks of Couzin's zones, dr_o 3 and dr_a 10, without noise."""
    flock = Flock("couzin", agents=40, dim=2, world="open", rng=3, dr_o=3, dr_a=10, sigma=0.0)
    flock.run(300)
    places = []
    for _ in range(90):
        places.append(flock.position.copy())
        flock.run(1)
    time = 0.1 * np.arange(90)
    return Tracks(np.array(places), np.arange(90), time, tuple(map(str, range(40))), "m", name="m")


def request(parameters: tuple[str, ...]) -> FitRequest:
    return FitRequest(models=("couzin",), parameters=parameters, length=1.0, shuffles=1)


@pytest.fixture(scope="module")
def fitted(mill, tmp_path_factory):
    """A fit that is done, and how often it said how far it is."""
    said = []
    fit = TracksFit(tmp_path_factory.mktemp("fits"), lambda: said.append(1))
    fit.begin(mill, request(PARAMETERS))
    with pytest.raises(InputError, match="one fit at a time"):
        fit.begin(mill, request(PARAMETERS))
    assert "preparing" in describe_progress(fit.state)
    until(lambda: not fit.state.running, COMPILED)
    yield fit
    fit.close()


def test_a_fit_runs_aside_and_finds_what_made_the_tracks(fitted):
    state = fitted.state
    assert state.refusal == ""
    assert state.share == 1.0
    assert state.result.fits[0].best == {"dr_o": 3.0, "dr_a": 10.0}
    text = describe_result(state)
    assert "couzin explains" in text
    assert text.index("couzin explains") < text.index("1 tick is 1 frame")  # the verdict first


def test_a_map_has_a_cell_for_each_pair_and_the_best_marked(fitted):
    fit = fitted.state.result.fits[0]
    drawn = cost_map(fit)
    assert drawn.count("<title>") == 9
    assert "dr_o 3, dr_a 10: cost" in drawn
    (x, y) = map(float, re.search(r'<circle cx="([\d.]+)" cy="([\d.]+)"', drawn).groups())
    assert x == pytest.approx(0.5 * (44 + 280 - 8), abs=0.1)  # the middle of three by three
    assert y == pytest.approx(0.5 * (8 + 220 - 36), abs=0.1)


def test_the_outline_of_a_region_is_where_it_ends():
    inside = np.array([[True, True], [False, False]])
    first = outline(inside, 0, 0, 0.0, 1.0, 1.0, 1.0)
    assert sorted(first) == ["M0.0 1.0L0.0 2.0", "M0.0 2.0L1.0 2.0", "M1.0 1.0L1.0 2.0"]


def test_values_evenly_apart_by_logarithms_are_drawn_so():
    assert places(np.array([1.0, 10.0, 100.0]), 0.0, 2.0) == pytest.approx([0.0, 1.0, 2.0])
    assert places(np.array([0.0, 1.0, 4.0]), 0.0, 4.0) == pytest.approx([0.0, 1.0, 4.0])


def test_the_fitted_model_starts_in_the_tracks_with_its_best_values(fitted, mill):
    state = fitted.state
    with pytest.raises(InputError, match="other tracks are played by now"):
        fitted_start(state, PlayedTracks(mill.frames(0, 50)), 5)
    stored = fitted_start(state, PlayedTracks(mill), 5)
    assert stored.start.spec.parameters["dr_o"] == 3.0
    assert stored.start.ticks_per_second == pytest.approx(10.0)
    assert stored.start.is_over
    flock = stored.model_flock()
    assert flock.parameters.sigma == 0.0
    assert flock.tick == 5


def test_a_fit_of_one_parameter_is_a_curve_and_refusals_are_one_line(mill, tmp_path):
    fit = TracksFit(tmp_path, lambda: None)
    fit.begin(mill, request(("dr_o=1:5:3",)))
    until(lambda: not fit.state.running, COMPILED)
    assert "<polyline" in cost_map(fit.state.result.fits[0])
    fit.begin(mill.frames(0, 4), request(("dr_o=1:5:3",)))
    until(lambda: not fit.state.running, COMPILED)
    assert fit.state.result is None
    assert fit.state.refusal
    assert "\n" not in fit.state.refusal
    assert "No fit." in describe_progress(fit.state)


def test_a_fit_that_is_stopped_goes_on_in_its_folder(mill, tmp_path):
    fit = TracksFit(tmp_path, lambda: None)
    wanted = request(("dr_o=0:10:41", "dr_a=0:20:21"))
    fit.begin(mill, wanted)
    until(lambda: fit.state.share > 0.0, COMPILED)
    fit.stop()
    until(lambda: not fit.state.running)
    assert "goes on where it was" in fit.state.refusal
    assert fit_folder(tmp_path, mill, wanted).is_dir()
    assert fit_folder(tmp_path, mill.frames(1), wanted) != fit_folder(tmp_path, mill, wanted)


def test_the_tab_asks_for_tracks_then_offers_what_can_be_fitted(mill, tmp_path):
    made = Laboratory(port=0, running=False, results=tmp_path)
    try:
        panel = made.fit_panel
        until(lambda: made.simulation.frame is not None)
        with pytest.raises(InputError, match="Open tracks first"):
            panel.request()
        assert {panel.names[one.value] for one in (panel.first, panel.second)} == {"dr_o", "dr_a"}
        made.open_tracks(StoredTracks(PlayedTracks(mill)), True)
        until(lambda: made.tracks.plain is not None)
        tracks, asked = panel.request()
        assert tracks is mill
        assert asked.parameters == ("dr_o", "dr_a")
        assert asked.length == 1.0
    finally:
        made.close()
