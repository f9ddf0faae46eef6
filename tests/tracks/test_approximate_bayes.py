"""Whole runs beside tracks whose frames are too far apart for a prediction."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.tracks.fit.approximate_bayes import (
    BINS,
    QUANTILES,
    adjusted_draws,
    nearest_draws,
    summarise,
    weighted_quantiles,
)
from app.tracks.fit.fit_api import fit
from tracks.fitted_flocks import mill, vicsek_tracks
from worlds.input_error import InputError

TICKS = 15


def sparse(**parameters):
    """Tracks of which only each 15th tick was seen, by places alone."""
    return vicsek_tracks(frames=15 * 15 + 1, agents=60, side=4.0, **parameters).frames(0, None, 15)


def test_summaries_of_a_flock_that_goes_straight_on():
    rng = np.random.default_rng(1)
    place = rng.uniform(0.0, 10.0, (1, 30, 2)) + np.arange(5.0)[:, None, None] * [0.3, 0.0]
    edges = np.linspace(0.0, 20.0, len(BINS))
    values = summarise(place, np.zeros(2), edges)
    order, spread, way, *alike, turn, nearest = values
    assert (order, spread, way, turn) == pytest.approx((1.0, 0.0, 0.3, 1.0))
    distance = np.linalg.norm(place[0][:, None] - place[0][None], axis=2)
    np.fill_diagonal(distance, np.inf)
    assert nearest == pytest.approx(distance.min(axis=1).mean())
    assert alike[:4] == pytest.approx([1.0] * 4)  # all pairs are nearer than 14.2
    wrapped = summarise(place % 10.0, np.array([10.0, 10.0]), edges)
    assert wrapped[:3] == pytest.approx(values[:3])


def test_regression_brings_draws_to_the_observed_where_summaries_follow_from_them():
    rng = np.random.default_rng(2)
    shares = rng.uniform(0.05, 0.95, (400, 1))
    logits = np.log(shares / (1.0 - shares))
    summaries = logits + 1e-3 * rng.normal(size=logits.shape)
    adjusted, weight = adjusted_draws(summaries, shares, np.array([0.5]))
    truth = 1.0 / (1.0 + np.exp(-0.5))
    low, median, high = weighted_quantiles(adjusted[:, 0], weight, QUANTILES)
    assert low < truth < high
    assert median == pytest.approx(truth, abs=1e-3)
    rows, distance = nearest_draws(summaries, np.array([0.5]))
    assert len(rows) == 100
    assert (np.diff(distance) >= 0.0).all()


def test_a_truth_lies_in_its_interval_and_the_coverage_is_said():
    result = fit(
        sparse(r=1.0, eta=1.0), "vem", ("r=0.2:2.5:2", "eta=0:4:2"), method="abc", ticks=TICKS,
        runs=200, v0=0.1,
    )  # fmt: skip
    (found,) = result.fits
    r, eta = found.posteriors
    assert found.is_like_tracks
    assert r.low < 1.0 < r.high
    assert eta.low < 1.0 < eta.high
    assert eta.is_told
    assert 0.5 <= min(r.coverage, eta.coverage) <= 1.0
    text = " ".join(result.sentences())
    assert "15 ticks are 1 frame (a tick is 1 s)" in text
    assert "runs left out in turn, these intervals of 90 % held the truth in: r " in text


@pytest.mark.exhaustive
def test_a_truth_comes_back_from_many_runs_of_a_flock_in_disorder():
    tracks = vicsek_tracks(frames=301, r=0.6, eta=2.0).frames(0, None, TICKS)
    result = fit(
        tracks, "vem", ("r=0.2:2.5:2", "eta=0:4:2"), method="abc", ticks=TICKS, runs=600, v0=0.1
    )
    r, eta = result.fits[0].posteriors
    assert r.low < 0.6 < r.high
    assert eta.low < 2.0 < eta.high
    assert r.median == pytest.approx(0.6, abs=0.15)
    assert eta.median == pytest.approx(2.0, abs=0.15)
    assert (r.is_told, eta.is_told) == (True, True)
    assert 0.7 <= min(r.coverage, eta.coverage) <= 1.0


def test_tracks_that_no_run_is_like_are_said_to_be_unexplained():
    tracks = mill(frames=31).frames(0, None, 3)
    result = fit(tracks, "vem", ("r=0.2:2.5:2", "eta=0:1:2"), method="abc", ticks=3, runs=60,
                 length=5.0)  # fmt: skip
    (found,) = result.fits
    assert not found.is_like_tracks
    assert found.sentences()[0].startswith("vem explains nothing: none of 60 runs is like these")


def test_what_abc_needs_is_asked_for():
    tracks = sparse(r=1.0, eta=1.0)
    with pytest.raises(InputError, match=r"which parameters of vem\?"):
        fit(tracks, "vem", method="abc", ticks=TICKS)
    with pytest.raises(InputError, match="4 frames to compare: ABC needs 5"):
        fit(tracks.frames(0, 4), "vem", "r", method="abc", ticks=TICKS)
    still = replace(tracks, position=np.repeat(tracks.position[:1], len(tracks.frame), axis=0))
    with pytest.raises(InputError, match="0 individuals move from the first frame"):
        fit(still, "vem", "r", method="abc", ticks=TICKS)
