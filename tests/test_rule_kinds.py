"""Rules that know kinds of agents: `me.kind`, `other.kind`, `near.kind[j]`, against plain loops."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from oracles import known_kinds

from agents import catalogue
from agents.catalogue import MODELS
from agents.conformance import CHECKS, outcome
from agents.flock import Flock
from agents.kinds import Kind, chase, complete_kinds
from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES
from agents.spec import Spec
from flockscope.rules import (
    CONSTANT_SPEED,
    VEM,
    Decision,
    Rule,
    Vicsek,
    adjacent,
    compiled,
    is_neighbour,
    of_pairs,
    parameter,
    where,
)
from worlds.input_error import InputError

SHEEP, WOLF = 0, 1
SIDE = 3.0


class Herding(Vicsek):
    """How much sheep flee wolves, and wolves follow sheep."""

    fear: float = parameter(
        0.8, "Weight of the way from a wolf", symbol="f", source="this test", low=0.0, high=5.0
    )
    hunger: float = parameter(
        0.5, "Weight of the way to a sheep", symbol="h", source="this test", low=0.0, high=5.0
    )


@compiled
def decide(me, near, surroundings, p):  # noqa: ARG001
    """By blocks: the mean heading of one's own kind, from wolves, towards sheep."""
    x, y, z, n = me.ux, me.uy, me.uz, 1.0
    px = py = pz = 0.0
    for j in range(near.n):
        h = adjacent(me, near, j, p.r)
        dx, dy, dz = near.x[j] - me.x, near.y[j] - me.y, near.z[j] - me.z
        d = math.sqrt(dx * dx + dy * dy + dz * dz)
        if h > 0.0:
            if near.kind[j] == me.kind:
                x, y, z, n = x + near.ux[j], y + near.uy[j], z + near.uz[j], n + 1.0
            elif near.kind[j] == WOLF and me.kind == SHEEP:
                px, py, pz = px - p.fear * dx / d, py - p.fear * dy / d, pz - p.fear * dz / d
            elif near.kind[j] == SHEEP and me.kind == WOLF:
                px, py, pz = px + p.hunger * dx / d, py + p.hunger * dy / d, pz + p.hunger * dz / d
    return Decision(x / n + px, y / n + py, z / n + pz)


@compiled
def term(me, other, p):
    """The same of a pair: what is aligned with, how many, and what pushes."""
    h = is_neighbour(other, p.r)
    over = 1.0 / math.sqrt(where(h, other.d2, 1.0))
    is_alike = h & (me.kind == other.kind)
    a = where(is_alike, 1.0, 0.0)
    flees = where(h & (me.kind == SHEEP) & (other.kind == WOLF), p.fear * over, 0.0)
    hunts = where(h & (me.kind == WOLF) & (other.kind == SHEEP), p.hunger * over, 0.0)
    push = where(me.kind != other.kind, hunts - flees, 0.0)
    return (
        a * other.ux,
        a * other.uy,
        a * other.uz,
        a,
        push * other.dx,
        push * other.dy,
        push * other.dz,
    )


@compiled
def answer(me, sums, surroundings, p):  # noqa: ARG001
    """The mean and the push."""
    x, y, z, n, px, py, pz = sums
    n = n + 1.0
    return Decision((me.ux + x) / n + px, (me.uy + y) / n + py, (me.uz + z) / n + pz)


BLOCKS = Rule(
    name="herd-blocks",
    title="Sheep and wolves",
    summary="Sheep flee from wolves.",
    equation="",
    source="this test",
    parameters=Herding,
    decide=decide,
    kinds=("wolf",),
)
FORMS = {
    "blocks": BLOCKS,
    "pairs": replace(BLOCKS, name="herd-pairs", **of_pairs(7, term, answer)),
    "lanes": replace(BLOCKS, name="herd-lanes", **of_pairs(7, term, answer, by_lanes=True)),
}


@pytest.fixture(autouse=True)
def models(monkeypatch):
    """The three forms of the rule among the models."""
    for rule in FORMS.values():
        monkeypatch.setitem(catalogue.MODELS, rule.name, Model(rule, CONSTANT_SPEED))


def herd(form, dim=2, agents=24, interpret=False, **words):
    """A flock of the rule, with wolves and others whom it does not know."""
    kinds = [Kind("shark", 3), Kind("wolf", 4)]
    spec = Spec(
        FORMS[form].name, agents=agents, seed=5, size=(SIDE,) * dim, kinds=kinds,
        parameters={"eta": 0.0, "v0": 0.08},
    )  # fmt: skip
    return Flock(spec.taking(**words), interpret=interpret)


def demand_naive(flock, ticks=4, delay=0):
    """The flock goes as the plain loops do."""
    turns = np.argsort(flock.ids) if flock.options.activation == "sequential" else None
    p, size = flock.parameters, np.array(flock.world.size)
    known = p.v0, p.r, p.fear, p.hunger, size
    kind = flock.arrays.kind.astype(int)
    position, heading = known_kinds.run(
        flock.position, flock.heading, kind, *known, ticks, turns, delay
    )
    flock.run(ticks)
    off = flock.position - position
    assert np.abs(off - size * np.round(off / size)).max() < 1e-9
    assert np.abs(flock.heading - heading).max() < 1e-9


WAYS = {"at-once": {}, "in-turn": {"activation": "sequential"}, "late": {"delay": 2}}


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("form", FORMS)
def test_in_plain_python_agents_go_by_kinds_as_plain_loops_do(form, way, dim):
    words = WAYS[way]
    flock = herd(form, dim, agents=10, interpret=True, **words)
    demand_naive(flock, delay=words.get("delay", 0))


@pytest.mark.parametrize("form", FORMS)
def test_compiled_agents_go_by_kinds_as_plain_loops_do(form):
    demand_naive(herd(form))


@pytest.mark.exhaustive
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("form", FORMS)
def test_compiled_agents_do_so_in_every_way(form, way, dim):
    words = WAYS[way]
    demand_naive(herd(form, dim, agents=40, **words), delay=words.get("delay", 0))


def test_kinds_that_a_rule_knows_come_first_and_are_there_without_agents():
    flock = herd("blocks")
    assert flock.kinds.names == ("flock", "wolf", "shark")
    assert (flock.arrays.kind == WOLF).sum() == 4
    relations = {
        (one, other): flock.kinds.of(one, other).deed
        for one in flock.kinds.names
        for other in flock.kinds.names
    }
    assert {pair for pair, deed in relations.items() if deed == "own"} == {
        ("flock", "flock"), ("flock", "wolf"), ("wolf", "flock"), ("wolf", "wolf"),
        ("shark", "shark"),
    }  # fmt: skip
    alone = Flock("herd-blocks", agents=5, rng=1)
    assert alone.kinds.names == ("flock", "wolf")
    assert len(alone.rows_of("wolf")) == 0
    assert len(alone.ids) == 5
    assert alone.warning == ""
    assert not OBSERVABLES["kind-distance"].applies(alone)
    assert OBSERVABLES["kind-distance"].applies(flock)
    assert Flock(alone.spec).spec == alone.spec
    assert Spec.from_toml(alone.spec.to_toml()).kinds == alone.spec.kinds


def test_a_relation_says_otherwise():
    """Sheep that ignore wolves meet only each other, and wolves that chase are fled from."""
    ignored = herd("blocks", agents=10, interpret=True)
    ignored.relate("flock", "wolf", "ignore")
    mine = ignored.rows_of("flock")
    alone = Flock(
        "herd-blocks", rng=5, size=SIDE, eta=0.0, v0=0.08, interpret=True,
        start={"position": ignored.position[mine], "heading": ignored.heading[mine]},
    )  # fmt: skip
    for flock in (ignored, alone):
        flock.run(3)
    assert np.allclose(ignored.position[mine], alone.position)
    table = complete_kinds(("wolf",), (Kind("wolf", 2, to={"flock": chase(2.0)}),), {})
    assert table.of("flock", "wolf").deed == "flee"
    assert complete_kinds((), (), {}).names == ("flock",)


def test_an_inspected_agent_weighs_by_kinds(monkeypatch):
    @compiled
    def weigh(me, near, p, out):  # noqa: ARG001
        for j in range(near.n):
            out[j] = 1.0 + 10.0 * near.kind[j] + 100.0 * me.kind

    rule = replace(BLOCKS, name="herd-weighed", weigh=weigh)
    monkeypatch.setitem(catalogue.MODELS, rule.name, Model(rule, CONSTANT_SPEED))
    flock = Flock(Spec("herd-weighed", agents=10, seed=2, size=1.5, kinds=[Kind("wolf", 5)]))
    row = int(flock.rows_of("wolf")[0])
    seen = flock.inspect(row)
    assert set(flock.arrays.kind[seen.neighbours]) == {SHEEP, WOLF}
    assert np.array_equal(seen.weights, 101.0 + 10.0 * flock.arrays.kind[seen.neighbours])


def test_a_rule_that_declares_no_kinds_sees_those_of_the_flock():
    """Who takes whom as its own may read the number of its kind; alone all are ordinary."""

    @compiled
    def count(me, near, surroundings, p):  # noqa: ARG001
        total = 0.0
        for j in range(near.n):
            total += adjacent(me, near, j, p.r) * near.kind[j]
        return Decision(me.ux + total, me.uy, me.uz)

    rule = replace(VEM, name="reader", decide=count, term=None, answer=None, sums=0, by_lanes=False)
    catalogue.MODELS["reader"] = Model(rule, CONSTANT_SPEED)
    try:
        start = {"position": [[1.0, 1.0], [1.5, 1.0]], "heading": [[0.0, 1.0]] * 2}
        words = {"seed": 1, "size": SIDE, "parameters": {"eta": 0.0}}
        alone = Flock(Spec("reader", **words), start=start, interpret=True)
        kinds = [Kind("a", 1)]
        two = Flock(
            Spec("reader", kinds=kinds, to={"a": "own"}, **words), start=start, interpret=True
        )
        alone.run(1)
        two.run(1)
        assert alone.heading.tolist() == [[0.0, 1.0]] * 2
        assert np.allclose(two.heading, [np.array([1.0, 1.0]) / math.sqrt(2.0), [0.0, 1.0]])
    finally:
        del catalogue.MODELS["reader"]


@pytest.mark.parametrize(
    ("kinds", "message"),
    [
        ("wolf", "kinds = 'wolf' is no tuple of names"),
        (("flock",), "kind 'flock' is not allowed"),
        (("wolf", "wolf"), "two kinds are called wolf"),
        (tuple(f"k{n}" for n in range(9)), "9 kinds are not allowed: 8 at most"),
    ],
)
def test_kinds_that_cannot_be_are_refused_where_they_are_declared(kinds, message):
    with pytest.raises(TypeError, match=message):
        replace(BLOCKS, kinds=kinds)


def test_too_many_beside_those_that_a_rule_knows_are_refused():
    with pytest.raises(InputError, match="9 kinds are not allowed: 8 at most"):
        Flock(Spec("herd-blocks", agents=5, seed=1, kinds=[Kind(f"k{n}", 1) for n in range(8)]))


def test_a_saved_herd_goes_on_to_the_bit(tmp_path):
    flock = herd("lanes")
    flock.run(5)
    flock.save(tmp_path / "herd.parquet")
    again = Flock.load(tmp_path / "herd.parquet")
    for one in (flock, again):
        one.run(5)
    assert np.array_equal(flock.position, again.position)
    assert again.kinds == flock.kinds


@pytest.mark.exhaustive
@pytest.mark.parametrize("check", CHECKS)
@pytest.mark.parametrize("form", FORMS)
def test_a_rule_that_knows_kinds_conforms(form, check):
    found = outcome(MODELS[FORMS[form].name], check)
    assert found.result != "fails", found.reason
