"""What agents know of others is old, inexact, or never comes: against naive histories."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import messages
from oracles.flocks import build, parameters
from oracles.following import Clear, compare, demand_clear_contacts, noise_of, state_of
from oracles.scenes import scene
from oracles.topology import EDGES

from agents import Flock, Member
from agents.bodies import point_mass
from agents.catalogue import MODELS
from agents.engine.block import Decision
from agents.engine.message_past import place_error
from agents.models.declare import Parameters, Rule, parameter
from agents.models.model import Model
from agents.spec import Spec
from worlds.compilation import compiled
from worlds.input_error import InputError

LATE = ((1, 0.0, 0.0), (3, 0.0, 0.0), (0, 0.0, 0.3), (2, 1.5, 0.0), (1, 0.7, 0.4))


@pytest.mark.parametrize("model", ["vem", "hwvem"])
@settings(max_examples=12)
@given(
    n=st.integers(1, 14),
    dim=st.sampled_from((2, 3)),
    edges=st.sampled_from(EDGES),
    box=st.sampled_from((1.3, 2.6, 5.5)),
    v0=st.sampled_from((0.11, 0.6)),
    late=st.sampled_from((*LATE, (0, 0.0, 0.0))),
    error=st.sampled_from((0.0, 0.25)),
    seed=st.integers(0, 999),
)
def test_it_goes_by_the_newest_message_of_each(model, n, dim, edges, box, v0, late, error, seed):
    where = scene(np.random.default_rng(seed), n, dim, edges, box=box, v0=v0, informed=1)
    eta = 0.3 if dim == 2 else 0.0
    p = parameters(where, eta=eta)
    told = dict(zip(("delay", "jitter", "lost"), late, strict=True))
    flock = build(model, where, eta=eta, place_error=error, **told)
    states = [state_of(flock, model)]
    for _ in range(6):
        demand_clear_contacts(states[-1].position, p, where)
        noise = noise_of(flock, "angular", eta)
        expected = messages.step(
            model,
            states,
            flock.ids,
            flock.seed,
            late,
            p,
            where.size,
            where.edges,
            error=error,
            **noise,
        )
        rows = Clear.of(model, states[-1], p, where.size, where.edges).rows
        flock.step()
        compare(model, flock, expected, rows, where.size, where.edges)
        states.append(state_of(flock, model))


def test_messages_that_take_no_time_change_nothing_but_last_bits():
    """0.001 of a tick is none: the same flock, by another loop."""
    where = scene(np.random.default_rng(4), 40, 2, "wrap", informed=1)
    one, other = (build("hwvem", where, eta=0.4, delay=delay) for delay in (0.0, 0.001))
    one.run(20)
    other.run(20)
    assert one.engine.module is not other.engine.module
    np.testing.assert_allclose(one.position, other.position, atol=1e-9)


@pytest.mark.parametrize("model", ["couzin", "safe"])
def test_members_one_by_one_are_the_ticks_of_the_flock(model):
    whole, single = (Flock(model, agents=9, rng=6, delay=0.4, lost=0.2) for _ in range(2))
    whole.run(3)
    for _ in range(3):
        for row in np.random.default_rng(1).permutation(len(single.ids)):
            single.step_member(int(row))
    assert np.array_equal(whole.position, single.position)
    assert np.array_equal(whole.heading, single.heading)


def test_a_saved_state_remembers_what_was_on_the_way(tmp_path):
    whole, first = (Flock("hwvem", agents=40, rng=2, delay=4, jitter=2, lost=0.3) for _ in range(2))
    first.run(9)
    first.save(tmp_path / "state.parquet")
    again = Flock.load(tmp_path / "state.parquet")
    whole.run(20)
    again.run(11)
    assert np.array_equal(whole.position, again.position)


def test_agents_come_and_go():
    flock = Flock("vem", agents=20, rng=2, delay=3)
    flock.run(5)
    new = Member(flock)
    flock.run(2)
    flock.agents[3].remove()
    flock.run(5)
    assert flock.arrays.past.shape[:2] == (20, 4)
    assert np.isfinite(flock.arrays.past).all()
    assert new.row == 19


def test_places_are_off_by_normal_numbers_of_their_own():
    """Of 40 000 draws: mean, spread and tail of a normal law, alike for no two pairs or ticks."""
    made = np.array(
        [
            [place_error(7, tick, receiver, sender, axis) for axis in range(2)]
            for tick in range(20)
            for receiver in range(32)
            for sender in range(31)
        ]
    )
    assert abs(made.mean()) < 4.0 / math.sqrt(made.size)
    assert abs(made.std() - 1.0) < 4.0 / math.sqrt(2.0 * made.size)
    assert abs(float((np.abs(made) > 2.0).mean()) - 0.0455) < 0.005
    assert np.abs(made).max() <= 4.0
    assert abs(np.corrcoef(made.T)[0, 1]) < 0.03
    assert len(np.unique(made)) == made.size


def test_who_touches_whom_goes_by_where_they_are():
    """Two that stand 2 apart take each other to be anywhere, and do not crash."""
    start = {"position": [[5.0, 5, 5], [7.0, 5, 5]], "heading": [[0.0, 1.0, 0.0]] * 2}
    wanted = {"d_0": 0.0, "contact": "always", "v0": 0.0, "place_error": 3.0}
    flock = Flock("thesis", start=start | {"speed": [0.0, 0.0]}, rng=1, **wanted)
    flock.run(200)
    assert flock.active.all()


class Spring(Parameters):
    """Of the rule below."""

    gain: float = parameter(
        4.0, "Pull", symbol="k", source="tests", unit="1/s^2", low=0.0, high=100.0
    )
    damping: float = parameter(
        1.0, "Damping", symbol="k", source="tests", unit="1/s", low=0.0, high=100.0
    )
    reach: float = parameter(
        100.0, "Range", symbol="k", source="tests", unit="m", low=0.0, high=1000.0
    )


@compiled
def consent(me, near, surroundings, p):  # noqa: ARG001
    """x_i'' = gain sum_j (x_j - x_i) - damping x_i'."""
    x, y = -p.damping * me.speed * me.ux, -p.damping * me.speed * me.uy
    for j in range(near.n):
        x += p.gain * (near.x[j] - me.x)
        y += p.gain * (near.y[j] - me.y)
    return Decision(x, y, 0.0)


def apart(delay, gain=4.0, damping=1.0, dt=0.005, seconds=40.0):
    """x_2 - x_1 of two agents that begin at rest at +-1, after each tick, (ticks,)."""
    start = {"position": [[-1.0, 5.0], [1.0, 5.0]], "heading": [[1.0, 0.0], [1.0, 0.0]]}
    settings = {"gain": gain, "damping": damping, "dt": dt, "delay": delay}
    flock = Flock("consent", start=start, size=50.0, world="open", rng=1, **settings)
    where = flock.trace(round(seconds / dt))
    return where[:, 1, 0] - where[:, 0, 0]


@pytest.fixture
def consensus(monkeypatch):
    rule = Rule(
        name="consent",
        title="Consensus",
        summary="Two agents that agree on a place.",
        equation="",
        source="tests",
        parameters=Spring,
        decide=consent,
        reach="reach",
        wish="acceleration",
    )
    monkeypatch.setitem(MODELS, "consent", Model(rule, point_mass.BODY))


@pytest.mark.usefixtures("consensus")
@pytest.mark.parametrize("delay", [0.0, 0.05, 0.4])
def test_two_agents_are_the_recursion_of_their_equation(delay):
    """e'' = -gain (e(t - delay) + e) - damping e', velocity first (semi-implicit Euler)."""
    dt, late = 0.005, round(delay / 0.005)
    e, v = [2.0], 0.0
    for k in range(400):
        v += dt * (-4.0 * (e[max(0, k - late)] + e[k]) - v)
        e.append(e[k] + dt * v)
    np.testing.assert_allclose(apart(delay, seconds=2.0), e[1:], atol=1e-9)


@pytest.mark.usefixtures("consensus")
def test_their_consensus_is_stable_up_to_the_closed_form():
    """Roots of s^2 + c s + g (1 + exp(-s T)) cross the axis at w^2 = 2 g - c^2.

    The first delay with a root there is T = atan2(c w, w^2 - g) / w.
    """
    gain, damping = 4.0, 1.0
    w = math.sqrt(2.0 * gain - damping**2)
    bound = math.atan2(damping * w, w * w - gain) / w

    def grows(delay):
        e = np.abs(apart(delay, gain, damping))
        return e[-len(e) // 4 :].max() / e[: len(e) // 4].max()

    assert bound == pytest.approx(0.2733, abs=1e-3)
    assert grows(0.92 * bound) < 0.8
    assert grows(1.08 * bound) > 1.25


@pytest.mark.usefixtures("consensus")
def test_a_shorter_tick_keeps_what_is_known():
    """A setting that changes the length of a tick changes how many ticks a message takes."""
    flock = Flock("consent", agents=3, rng=2, delay=0.4)
    flock.run(10)
    before = flock.arrays.past.shape[1]
    flock.set(dt=flock.dt / 2)
    assert flock.arrays.past.shape[1] == 2 * before - 1
    flock.run(3)
    assert np.isfinite(flock.position).all()


@pytest.mark.parametrize(
    ("wind", "message"),
    [({"delay": -1.0}, "delay"), ({"lost": 1.0}, "lost"), ({"place_error": -1.0}, "place_error")],
)
def test_what_cannot_be_is_one_line(wind, message):
    with pytest.raises(InputError, match=f"{message} = .* is not allowed"):
        Spec("vem", **wind)


def test_turns_and_delays_do_not_go_together():
    with pytest.raises(InputError, match="activation = 'random' is not allowed where messages"):
        Spec("vem", delay=2, activation="random")


def test_a_past_that_would_be_endless_is_refused():
    with pytest.raises(InputError, match=r"messages would be up to .* ticks"):
        Flock("vem", agents=3, delay=1e5)
    assert math.isfinite(Flock("vem", agents=3, delay=9_000.0, rng=1).dt)
