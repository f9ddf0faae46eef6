"""The model of Gregoire and Chate 2004 against its oracle, in exact cases, and its transition."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from oracles import noise as hashing
from oracles import vicsek1995 as oracle
from oracles.scenes import SEED, apart, contacts_are_clear, scenes
from oracles.topology import contact

from agents import Flock

CLOSE = 1e-9


def flock_of(where, eta):
    """A flock of the model in a scene; its noise is its own."""
    return Flock(
        "gregoire-chate", start=where.start, size=where.size, world=where.edges, rng=SEED,
        r=where.r, v0=where.v0, eta=eta,
    )  # fmt: skip


@settings(max_examples=60, deadline=None, derandomize=True)
@given(where=scenes(dims=(2,), most=40), eta=st.sampled_from((0.0, 0.1, 0.6, 1.0)))
def test_it_is_the_paper_step_by_step(where, eta):
    flock = flock_of(where, eta)
    for _ in range(3):
        before = flock.position.copy(), flock.heading.copy(), flock.informed.astype(bool)
        assume(contacts_are_clear(before[0], where.r, where.size, where.edges))
        push = eta * hashing.directions(SEED, flock.tick, flock.ids)
        touch = contact(before[0], where.r, where.size, where.edges)
        for i in range(len(flock.ids)):
            total, n = oracle.summed(before[1], touch, i)
            assume(np.linalg.norm(total + n * push[i]) > 1e-6)
            assume(np.linalg.norm(total) > 1e-6)
        position, heading = oracle.step_2004(
            *before, where.r, where.v0, where.size, where.edges, push
        )
        flock.step()
        box = np.asarray(where.size) if where.edges != "open" else None
        assert apart(flock.heading, heading) < CLOSE
        assert apart(flock.position, position, box) < CLOSE


def test_its_noise_is_its_own_whatever_the_run_says():
    one, other = (
        Flock("gregoire-chate", agents=40, rng=3, noise=kind) for kind in ("angular", "vectorial")
    )
    plain = Flock("vem", agents=40, rng=3, noise="vectorial", size=one.world.size, eta=0.5, v0=0.5)
    assert one.options.noise == other.options.noise == one.spec.noise == "vectorial"
    for flock in (one, other, plain):
        flock.run(50)
    assert np.array_equal(one.heading, other.heading)
    assert np.array_equal(one.position, plain.position)


def test_one_that_is_alone_turns_to_itself_and_the_noise():
    """arg(u + eta e): with eta = 1 half of the angle between both, for one agent."""
    start = {"position": [[1.0, 1.0]], "heading": [[1.0, 0.0]]}
    flock = Flock("gregoire-chate", start=start, world="open", size=9.0, eta=1.0, rng=5)
    angle = math.atan2(*hashing.directions(5, 0, flock.ids)[0][::-1])
    flock.step()
    assert math.atan2(*flock.heading[0][::-1]) == pytest.approx(angle / 2)
    assert flock.position[0] == pytest.approx([1.0, 1.0] + 0.5 * flock.heading[0])


@pytest.mark.parametrize(("eta", "low", "high"), [(0.4, 0.88, 0.96), (0.8, 0.0, 0.15)])
def test_it_is_ordered_below_its_transition_and_not_above(eta, low, high):
    flock = Flock("gregoire-chate", agents=512, eta=eta, rng=2)
    assert flock.world.size == (16.0, 16.0)
    flock.run(2000)
    assert low < flock.observe("polarisation") < high


def test_its_noise_ends_at_one_for_each_neighbour():
    with pytest.raises(ValueError, match=r"eta = 1.5 is outside \[0, 1\]"):
        Flock("gregoire-chate", agents=5, rng=1, eta=1.5)
