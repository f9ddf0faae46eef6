"""The likelihood of the Vicsek family: truths come back, and what spoils them is said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.tracks.fit.fit_api import fit
from app.tracks.fit.vicsek_likelihood import moves_along_old_heading
from tracks.fitted_flocks import mill, tracks_of, vicsek_run, vicsek_tracks
from worlds.input_error import InputError

RANGE = "r=0.2:2.5:24"


def found_of(tracks, model="vem", **more):
    return fit(tracks, model, RANGE, method="likelihood", shuffles=1, workers=1, **more).fits[0]


@pytest.mark.parametrize(
    ("model", "r", "eta", "with_headings"),
    [
        ("vem", 1.0, 0.8, True),
        pytest.param("vem", 1.5, 2.0, False, marks=pytest.mark.exhaustive),
        ("vicsek1995", 0.7, 1.2, False),
        pytest.param("vicsek1995", 1.0, 3.0, True, marks=pytest.mark.exhaustive),
        pytest.param("vem", 0.45, 1.6, False, marks=pytest.mark.exhaustive),
    ],
)
def test_r_comes_back_within_a_hundredth_and_eta_within_half_a_percent(
    model, r, eta, with_headings
):
    found = found_of(vicsek_tracks(model, with_headings, r=r, eta=eta), model)
    assert abs(found.best["r"] - r) <= 0.0101
    assert found.eta == pytest.approx(eta, rel=0.005)
    assert found.eta_interval[0] <= found.eta <= found.eta_interval[1]
    (region,) = found.regions
    assert region.low <= r <= region.high
    assert region.is_told
    assert found.explains
    assert found.outside == 0.0


def test_who_is_not_seen_is_not_heard_so_eta_is_a_little_larger():
    place, heading = vicsek_run(r=1.0, eta=1.5, frames=200)
    lost = np.random.default_rng(1).random(place.shape[:2]) < 0.1
    tracks = tracks_of(
        np.where(lost[..., None], np.nan, place),
        period=(7.0, 7.0),
        heading=np.where(lost[..., None], np.nan, heading),
    )
    found = found_of(tracks)
    assert found.best["r"] == pytest.approx(1.0, abs=0.0101)
    assert 1.5 < found.eta < 1.53


def test_noise_of_places_makes_eta_larger_and_residuals_leave_its_interval():
    place, _ = vicsek_run(r=1.0, eta=1.0, frames=120)
    noisy = place + 0.5 * 0.1 * np.random.default_rng(2).normal(size=place.shape)
    found = found_of(tracks_of(noisy % 7.0, period=(7.0, 7.0)))
    assert found.eta > 1.5
    assert found.outside > 0.01
    assert any("the noise is not, or not only, that of the rule" in s for s in found.sentences())


def test_a_mill_is_not_explained_by_the_mean_heading():
    found = found_of(mill())
    assert not found.explains
    assert found.sentences()[0].startswith("vem explains nothing: on frames it has not seen")


def test_who_moves_along_which_heading_is_found_by_running_it():
    assert moves_along_old_heading("vicsek1995")
    assert not moves_along_old_heading("vem")
    assert not moves_along_old_heading("topological")


def test_r_is_the_parameter_unless_others_are_asked_for():
    tracks = vicsek_tracks(r=1.0, eta=0.8, frames=60)
    (found,) = fit(tracks, "vem", "eta", method="likelihood", shuffles=1, workers=1).fits
    assert list(found.best) == ["r"]


@pytest.mark.parametrize(
    ("change", "model", "parameters", "says"),
    [
        ({}, "couzin", "dr_o", "couzin is not of the Vicsek family: it has no eta"),
        ({}, "vem", "eta=0:1:3", "eta has no range here"),
        ({"dim": 3}, "vem", "r", "run is 3-D: the likelihood is that of the plane"),
    ],
)
def test_what_has_no_such_likelihood_is_refused(change, model, parameters, says):
    tracks = vicsek_tracks(r=1.0, eta=0.8, frames=60)
    if change:
        tracks = tracks_of(np.zeros((40, 5, 3)) + np.arange(40.0)[:, None, None])
    with pytest.raises(InputError) as refusal:
        fit(tracks, model, parameters, method="likelihood")
    assert says in str(refusal.value)


def test_headings_of_the_file_win_over_steps():
    tracks = vicsek_tracks(r=1.0, eta=0.8, frames=60, with_headings=True)
    turned = replace(tracks, heading=-tracks.heading)  # backwards, all of them: the rule is as true
    assert found_of(turned).eta == pytest.approx(found_of(tracks).eta, rel=1e-9)
