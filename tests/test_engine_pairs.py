"""Rules that are sums over pairs, eight agents at once, against the same rules one by one."""

from __future__ import annotations

import dataclasses
import math
import threading

import numba
import numpy as np
import pytest
import scipy  # its parts are imported when they are asked for
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays as drawn
from numba.core.errors import LoweringError
from oracles.scenes import unit_vectors

from agents import Flock
from agents.catalogue import MODELS
from agents.engine import vector_lanes
from agents.engine.noise import cos_sin, exp, log, normal
from agents.engine.pairs.pair_runner import PairEngine
from agents.engine.pairs.term_sums import keep_sums
from agents.engine.pairs.thread_barrier import STOP
from agents.engine.runner import NotANumber
from agents.engine.vector_lanes import WIDTH, exponent, load, mantissa, store, where
from agents.models.model_calls import ModelCodeError
from agents.motion.motion import Motion
from agents.rules.terms.sums import of_pairs
from flockscope.rules import CONSTANT_SPEED, VEM, Decision, Model, is_neighbour
from worlds.compilation import compiled

finite = st.floats(-1e6, 1e6)
eight = drawn(float, WIDTH, elements=finite)


@numba.njit
def some_of_all(x, y, table):
    """Every operation on lanes once, each into a row."""
    a, b = load(x, 0), load(y, 0)
    store(table, 0, a + b)
    store(table, 1, a - 2.0 * b)
    store(table, 2, a / (1.0 + b * b))
    store(table, 3, math.sqrt(math.fabs(a)) + math.floor(b))
    store(table, 4, where((a < b) & (b <= 3.0) | (a == b), a, -b))
    store(table, 5, (a >= b) * a + min(a, b) * (a > 0.0))
    store(table, 6, max(a, 1.0))
    store(table, 7, 3)


@numba.njit
def of_the_noise(x, angle, table):
    """What noise is made of, of eight numbers at once; logarithms of x > 0."""
    a = load(x, 0)
    c, s = cos_sin(load(angle, 0))
    store(table, 0, log(a))
    store(table, 1, c)
    store(table, 2, s)
    store(table, 3, mantissa(a))
    store(table, 4, exponent(a))
    store(table, 5, exp(30.0 * load(angle, 0)))


@given(
    drawn(float, WIDTH, elements=st.floats(1e-300, 1e300)),
    drawn(float, WIDTH, elements=st.floats(-20.0, 20.0)),
)
def test_logarithm_exponential_cosine_and_sine_are_those_of_the_library_in_every_lane(x, angle):
    table = np.zeros((6, WIDTH))
    of_the_noise(x, angle, table)
    assert np.allclose(table[0], np.log(x), rtol=1e-15, atol=3e-16)
    assert np.allclose(table[1:3], [np.cos(angle), np.sin(angle)], rtol=0.0, atol=3e-16)
    assert np.array_equal(table[3:5], np.frexp(x))
    assert np.allclose(table[5], np.exp(30.0 * angle), rtol=5e-16, atol=0.0)
    by_itself = [exp.py_func(30.0 * one) for one in angle]
    assert np.allclose(table[5], by_itself, rtol=5e-16, atol=0.0)
    alone = [(log.py_func(a), *cos_sin.py_func(b)) for a, b in zip(x, angle, strict=True)]
    assert np.allclose(table[:3].T, alone, rtol=1e-15, atol=3e-16)


def test_cosine_and_sine_of_many_turns_are_as_exact_as_the_angle():
    angle = np.geomspace(20.0, 1e12, 20_001)
    found = np.array([cos_sin(one) for one in angle])
    off = np.abs(found - np.column_stack([np.cos(angle), np.sin(angle)]))
    assert (off <= 1e-15 + np.spacing(angle)[:, None]).all()


def test_the_exponential_is_one_at_zero_and_nothing_far_below():
    assert [exp(x) for x in (0.0, -701.0, -1e9, -np.inf)] == [1.0, 0.0, 0.0, 0.0]
    assert exp(1.0) == np.e
    x = np.linspace(-700.0, 700.0, 20_001)
    assert np.allclose([exp(one) for one in x], np.exp(x), rtol=5e-16, atol=0.0)


def test_normal_numbers_are_normal():
    found = [normal(np.uint64(7), agent, 4) for agent in range(4000)]
    assert scipy.stats.kstest(found, "norm").pvalue > 0.01
    assert abs(np.corrcoef(found[::2], found[1::2])[0, 1]) < 0.05


@given(eight, eight)
def test_lanes_are_eight_numbers(x, y):
    table = np.zeros((8, WIDTH))
    some_of_all(x, y, table)
    expected = [
        x + y,
        x - 2.0 * y,
        x / (1.0 + y * y),
        np.sqrt(np.abs(x)) + np.floor(y),
        np.where((x < y) & (y <= 3.0) | (x == y), x, -y),
        np.where(x >= y, x, 0.0) + np.where(x > 0.0, np.minimum(x, y), 0.0),
        np.maximum(x, 1.0),
        np.full(WIDTH, 3.0),
    ]
    np.testing.assert_allclose(table, expected, rtol=1e-15, atol=1e-9)


@numba.njit
def in_place(x, out):
    """Every operator that changes its left side."""
    a, b = load(x, 0), load(x, WIDTH)
    total = a + b
    total += a
    total -= 2.0 * b
    total *= a
    total /= b
    store(out, 0, total)


def test_lanes_are_changed_in_place_as_numbers_are():
    x, out = np.arange(1.0, 2 * WIDTH + 1.0), np.zeros(WIDTH)
    in_place(x, out)
    a, b = x[:WIDTH], x[WIDTH:]
    np.testing.assert_allclose(out, (a + b + a - 2.0 * b) * a / b, rtol=1e-14, atol=1e-14)


@compiled
def use_every_operator(x, y, i, j):
    """What each operator gives of two numbers and of two whole numbers, as numbers."""
    total = x
    total += y
    total *= 2.0
    total -= x
    total /= 4.0
    square = x
    square **= 2
    is_all = is_any_of_them = is_odd = x < y
    is_all &= y > 0.0
    is_any_of_them |= y > 0.0
    is_odd ^= y > 0.0
    word = i
    word ^= j
    word >>= vector_lanes.as_unsigned(1)
    word += i
    word *= j
    return (
        where(x < y, 1.0, 0.0),
        where(x <= y, 1.0, 0.0),
        where(x > y, 1.0, 0.0),
        where(x >= y, 1.0, 0.0),
        where(x == y, 1.0, 0.0),
        where(x != y, 1.0, 0.0),
        where(x != 1.0, 1.0, 0.0),
        where(y != 2, 1.0, 0.0),
        where((x < y) == (y > 0.0), 1.0, 0.0),
        where((x < y) != (y > 0.0), 1.0, 0.0),
        where((x < y) ^ (y > 0.0), 1.0, 0.0),
        where((x < y) & (y != 0.0), 1.0, 0.0),
        where((x < y) | (y != 0.0), 1.0, 0.0),
        where(not (x < y), 1.0, 0.0),
        where(is_all, 1.0, 0.0),
        where(is_any_of_them, 1.0, 0.0),
        where(is_odd, 1.0, 0.0),
        where(i == j, 1.0, 0.0),
        where(i != j, 1.0, 0.0),
        where(i != vector_lanes.as_unsigned(2), 1.0, 0.0),
        total,
        square,
        x**2,
        +x,
        -x,
        abs(x),
        x + y,
        x - y,
        x * y,
        x / (y * y + 1.0),
        2 - x,
        vector_lanes.as_float(word),
        vector_lanes.as_float(i ^ j),
        vector_lanes.as_float(i >> j),
        vector_lanes.as_float(i + j),
        vector_lanes.as_float(i * j),
    )


@numba.njit
def use_operators_of_lanes(x, y, i, j, table):
    keep_sums(table, use_every_operator(load(x, 0), load(y, 0), load(i, 0), load(j, 0)))


few = drawn(float, WIDTH, elements=st.sampled_from([-2.0, -1.0, 0.0, 1.0, 2.0, math.nan]))
words = drawn(np.uint64, WIDTH, elements=st.integers(0, 3))


@given(few, few, words, words)
def test_every_operator_of_lanes_is_that_of_numbers(x, y, i, j):
    with np.errstate(invalid="ignore"):
        expected = [use_every_operator.py_func(*four) for four in zip(x, y, i, j, strict=True)]
    table = np.zeros((len(expected[0]), WIDTH))
    use_operators_of_lanes(x, y, i, j, table)
    np.testing.assert_array_equal(table.T, np.array(expected, float))


def test_lanes_are_not_compared_by_identity():
    @numba.njit
    def identical(x, out):
        store(out, 0, where((load(x, 0) < 1.0) is (load(x, 0) > 1.0), 1.0, 0.0))

    with pytest.raises(LoweringError, match="`is` cannot compare eight agents at once"):
        identical(np.zeros(WIDTH), np.zeros((1, WIDTH)))


@pytest.mark.parametrize("function", [where, vector_lanes.as_unsigned, vector_lanes.as_float])
def test_what_works_on_lanes_works_on_one_number(function):
    given = (True, 2.0, 3.0) if function is where else (2,)
    assert function(*given) == numba.njit(lambda *numbers: function(*numbers))(*given) == 2


def one_by_one(monkeypatch, *arguments, **options) -> Flock:
    """A flock whose agents act one by one, each on the block around it."""
    with monkeypatch.context() as patch:
        patch.setattr(Motion, "of_pairs", False)
        flock = Flock(*arguments, **options)
        flock.run(12)
    return flock


def exhaustive(model, options):
    """A case of which two kernels are compiled, each for several seconds."""
    return pytest.param(model, options, marks=pytest.mark.exhaustive)


@pytest.mark.parametrize(
    ("model", "options"),
    [
        ("vem", {"agents": 700, "size": 9.0, "eta": 0.4}),
        ("vem", {"agents": 90, "size": 2.2, "eta": 0.4}),
        ("vem", {"agents": 40, "size": 30.0, "eta": 0.4}),
        ("vem", {"agents": 300, "size": 5.0, "dim": 3, "eta": 1.0, "noise": "vectorial"}),
        ("vem-a", {"agents": 300, "size": 8.0, "eta": 0.2}),
        ("vem", {"agents": 200, "size": 8.0, "world": "open", "eta": 0.1}),
        ("couzin", {"agents": 200, "sigma": 0.0}),
        ("topological", {"agents": 300, "size": 9.0, "eta": 0.4}),
        ("inertial-spin", {"agents": 300, "informed": 5, "T": 0.5, "eta": 1.0}),
        exhaustive("inertial-spin", {"agents": 100, "world": "open", "size": 9.0, "T": 0.5}),
        exhaustive("couzin", {"agents": 200, "dim": 2, "sigma": 0.05}),
        exhaustive("reynolds", {"agents": 300}),
        exhaustive(
            "reynolds", {"agents": 100, "world": "wrap", "size": 12.0, "dim": 3, "fov": 360.0}
        ),
        exhaustive("olfati-saber", {"agents": 40}),
        ("boundary-points", {}),
        exhaustive("olfati-saber", {"agents": 60, "world": "open", "size": 30.0, "dim": 3}),
    ],
)
def test_eight_at_once_do_what_each_would(monkeypatch, model, options):
    flock = Flock(model, rng=3, **options)
    flock.run(12)
    assert isinstance(flock.engine, PairEngine)
    other = one_by_one(monkeypatch, model, rng=3, **options)
    np.testing.assert_allclose(flock.heading, other.heading, atol=1e-7)
    np.testing.assert_allclose(flock.position, other.position, atol=1e-7)
    np.testing.assert_allclose(flock.speed, other.speed)
    np.testing.assert_allclose(flock.arrays.memory, other.arrays.memory, atol=1e-7)


def test_a_flock_in_space_may_have_agents_whose_spin_stays_in_a_plane(monkeypatch):
    """Which of the two an agent is differs between the eight that act at once."""
    rng = np.random.default_rng(2)
    heading = unit_vectors(rng, 60, 3)
    heading[rng.random(60) < 0.5, 2] = 0.0
    heading /= np.linalg.norm(heading, axis=1)[:, None]
    start = {"position": rng.uniform(0.0, 5.0, (60, 3)), "heading": heading}
    options = {"start": start, "size": 5.0, "dim": 3, "J": 0.0, "T": 0.5, "rng": 3}
    flock = Flock("inertial-spin", **options)
    flock.run(12)
    other = one_by_one(monkeypatch, "inertial-spin", **options)
    np.testing.assert_allclose(flock.arrays.memory, other.arrays.memory, atol=1e-9)
    assert np.array_equal(flock.heading[:, 2] == 0.0, heading[:, 2] == 0.0)


@compiled
def counts(me, other, p):  # noqa: ARG001
    """A neighbour."""
    return (is_neighbour(other, p.r),)


@compiled
def remembers(me, sums, surroundings, p):  # noqa: ARG001
    """How many neighbours there were in the ticks so far, and in the last; asks with `if`."""
    if sums[0] > 0.0:
        me.memory[0] += sums[0]
    me.memory[1] = sums[0]
    return Decision(me.ux, me.uy, me.uz)


def test_agents_remember_whether_they_act_eight_at_once_or_alone(monkeypatch):
    made = of_pairs(1, counts, remembers)
    rule = dataclasses.replace(VEM, name="mindful", memory=("sum", "last"), weigh=None, **made)
    monkeypatch.setitem(MODELS, "mindful", Model(rule, CONSTANT_SPEED))
    options = {"agents": 200, "size": 8.0, "informed": 9, "rng": 1}
    whole, members = Flock("mindful", **options), Flock("mindful", **options)
    assert isinstance(whole.engine, PairEngine)
    whole.run(12)
    for _ in range(12):
        for member in list(members.agents)[::-1]:
            member.step()
    other = one_by_one(monkeypatch, "mindful", **options)
    for flock in (members, other):
        assert np.array_equal(flock.arrays.memory, whole.arrays.memory)
    total, last = whole.arrays.memory
    assert not total[whole.informed].any()
    assert (total[last > 0.0] >= last[last > 0.0]).all()
    assert total.max() > last.max()


@compiled
def goes_by_memory(me, other, p):
    """A neighbour, and as much as it was reminded of."""
    return (is_neighbour(other, p.r) * (1.0 + me.memory[0]),)


@compiled
def remembers_in_lanes(me, sums, surroundings, p):  # noqa: ARG001
    """As many as there were in the last tick, by a half of those before."""
    me.memory[0] = 0.5 * sums[0]
    return Decision(me.ux, me.uy, me.uz)


@pytest.mark.parametrize("by_lanes", [True, False])
def test_a_term_may_go_by_what_its_agent_remembers(monkeypatch, by_lanes):
    """Eight at once have it where they answer at once; else they act one by one."""
    made = of_pairs(1, goes_by_memory, remembers_in_lanes, by_lanes)
    rule = dataclasses.replace(VEM, name="mindful", memory=("sum",), weigh=None, **made)
    monkeypatch.setitem(MODELS, "mindful", Model(rule, CONSTANT_SPEED))
    options = {"agents": 90, "size": 8.0, "rng": 1}
    flock = Flock("mindful", **options)
    flock.run(12)
    assert flock.of_pairs == by_lanes
    other = one_by_one(monkeypatch, "mindful", **options)
    np.testing.assert_allclose(flock.arrays.memory, other.arrays.memory, rtol=1e-12)
    assert flock.arrays.memory.max() > 1.0


def test_what_sees_points_does_not_answer_by_lanes():
    with pytest.raises(TypeError, match="boundary points are not seen by lanes"):
        of_pairs(1, counts, remembers, by_lanes=True, sees_points=True)


@pytest.mark.parametrize("k", [3, 6, 7, 10, 100])
@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_of_those_equally_far_the_first_are_the_nearest(monkeypatch, k, offset):
    """On a lattice across a seam: whoever is the k-th, three others or more are as far."""
    side = 12
    rows = np.random.default_rng(k).permutation(side * side)
    angle = np.random.default_rng(1).uniform(0.0, 2.0 * math.pi, side * side)
    start = {
        "position": np.stack([rows % side, rows // side], axis=1) + offset,
        "heading": np.stack([np.cos(angle), np.sin(angle)], axis=1),
    }
    options = {"start": start, "size": float(side), "v0": 0.0, "k": k, "rng": 1}
    flock = Flock("topological", **options)
    flock.run(12)
    other = one_by_one(monkeypatch, "topological", **options)
    np.testing.assert_allclose(flock.heading, other.heading, atol=1e-9)


@pytest.mark.parametrize("model", ["vem", "inertial-spin"])
def test_a_run_is_its_ticks_one_by_one_to_the_bit(model):
    whole, ticks, members, traced = (
        Flock(model, agents=500, size=8.0, eta=0.5, rng=2) for _ in range(4)
    )
    whole.run(7)
    for _ in range(7):
        ticks.run(1)
        for member in list(members.agents)[::-1]:
            member.step()
    positions = traced.trace(7)
    for flock in (ticks, members, traced):
        assert np.array_equal(flock.position, whole.position)
        assert np.array_equal(flock.heading, whole.heading)
        assert np.array_equal(flock.arrays.memory, whole.arrays.memory)
    assert np.array_equal(positions[-1], whole.position)


def test_identities_that_do_not_follow_one_another_keep_their_noise():
    flock = Flock("vem", agents=60, size=30.0, eta=1.0, r=0.05, rng=4)
    gone = Flock("vem", agents=60, size=30.0, eta=1.0, r=0.05, rng=4)
    for member in list(gone.agents)[10:20]:
        member.remove()
    flock.run(3)
    gone.run(3)
    stay = np.isin(flock.ids, gone.ids)
    assert stay.sum() == 50
    assert np.array_equal(flock.heading[stay], gone.heading)


def test_a_place_that_is_no_number_is_named_and_nothing_is_mixed_up():
    flock = Flock("vem", agents=200, size=6.0, eta=0.5, rng=5)
    flock.set(v0=0.1)
    before = Flock("vem", agents=200, size=6.0, eta=0.5, rng=5)
    flock.heading[7] = np.nan
    flock.run(1)
    with pytest.raises(NotANumber, match="tick 1"):
        flock.run(3)
    whole = np.isfinite(flock.position).all(axis=1)
    assert not whole[7]
    apart = np.abs(flock.position - before.position)[whole]
    assert np.minimum(apart, 6.0 - apart).max() < 0.11


def test_threads_that_wait_for_one_that_never_comes_leave_with_nothing_done(monkeypatch):
    flock = Flock("vem", agents=12_000, size=60.0, eta=0.5, rng=6, threads=2)
    flock.run(1)
    kept = flock.position.copy()
    call = PairEngine.call

    def only_the_helpers(self, context, tick, ticks, work, *rest):
        if threading.current_thread() is threading.main_thread():
            raise KeyboardInterrupt
        return call(self, context, tick, ticks, work, *rest)

    monkeypatch.setattr(PairEngine, "call", only_the_helpers)
    meeting = flock.engine.meeting
    with pytest.raises(KeyboardInterrupt):
        flock.run(5)
    assert meeting[STOP] == 1
    assert np.array_equal(flock.position, kept)
    monkeypatch.undo()
    other = Flock("vem", agents=12_000, size=60.0, eta=0.5, rng=6)
    other.run(4)
    flock.run(3)
    assert np.array_equal(flock.position, other.position)


@compiled
def asks_with_if(me, other, p):  # noqa: ARG001
    return (1.0 if other.d2 < p.r else 0.0,)


@compiled
def too_few(me, other, p):  # noqa: ARG001
    return other.ux, other.uy


@compiled
def of_one(me, sums, surroundings, p):  # noqa: ARG001
    return Decision(sums[0], 0.0, 0.0)


@pytest.mark.parametrize(
    ("term", "reason"),
    [
        (asks_with_if, "term, line .*: `if` cannot ask about eight agents at once"),
        (too_few, "term, line .*: it has to have as many numbers as its rule says, 1"),
    ],
)
def test_what_is_wrong_with_a_term_is_one_line(monkeypatch, term, reason):
    made = of_pairs(1, term, of_one)
    rule = dataclasses.replace(VEM, name="wrong", weigh=None, **made)
    monkeypatch.setitem(MODELS, "wrong", Model(rule, CONSTANT_SPEED))
    with pytest.raises(ModelCodeError, match=reason) as caught:
        Flock("wrong", agents=20, rng=1).run(1)
    assert "\n" not in str(caught.value)
