"""Check agents that people steer by hand: who may, until when, and what that wishes."""

from __future__ import annotations

import numpy as np
import pytest

from agents.flock import Flock
from agents.kinds import Kind
from agents.spec import Spec
from app.steering.hand_pilot import MOST_HANDS, SILENCE, HandMotion, HandPilot, ways_of
from worlds.input_error import InputError

MINE, OTHER = "a" * 32, "b" * 32
LEFT = HandMotion(turn=1.0)


class Clock:
    """A clock that only a test moves."""

    now = 100.0

    def __call__(self):
        return self.now


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def hands(clock):
    return HandPilot(clock)


def robots(model="vem", **options):
    """A flock with two robots, 21 and 22, without noise where it has any."""
    kinds = [Kind("robot", 2, steered=True)]
    return Flock(Spec(model, agents=20, seed=2, kinds=kinds, **options))


def with_hands(flock, hands):
    flock.pilots = (hands,)
    return flock


def heading_of(flock, agent):
    return flock.heading[np.flatnonzero(flock.ids == agent)[0]].copy()


def turned_left(before, after):
    """By how much, degrees."""
    return np.degrees(np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after))


def test_a_hand_turns_its_agent_and_nobody_else(hands):
    flock = with_hands(robots(parameters={"eta": 0.0}), hands)
    hands.hold(MINE, 21, LEFT, 1)
    free = robots(parameters={"eta": 0.0})
    before = heading_of(flock, 21)
    flock.run(1)
    free.run(1)
    assert turned_left(before, heading_of(flock, 21)) == pytest.approx(9.0)
    assert np.array_equal(heading_of(flock, 22), heading_of(free, 22))
    hands.hold(MINE, 21, HandMotion(), 2)
    before = heading_of(flock, 21)
    flock.run(3)
    assert np.allclose(heading_of(flock, 21), before)  # a hand at rest goes on as it goes


def test_a_second_of_silence_gives_the_agent_back_to_its_rule(hands, clock):
    flock = with_hands(robots(parameters={"eta": 0.0}), hands)
    hands.hold(MINE, 21, LEFT, 1)
    flock.run(1)
    clock.now += SILENCE
    assert hands.steered == {21}
    clock.now += 0.01
    assert hands.steered == frozenset()
    assert hands.is_active  # its rule has yet to be told
    flock.run(1)
    assert np.isnan(flock.arrays.wish).all()
    assert not hands.is_active
    assert not flock.is_flown


def test_a_flock_notices_silence_by_itself(hands, clock):
    flock = with_hands(robots(), hands)
    hands.hold(MINE, 21, LEFT, 1)
    clock.now += SILENCE + 0.01
    flock.run(1)
    assert np.isnan(flock.arrays.wish).all()


def test_one_person_steers_an_agent_and_one_agent_is_steered_by_a_person(hands, clock):
    hands.hold(MINE, 21, LEFT, 1)
    with pytest.raises(InputError, match="somebody else steers agent 21"):
        hands.hold(OTHER, 21, LEFT, 1)
    hands.hold(MINE, 22, LEFT, 2)
    assert hands.steered == {22}
    hands.hold(OTHER, 21, LEFT, 1)
    assert hands.steered == {21, 22}
    clock.now += SILENCE + 0.01
    hands.hold(OTHER, 22, LEFT, 2)  # who is silent holds nothing
    assert hands.steered == {22}


def test_what_comes_late_counts_no_more(hands):
    flock = with_hands(robots(parameters={"eta": 0.0}), hands)
    hands.hold(MINE, 21, HandMotion(), 5)
    hands.hold(MINE, 21, LEFT, 4)
    before = heading_of(flock, 21)
    flock.run(1)
    assert np.allclose(heading_of(flock, 21), before)
    hands.let_go(MINE, 7)
    hands.hold(MINE, 21, LEFT, 6)
    assert hands.steered == frozenset()
    hands.hold(MINE, 21, LEFT, 8)
    assert hands.steered == {21}


def test_so_many_people_and_no_more(hands):
    for number in range(MOST_HANDS):
        hands.hold(f"{number:032x}", number, LEFT, 1)
    with pytest.raises(InputError, match="32 people steer already"):
        hands.hold(OTHER, MOST_HANDS, LEFT, 1)


def test_an_agent_that_is_gone_is_let_go(hands):
    flock = with_hands(robots(), hands)
    hands.hold(MINE, 999, LEFT, 1)
    flock.run(1)
    assert hands.steered == frozenset()


def test_another_run_has_nobody_at_its_agents(hands):
    hands.hold(MINE, 21, LEFT, 1)
    hands.begin()
    assert not hands.is_active


def test_a_hand_climbs_in_space_within_what_the_body_can(hands):
    flock = with_hands(robots("couzin", parameters={"sigma": 0.0}), hands)
    agent = int(flock.ids[flock.rows_of("robot")[0]])
    hands.hold(MINE, agent, HandMotion(climb=1.0), 1)
    before = heading_of(flock, agent)
    flock.run(1)
    after = heading_of(flock, agent)
    turned = np.degrees(np.arccos(np.clip(before @ after, -1.0, 1.0)))
    assert after[2] > before[2]
    assert turned == pytest.approx(min(9.0, flock.parameters.theta * flock.parameters.tau))


def test_a_hand_pushes_where_a_rule_wishes_an_acceleration(hands):
    flock = with_hands(robots("dorsogna"), hands)
    agent = int(flock.ids[flock.rows_of("robot")[0]])
    row = np.flatnonzero(flock.ids == agent)[0]
    hands.hold(MINE, agent, HandMotion(push=1.0), 1)
    before = flock.speed[row]
    flock.run(5)
    assert flock.speed[np.flatnonzero(flock.ids == agent)[0]] > 1.5 * before
    assert ways_of("acceleration", 2) == ("turn", "push")
    assert ways_of("heading", 3) == ("turn", "climb")
