"""Who is who at the start: identities say nothing of places."""

import numpy as np
import pytest

from agents import Flock

STARTS = {
    "a box": ("hwvem", {"agents": 2000, "informed": 3}),
    "space": ("vem", {"agents": 2000, "dim": 3}),
    "a mission": ("hwvem-nav", {"agents": 400, "world": "liu2021-mission"}),
    "a goal": ("boundary-points", {"agents": 60, "world": "wu2023-multi"}),
}


@pytest.mark.parametrize("start", STARTS)
def test_an_identity_says_nothing_of_a_place_or_a_heading(start):
    """Correlations are normal with a deviation of 1 / sqrt(N); none is as far as 4.5 of them."""
    model, given = STARTS[start]
    for seed in (1, 2):
        flock = Flock(model, rng=seed, **given)
        known = int(flock.informed.sum())
        assert sorted(flock.ids.tolist()) == list(range(1, len(flock.ids) + 1))
        columns = np.column_stack([flock.position, flock.heading])[known:]
        each = np.corrcoef(flock.ids[known:], columns, rowvar=False)[0, 1:]
        assert np.abs(each).max() < 4.5 / np.sqrt(len(columns))


def test_information_agents_have_the_first_identities_and_stand_where_the_paper_has_them():
    flock = Flock("hwvem", agents=100, informed=2, rng=3)
    assert flock.informed.tolist() == [True, True] + [False] * 100
    assert flock.ids[:2].tolist() == [1, 2]
    assert flock.position[0].tolist() == [0.0, 0.0]
    assert np.arctan2(*flock.heading[0, ::-1]) == pytest.approx(np.pi / 4)


def test_agents_come_by_identity_and_the_first_of_them_are_no_corner():
    flock = Flock("vem", agents=1000, rng=4)
    assert [agent.unique_id for agent in flock.agents[:10]] == list(range(1, 11))
    place = np.array([agent.position for agent in flock.agents[:100]]) / flock.world.size
    halves = np.histogram2d(*place.T, bins=2, range=[[0, 1], [0, 1]])[0]
    assert halves.min() > 10


def test_one_by_one_they_act_by_identity():
    flock = Flock("vem", agents=50, rng=5, activation="sequential")
    order = flock.engine.order(0)
    assert flock.ids[order].tolist() == list(range(1, 51))
    assert order.tolist() != list(range(50))


def test_a_given_start_has_its_identities_by_row():
    start = {"position": np.random.default_rng(6).uniform(0, 5, (9, 2)), "heading": np.ones((9, 2))}
    assert Flock("vem", start=start, size=5.0, rng=1).ids.tolist() == list(range(1, 10))
