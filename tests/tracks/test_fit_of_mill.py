"""Fits of tracks whose truth is known: what comes back, what is not told, what explains nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.tracks.fit.fit_api import fit
from tracks.fitted_flocks import TAU, mill, mill_places, tracks_of

AROUND = ("dr_o=1:5:5", "dr_a=6:14:5")
WIDE = ("dr_o=0:9:10", "dr_a=2:20:10")
TRUTH = {"dr_o": 3.0, "dr_a": 10.0}


def holds(regions, truth):
    return all(region.low <= truth[region.name] <= region.high for region in regions)


@pytest.fixture(scope="module")
def clean():
    """The fit of a mill without noise of places."""
    return fit(mill(), "couzin", AROUND, shuffles=3, workers=1)


def test_a_mill_comes_back(clean):
    (found,) = clean.fits
    assert found.best == found.second_best == TRUTH
    assert found.explains
    assert found.skill > 0.6
    assert [region.describe() for region in found.first.regions] == ["dr_o 3", "dr_a 10"]
    text = " ".join(clean.sentences())
    assert "Of what can be foretold beyond keeping the heading, couzin explains" in text
    assert "dr_o 3; dr_a 10 (best dr_o 3, dr_a 10; window 0.6 s; with 1 s the best is" in text
    assert "1 tick is 1 frame (a tick is 0.1 s); 1 length is 1 m; the world is open" in text
    assert "tau = 0.1 s, the time of a tick" in text
    assert "sigma = 0: a prediction has no noise" in text


def test_the_null_and_the_shuffled_stand_beside_on_frames_held_back(clean):
    (found,) = clean.fits
    assert not set(clean.fitted_frames) & set(clean.held_back_frames)
    assert [row["rule"] for row in clean.table()] == ["keeps its heading", "couzin"]
    assert len(found.shuffled_skills) == 3
    assert max(found.shuffled_skills) < 0.1 < found.skill
    assert found.gain[0] > 0.0
    assert found.cost == pytest.approx(found.null_cost * (1.0 - found.skill))


def test_it_comes_back_under_noise_once_places_are_smoothed():
    found = fit(mill(0.2), "couzin", AROUND, shuffles=2, workers=1)
    (model,) = found.fits
    assert model.best == TRUTH
    assert model.explains
    assert found.noise_share == pytest.approx(0.2, rel=0.05)
    assert "Places are noisy by 20 % of the way of a tick" in " ".join(found.sentences())


@pytest.mark.exhaustive
@pytest.mark.parametrize("noise", [0.0, 0.1, 0.2, 0.5])
@pytest.mark.parametrize("seed", [5, 6, 7])
def test_the_truth_is_in_the_region_whatever_the_noise(noise, seed):
    (found,) = fit(mill(noise, noise_seed=seed), "couzin", WIDE, shuffles=2, workers=1).fits
    assert found.explains
    assert not found.has_moved
    assert found.best["dr_o"] == 3.0
    assert abs(found.best["dr_a"] - 10.0) <= 2.0  # a step of the grid
    assert holds(found.first.regions, TRUTH)
    if noise <= 0.1:
        assert found.best == TRUTH
        assert all(region.is_told for region in found.first.regions)


@pytest.mark.exhaustive
def test_the_region_holds_synthetic_truths_as_often_as_it_says():
    held = [
        holds(fit(mill(0.2, seed=seed, dr_o=truth["dr_o"], dr_a=truth["dr_a"]), "couzin", WIDE,
                  shuffles=1, workers=1).fits[0].first.regions, truth)
        for seed in (2, 3, 4, 5, 6)
        for truth in (TRUTH, {"dr_o": 2.0, "dr_a": 8.0})
    ]  # fmt: skip
    assert np.mean(held) >= 0.8  # 95 % is meant; of 10


@pytest.mark.exhaustive
def test_without_smoothing_noise_leads_astray_and_nothing_is_told():
    bests = []
    for seed in (5, 6, 7):
        tracks = mill(0.2, noise_seed=seed)
        (found,) = fit(
            tracks, "couzin", WIDE, window=0.0, second_window=0.6, shuffles=2, workers=1
        ).fits
        bests.append(found.best)
        assert not any(region.is_told for region in found.first.regions) or found.has_moved
        assert found.skill < 0.05
    assert TRUTH not in bests


def test_a_best_that_moves_with_the_window_has_no_region(clean):
    (found,) = clean.fits
    moved = replace(found, has_moved=True).sentences()
    assert moved[-1].startswith("No region: with a window of 0.6 s the best is dr_o 3, dr_a 10, ")
    assert "the answer hangs on the smoothing" in moved[-1]
    assert "dr_o 3; dr_a 10" not in " ".join(moved)


@pytest.fixture(scope="module")
def school():
    """A school that goes straight on: zones (9, 10), with the headings that they took."""
    place = mill_places(dr_o=9.0)
    step = np.diff(place, axis=0)
    heading = np.full(place.shape, np.nan)
    heading[1:] = step / np.linalg.norm(step, axis=2, keepdims=True)
    return tracks_of(place, TAU, "school", heading=heading)


def test_in_a_polarised_school_attraction_is_not_told(school):
    (found,) = fit(school, "couzin", ("dr_o=7:11:3", "dr_a=2:16:8"), use_file_headings=True,
                   shuffles=2, workers=1).fits  # fmt: skip
    (dr_a,) = [region for region in found.first.regions if region.name == "dr_a"]
    assert not dr_a.is_told
    assert dr_a.high - dr_a.low >= 6.0


def test_in_a_polarised_school_the_true_model_loses_to_keeping_the_heading(school):
    result = fit(school, "couzin", ("dr_o=7:11:3", "dr_a=6:14:3"), shuffles=2, workers=1)
    (found,) = result.fits
    assert not found.explains
    (sentence,) = found.sentences()
    assert sentence.startswith("couzin explains nothing: ")
    assert "dr_a 1" not in sentence


def test_a_model_that_foretells_as_much_of_shuffled_headings_explains_nothing(clean):
    (found,) = clean.fits
    alike = replace(found, shuffled_skills=(found.skill + 0.01,))
    assert not alike.explains
    (sentence,) = alike.sentences()
    assert "with headings shuffled in time it foretells as much" in sentence
    assert "nothing is told of its parameters" in sentence


def test_several_models_compete_on_the_same_frames_held_back():
    result = fit(mill(0.1), ["couzin", "vem"], ("dr_o=2:4:3", "r=0.5:4.5:5"), shuffles=2, workers=1)
    couzin, vem = result.fits
    assert result.best is couzin
    assert couzin.null_cost == vem.null_cost
    assert (couzin.explains, vem.explains) == (True, False)
    assert [row["rule"] for row in result.table()] == ["keeps its heading", "couzin", "vem"]
    assert "On frames held back couzin foretells most." in result.sentences()
    assert any(line.startswith("vem explains nothing") for line in result.sentences())


def test_where_the_world_wraps_neighbours_are_seen_across_the_seam():
    place, side = mill_places(), 80.0
    place = place - place.mean(axis=(0, 1))  # the seam goes through the middle of the mill
    assert np.ptp(place, axis=(0, 1)).max() < side / 2
    (whole,) = fit(tracks_of(place, TAU), "couzin", "dr_o=2:4:3", shuffles=1, workers=1).fits
    split = tracks_of(place % side, TAU, period=(side, side))
    result = fit(split, "couzin", "dr_o=2:4:3", shuffles=1, workers=1)
    assert "the world wraps, 80 x 80 m" in result.scale
    assert result.fits[0].first.costs == pytest.approx(whole.first.costs, rel=1e-6)


def test_units_and_ticks_follow_from_what_is_said_and_not_from_the_file():
    place = mill_places()
    (metres,) = fit(tracks_of(place, TAU), "couzin", "dr_o=2:4:3", shuffles=1, workers=1).fits
    in_cm = tracks_of(100.0 * place, TAU, unit="cm")
    (centimetres,) = fit(in_cm, "couzin", "dr_o=2:4:3", shuffles=1, workers=1).fits
    in_px = tracks_of(40.0 * place, TAU, unit="px")
    pixels = fit(in_px, "couzin", "dr_o=2:4:3", length=40.0, shuffles=1, workers=1)
    assert centimetres.first.costs == pytest.approx(metres.first.costs, rel=1e-6)
    assert pixels.fits[0].first.costs == pytest.approx(metres.first.costs, rel=1e-6)
    assert "1 length is 40 px" in pixels.scale
    every = fit(tracks_of(place, 0.5 * TAU), "couzin", "dr_o=2:4:3", every=2, shuffles=1,
                workers=1)  # fmt: skip
    assert "1 tick is 2 frames (a tick is 0.1 s)" in every.scale
    assert every.fits[0].fixed["tau"] == pytest.approx(0.1)


@pytest.mark.exhaustive
def test_synthetic_truths_say_up_to_which_noise_a_fit_can_be_believed():
    result = fit(mill(0.1), "couzin", AROUND, shuffles=1, synthetic=1, workers=1)
    (check,) = result.checks
    assert dict(check.truth) == TRUTH
    assert [noise.noise for noise in check.noises] == [0.0, 0.1, 0.2, 0.5, 1.0]
    assert all(noise.found == 1 for noise in check.noises[:3])
    assert "Runs of couzin with dr_o 3, dr_a 10, fitted in the same way" in result.sentences()[-1]


def test_walls_of_the_file_are_in_the_world():
    tracks = replace(
        mill(), boundary="POLYGON ((-200 -200, 200 -200, 200 200, -200 200, -200 -200))"
    )
    result = fit(tracks, "couzin", "dr_o=2:4:3", shuffles=1, workers=1)
    assert "with the walls of the file" in result.scale
    assert result.fits[0].best == {"dr_o": 3.0}
