"""The engine: who is seen, one result however it is reached, and the order agents act in."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracles import vicsek_family as family
from oracles.flocks import angles_of, at_rest, build, parameters
from oracles.following import compare, follow, noise_of, state_of
from oracles.scenes import Scene, scene, unit_vectors
from oracles.topology import EDGES

from agents import Member

BRIEF = settings(max_examples=25, deadline=None, derandomize=True)
PLANAR = ("ivem", "ivem-a")


# --- who is seen ------------------------------------------------------------------------------


def test_contact_at_exactly_r_counts():
    flock = at_rest("vem", [[0, 0], [1, 0], [2.5, 0]], [0.2, 1.0, 2.0], eta=0.0)
    flock.step()
    assert angles_of(flock) == pytest.approx([0.6, 0.6, 2.0])


@pytest.mark.parametrize("model", ["wvem", "hwvem"])
def test_two_agents_on_one_spot_do_not_see_each_other(model):
    flock = at_rest(model, [[4, 4], [4, 4]], [0.0, 1.0], informed=[0], eta=0.0)
    flock.step()
    assert angles_of(flock) == pytest.approx([0.0, 1.0])


@pytest.mark.parametrize(
    ("world", "after"), [("wrap", [0.6, 0.6]), ("wrap-plain", [0.2, 1.0]), ("open", [0.2, 1.0])]
)
def test_only_wrap_sees_across_the_seam(world, after):
    flock = at_rest("vem", [[0.1, 5], [9.9, 5]], [0.2, 1.0], world=world, eta=0.0)
    flock.step()
    assert angles_of(flock) == pytest.approx(after)


def lattice(size, edges, seed):
    """Agents on whole numbers, r = 1: every one on a cell border, distances exactly r."""
    x = np.array(list(itertools.product(*[range(s) for s in size])), dtype=float)
    rng = np.random.default_rng(seed)
    informed = np.arange(len(x)) == rng.integers(len(x))
    size = tuple(float(s) for s in size)
    return Scene(x, unit_vectors(rng, *x.shape), informed, size, edges, 1.0, 0.1)


@pytest.mark.parametrize("edges", EDGES)
@pytest.mark.parametrize("model", ["vem", "wvem", "hwvem"])
@pytest.mark.parametrize("dim", [2, 3])
def test_lattice_neighbours(model, edges, dim):
    """Boxes of 1 and 2 r: an agent both of whose images are at exactly r still counts once."""
    for size in itertools.product((1, 2, 3, 5) if dim == 2 else (1, 2, 4), repeat=dim):
        where = lattice(size, edges, seed=sum(size))
        before = family.begin(
            where.position, where.heading, where.informed, parameters(where), size, edges
        )
        expected = family.step(model, before, parameters(where), size, edges)
        flock = build(model, where, eta=0.0)
        if model == "hwvem":
            assert flock.signal("layer").tolist() == before.layer.tolist()
        flock.step()
        compare(model, flock, expected, np.ones(len(where.position), bool), size, edges)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("edges", EDGES)
def test_a_thousand_agents(edges, dim):
    where = scene(np.random.default_rng(8), 1000, dim, edges, box=14.0 if dim == 2 else 6.0)
    assert follow(build("vem", where, eta=0.0), "vem", where, parameters(where), ticks=2) > 0.99


@pytest.mark.parametrize("arrangement", ["clusters", "one spot", "border"])
@pytest.mark.parametrize("activation", ["synchronous", "sequential"])
def test_a_crowd_of_three_hundred(arrangement, activation):
    where = scene(np.random.default_rng(8), 300, 2, "wrap", arrangement, box=5.5)
    flock = build("vem", where, activation=activation, eta=0.0)
    before, p = state_of(flock, "vem"), parameters(where)
    if activation == "synchronous":
        expected = family.step("vem", before, p, where.size, "wrap")
    else:
        expected = family.step_sequentially("vem", before, range(300), p, where.size, "wrap")
    flock.step()
    compare("vem", flock, expected, np.ones(300, bool), where.size, "wrap")


@pytest.mark.parametrize("activation", ["synchronous", "sequential"])
def test_a_crowd_that_gathers_while_it_runs(activation):
    """Information agents on a ring fly to its middle: blocks grow from a few agents to all."""
    where = scene(np.random.default_rng(8), 400, 2, "open", box=12.0, v0=0.9, informed=390)
    where.heading[:] = unit_vectors(np.random.default_rng(9), 400, 2)
    where.position[:] = 6.0 - 5.4 * where.heading
    run, stepped = (build("hwvem", where, activation=activation, eta=0.1) for _ in range(2))
    before = run.observe("mean-neighbours")
    run.run(6)
    advance(stepped, "do", 6)
    for one, other in zip(bits(run, "hwvem"), bits(stepped, "hwvem"), strict=True):
        assert np.array_equal(one, other)
    assert before < 40
    assert run.observe("mean-neighbours") > 250


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("model", ["vem", "hwvem"])
def test_two_flocks_a_hundred_thousand_radii_apart(model, dim):
    where = scene(np.random.default_rng(9), 60, dim, "open", box=2.0)
    where.position[30:] += 1e5 * np.array([1, -1, 1][:dim])
    follow(build(model, where, eta=0.0), model, where, parameters(where), ticks=3)


# --- one result, however it is reached ---------------------------------------------------------

CASES = [
    (model, dim, noise)
    for model, dim, noise in itertools.product(family.MODELS, (2, 3), ("angular", "vectorial"))
    if model not in PLANAR or (dim == 2 and noise == "angular")
]


def bits(flock, model):
    """Everything a tick writes."""
    layer = [flock.signal("layer")] if model == "hwvem" else []
    return [np.array(a) for a in (flock.position, flock.heading, flock.tick, *layer)]


def advance(flock, way, ticks):
    """Run a flock for some ticks in one of the ways there are."""
    if way == "run":
        flock.run(ticks)
        return
    for _ in range(ticks):
        if way == "step":
            flock.step()
        elif way == "do":
            flock.agents.do("step")
        elif way == "shuffle_do":
            flock.agents.shuffle_do("step")
        else:
            for member in flock.agents:
                member.step()


@pytest.mark.parametrize(("model", "dim", "noise"), CASES)
@pytest.mark.parametrize("edges", EDGES)
def test_every_way_of_running_gives_the_same_bits(model, dim, noise, edges):
    where = scene(np.random.default_rng(4), 40, dim, edges, box=2.6, informed=1)

    def after(way, threads=1):
        flock = build(model, where, noise=noise, threads=threads, eta=0.4)
        advance(flock, way, 5)
        assert flock.tick == 5
        return bits(flock, model)

    stepped = after("step")
    for way, threads in (
        ("step", 2),
        ("run", 1),
        ("run", 2),
        ("do", 1),
        ("shuffle_do", 1),
        ("member by member", 1),
    ):
        for one, other in zip(stepped, after(way, threads), strict=True):
            assert np.array_equal(one, other), (way, threads)


def test_ways_can_be_mixed_within_a_run():
    where = scene(np.random.default_rng(4), 40, 2, "wrap", informed=1)
    one, other = (build("hwvem", where, eta=0.4) for _ in range(2))
    one.run(12)
    for way, ticks in (("do", 2), ("run", 3), ("shuffle_do", 1), ("step", 2), ("run", 4)):
        advance(other, way, ticks)
    for a, b in zip(bits(one, "hwvem"), bits(other, "hwvem"), strict=True):
        assert np.array_equal(a, b)


def test_a_member_is_a_row():
    where = scene(np.random.default_rng(4), 7, 2, "wrap", informed=1)
    flock = build("hwvem", where, eta=0.4)
    flock.run(3)
    for i, member in enumerate(flock.agents):
        assert np.array_equal(member.position, flock.position[i])
        assert np.array_equal(member.heading, flock.heading[i])


@pytest.mark.parametrize("model", ["vem", "wvem", "hwvem"])
def test_agents_come_and_go(model):
    """Rows move up, identities (and with them the noise) stay; the rule sees who is there now."""
    where = scene(np.random.default_rng(4), 30, 2, "wrap", box=5.5, informed=2)
    flock, p = build(model, where, eta=0.4), parameters(where, eta=0.4)
    follow(flock, model, where, p, ticks=2)
    for row in (3, 10, 25):
        next(m for m in flock.agents if m.row == row).remove()
    follow(flock, model, where, p, ticks=2)
    for _ in range(5):
        Member(flock)
    assert len(flock.position) == 32
    follow(flock, model, where, p, ticks=4)


def test_an_unknown_layer_stays_unknown_when_agents_come_and_go():
    """Unknown is N + 1 of the flock as it is now: the two cut-off agents must not turn."""
    flock = at_rest("hwvem", [[0, 0], [5, 5], [5.5, 5]], [0, 1, 2], informed=[0], eta=0.0)
    assert flock.signal("layer").tolist() == [1, 4, 4]
    new = Member(flock, position=[8.0, 1.0], heading=[1.0, 0.0])
    assert flock.signal("layer").tolist() == [1, 5, 5, 5]
    flock.step()
    assert angles_of(flock)[:3] == pytest.approx([0, 1, 2])
    new.remove()
    assert flock.signal("layer").tolist() == [1, 4, 4]


@pytest.mark.parametrize("noise", ["angular", "vectorial"])
@pytest.mark.parametrize("dim", [2, 3])
def test_seeds_make_runs(noise, dim):
    where = scene(np.random.default_rng(4), 40, dim, "wrap", informed=1)
    runs = []
    for seed in (3, 3, 4):
        flock = build("vem", where, seed=seed, noise=noise, eta=0.4)
        flock.run(3)
        runs.append(flock.heading.copy())
    assert np.array_equal(runs[0], runs[1])
    assert not np.array_equal(runs[0], runs[2])


# --- the order agents act in ------------------------------------------------------------------


def agrees(flock, expected, where, model):
    """Whether a flock is where the oracle has it."""
    try:
        rows = np.ones(len(where.position), bool)
        compare(model, flock, expected, rows, where.size, where.edges)
    except AssertionError:
        return False
    return True


@pytest.mark.parametrize("model", family.MODELS)
@BRIEF
@given(
    n=st.integers(1, 30),
    dim=st.sampled_from((2, 3)),
    edges=st.sampled_from(EDGES),
    box=st.sampled_from((1.3, 2.6, 3.7, 12.0)),
    v0=st.sampled_from((0.03, 0.37)),
    noise=st.sampled_from(("angular", "vectorial")),
    layers=st.sampled_from(("delayed", "instant")),
    seed=st.integers(0, 999),
)
def test_sequential_activation_goes_row_by_row(model, n, dim, edges, box, v0, noise, layers, seed):
    dim = 2 if model in PLANAR else dim
    where = scene(np.random.default_rng(seed), n, dim, edges, box=box, v0=v0, informed=1)
    given_ = {"eta": 0.3 if dim == 2 else 0.0}
    if model == "hwvem":
        given_["layers"] = layers
    p = parameters(where, **given_)
    flock = build(model, where, activation="sequential", noise=noise, **given_)
    for _ in range(3):
        before = state_of(flock, model)
        told = noise_of(flock, noise, p.eta) if dim == 2 else {}
        expected = family.step_sequentially(model, before, range(n), p, where.size, edges, **told)
        flock.step()
        compare(model, flock, expected, np.ones(n, bool), where.size, edges)


@pytest.mark.parametrize("model", family.MODELS)
@pytest.mark.parametrize("edges", EDGES)
def test_random_activation_takes_one_of_the_orders_each_tick(model, edges):
    where = scene(np.random.default_rng(6), 4, 2, edges, box=1.3, v0=0.37, informed=1)
    p = parameters(where)
    flock = build(model, where, activation="random", eta=0.0)
    taken = []
    for _ in range(8):
        before = state_of(flock, model)
        flock.step()
        possible = [
            order
            for order in itertools.permutations(range(4))
            if agrees(
                flock,
                family.step_sequentially(model, before, order, p, where.size, edges),
                where,
                model,
            )
        ]
        assert possible, "no order explains what happened"
        taken.append(possible)
    always = set(taken[0]).intersection(*taken[1:])
    assert not always, "every tick took the same order"


@pytest.mark.parametrize("activation", ["random", "sequential"])
@pytest.mark.parametrize("dim", [2, 3])
def test_one_after_another_is_reproducible(activation, dim):
    where = scene(np.random.default_rng(7), 30, dim, "wrap", informed=1)
    runs = []
    for seed, ticks in ((3, (4,)), (3, (1, 1, 2)), (4, (4,))):
        flock = build("hwvem", where, seed=seed, activation=activation, eta=0.0)
        for some in ticks:
            flock.run(some)
        runs.append(bits(flock, "hwvem"))
    assert all(np.array_equal(a, b) for a, b in zip(runs[0], runs[1], strict=True))
    same = np.array_equal(runs[0][1], runs[2][1])
    assert same == (activation == "sequential"), "the seed decides a random order, nothing else"


@pytest.mark.parametrize("model", family.MODELS)
def test_agents_called_in_row_order_are_the_sequential_flock(model):
    where = scene(np.random.default_rng(7), 30, 2, "wrap", informed=1)
    one, other = (build(model, where, activation="sequential", eta=0.4) for _ in range(2))
    one.run(4)
    advance(other, "do", 4)
    assert all(
        np.array_equal(a, b) for a, b in zip(bits(one, model), bits(other, model), strict=True)
    )
