"""The model of Vicsek et al. 1995 against its oracle, in exact cases, and its order in short."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import noise as hashing
from oracles import vicsek1995 as oracle
from oracles.flocks import angles_of, at_rest, build
from oracles.scenes import SEED, apart, contacts_are_clear, scenes
from oracles.topology import contact

from agents import Flock

CLOSE = 1e-9


def clear_rows(flock, where, push=0.0):
    """Agents whose mean heading is long enough to have a direction, (N,) bool."""
    touch = contact(flock.position, where.r, where.size, where.edges)
    found = []
    for i in range(len(flock.ids)):
        total, n = oracle.summed(flock.heading, touch, i)
        total = total + (n * push[i] if np.ndim(push) else 0.0)
        found.append(np.linalg.norm(total) > 1e-6)
    return np.array(found) | flock.informed.astype(bool)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(where=scenes(most=40), eta=st.sampled_from((0.0, 0.0, 0.4, math.tau)))
def test_it_is_the_paper_step_by_step(where, eta):
    eta = eta if where.dim == 2 else 0.0
    flock = build("vicsek1995", where, eta=eta)
    for _ in range(3):
        before = flock.position.copy(), flock.heading.copy(), flock.informed.astype(bool)
        assume(contacts_are_clear(before[0], where.r, where.size, where.edges))
        clear = clear_rows(flock, where)
        turn = hashing.turns(SEED, flock.tick, flock.ids, eta) if eta else None
        position, heading = oracle.step_1995(
            *before, where.r, where.v0, where.size, where.edges, turn
        )
        flock.step()
        box = np.asarray(where.size) if where.edges != "open" else None
        assert apart(flock.position, position, box) < CLOSE
        assert not clear.any() or apart(flock.heading[clear], heading[clear]) < CLOSE


@pytest.mark.parametrize("activation", ["synchronous", "sequential"])
def test_it_goes_on_along_the_old_heading_and_then_turns(activation):
    start = {"position": [[1.0, 1.0], [1.5, 1.0]], "heading": [[1.0, 0.0], [0.0, 1.0]]}
    flock = Flock("vicsek1995", start=start, size=10.0, v0=0.5, rng=1, activation=activation)
    flock.step()
    assert flock.position == pytest.approx(np.array([[1.5, 1.0], [1.5, 1.5]]))
    assert angles_of(flock)[0] == pytest.approx(math.pi / 4)
    forward = Flock("vem", start=start, size=10.0, v0=0.5, rng=1, activation=activation)
    forward.step()
    assert forward.heading[0] == pytest.approx(flock.heading[0])
    assert forward.position[0] == pytest.approx([1.0 + 0.5 / 2**0.5, 1.0 + 0.5 / 2**0.5])


def test_its_turns_are_those_of_the_rule_that_moves_along_the_new_heading():
    """At rest the order of moving and turning makes no difference, to the bit."""
    angles = [0.1, 2.0, 4.5, 0.7]
    places = [[0, 0], [0.5, 0], [0.2, 0.3], [2.0, 2.0]]
    made = [at_rest(one, places, angles, v0=0.0, eta=1.0, rng=5) for one in ("vicsek1995", "vem")]
    for flock in made:
        flock.run(20)
    assert np.array_equal(made[0].heading, made[1].heading)


def test_it_is_at_home_at_the_density_of_the_paper():
    flock = Flock("vicsek1995", rng=1)
    assert (len(flock.ids), flock.world.size) == (400, (10.0, 10.0))
    assert Flock("vicsek1995", agents=100, rng=1).world.size == (5.0, 5.0)
    assert Flock("vem", agents=100, rng=1).world.size[0] == pytest.approx((100 / 4.102) ** 0.5)


def test_it_is_ordered_at_little_noise_and_not_at_much():
    """Figure 2 (a), N = 100: nearly 1 without noise, some tenths at eta = 5."""
    order = {}
    for eta in (0.0, 2.0, 5.0):
        flock = Flock("vicsek1995", agents=100, eta=eta, rng=3)
        flock.run(500)
        seen = []
        for _ in range(50):
            flock.run(10)
            seen.append(flock.observe("polarisation"))
        order[eta] = float(np.mean(seen))
    assert order[0.0] > 0.98 > 0.95 > order[2.0] > 0.6 > 0.35 > order[5.0]
