"""What cannot be fitted is refused in one line: the thing, its value, what is allowed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.tracks.fit.fit_api import fit
from app.tracks.fit.fit_request import FitRequest
from app.tracks.fit.tick_scale import scaled_model, tick_scale
from tracks.fitted_flocks import TAU, mill, mill_places, tracks_of
from worlds.input_error import InputError


def refused(tracks, model="couzin", parameters="dr_o=2:4:3", **more):
    with pytest.raises(InputError) as refusal:
        fit(tracks, model, parameters, **more)
    text = str(refusal.value)
    assert "\n" not in text
    return text


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ({"model": "cousin"}, "unknown model 'cousin': did you mean 'couzin'?"),
        ({"model": ()}, "which model?"),
        ({"model": ("vem", "vem")}, "model 'vem' is given twice"),
        ({"parameters": "dr_oo"}, "unknown parameter 'dr_oo': did you mean 'dr_o'?"),
        ({"parameters": "sigma"}, "sigma of couzin is noise, and one-step prediction has none"),
        ({"parameters": "tau"}, "tau of couzin is the time of a tick, which is that of the tracks"),
        ({"tau": 0.2}, "tau of couzin is the time of a tick, which is that of the tracks"),
        ({"sigma": 0.1}, "sigma = 0.1 is not allowed: it is noise"),
        ({"dr_o": 3.0}, "dr_o is fitted and set"),
        ({"alphas": 3.0}, "unknown parameter 'alphas': did you mean 'alpha'?"),
        ({"alpha": 400.0}, "alpha = 400.0 deg is outside [0, 360] deg"),
        ({"method": "guess"}, "unknown method 'guess'"),
        ({"window": -1.0}, "window = -1 s is not allowed"),
        ({"window": 0.6, "second_window": 0.62}, "windows of 0.6 s and 0.62 s are the same"),
        ({"frames": 3}, "frames = 3 is outside [10, 10000]"),
        ({"shuffles": 0}, "shuffles = 0 is outside [1, 1000]"),
        ({"every": 0}, "frames of a tick = 0 is not allowed"),
        ({"length": 0.0}, "length = 0 m is not allowed: a number > 0"),
        ({"length": float("nan")}, "length = nan m is not allowed"),
        ({"ticks": 3}, "with several ticks in a frame take --method abc"),
        ({"every": 2, "ticks": 3}, "2 frames of a tick and 3 ticks of a frame exclude each other"),
        ({"every": 20}, r"tau = 2 is outside [0.01, 1] s of couzin: it is a tick, see --tick-"),
        ({"length": 0.01}, "s = "),
        ({"synthetic": 1, "method": "likelihood", "model": "vem", "parameters": "r"},
         "synthetic truths are of one-step prediction"),
    ],
)  # fmt: skip
def test_what_cannot_be_fitted_is_refused(more, says):
    assert says in refused(mill(frames=120), **more)


def test_tracks_that_tell_nothing_are_refused():
    tracks = mill(frames=120)
    assert refused(tracks.individuals([0])) == "mill has 1 individual: a fit needs 2 or more"
    assert refused(tracks.frames(0, 1)).startswith("mill has 1 frame")
    assert "a fit needs 10 in each half of the time" in refused(tracks.frames(0, 24))
    assert "nobody is seen for 11 frames without a gap" in refused(tracks.frames(0, 5))
    in_pixels = replace(tracks, unit="px")
    assert "mill is in pixels: give --scale, metres in a pixel, or --length" in refused(in_pixels)
    uneven = replace(tracks, time=np.cumsum(np.random.default_rng(1).uniform(0.05, 0.2, 120)))
    assert "a fit needs frames at an even rate" in refused(uneven)


def test_dimensions_have_to_fit():
    place = np.random.default_rng(1).normal(size=(60, 5, 3)).cumsum(axis=0)
    assert "run is 3-D, but ivem is defined in 2-D" in refused(tracks_of(place), "ivem", "r")


def test_one_frame_of_a_hole_does_not_spoil_the_rest():
    tracks = mill(frames=160)
    time = tracks.time.copy()
    time[80:] += 5.0
    result = fit(replace(tracks, time=time), "couzin", "dr_o=2:4:3", shuffles=1, workers=1)
    assert result.fits[0].best == {"dr_o": 3.0}
    assert not {77, 78, 79, 80, 81, 82} & {*result.fitted_frames, *result.held_back_frames}


def test_speed_and_tick_are_set_by_their_own_names_in_each_model():
    scale = tick_scale(tracks_of(mill_places(frames=60), TAU))
    vem = scaled_model("vem", scale, 3.0, {})
    assert vem.fixed == pytest.approx({"v0": 0.3})
    assert vem.time_unit == pytest.approx(TAU)
    couzin = scaled_model("couzin", scale, 3.0, {"s": 2.0})
    assert couzin.fixed == pytest.approx({"tau": 0.1, "sigma": 0.0, "s": 2.0})
    assert "median speed" not in " ".join(couzin.notes)
    reynolds = scaled_model("reynolds", scale, 3.0, {})
    assert reynolds.fixed == pytest.approx({"dt": 0.1})


def test_windows_are_said_in_seconds_and_differ():
    first, second = FitRequest(("couzin",)).windows(0.1)
    assert (first, second) == pytest.approx((0.6, 1.0))
    assert FitRequest(("couzin",), window=0.3).windows(0.1) == pytest.approx((0.3, 0.7))
