"""Check kinds of agents: whom each heeds, who catches whom, in ticks, files, scripts and words."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.individuals import normal
from agents.kinds import Kind, chase, flee
from agents.mesa_interface import Member
from agents.observables.catalogue import find_observable
from agents.spec import Spec
from worlds.input_error import InputError
from worlds.world import World

SIZE = 6.0


def separations(position, size):
    """From each agent to each, to the nearest image, (N, N, dim)."""
    away = position[None] - position[:, None]
    return away - size * np.floor(away / size + 0.5)


def naive_wishes(flock, relations, r, size):
    """The wishes of Vicsek's agents with relations {(kind, kind): (weight, radius)}, (N, dim).

    Mean heading of one's own kind within r; then e_ij (1 - d / R) of all others that are related.
    """
    away = separations(flock.position, size)
    distance = np.linalg.norm(away, axis=2)
    kind = flock.arrays.kind
    near = (kind[:, None] == kind[None]) & (distance <= r)
    wish = (near[..., None] * flock.heading[None]).sum(axis=1) / near.sum(axis=1)[:, None]
    for (mine, other), (weight, radius) in relations.items():
        met = (kind[:, None] == mine) & (kind[None] == other)
        met &= (distance > 0.0) & (distance <= radius)
        share = np.where(met, weight * (1.0 - distance / radius), 0.0)
        wish = wish + (share / np.where(distance > 0.0, distance, 1.0))[..., None].repeat(
            wish.shape[1], axis=2
        ).__mul__(away).sum(axis=1)
    return wish


def hunt(model="vem", **words):
    """A flock with three hunters that are faster."""
    sharks = Kind("shark", 3, v0=0.05, to={"flock": chase(1.5, 2.0)})
    to = {"shark": flee(2.0, 0.8)}
    return Flock(Spec(model, agents=60, seed=3, size=SIZE, kinds=[sharks], to=to).taking(**words))


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.sampled_from([2, 3]), st.booleans())
def test_a_tick_is_that_of_the_naive_flock(seed, dim, interpret):
    n = 24 if not interpret else 8
    spec = Spec(
        "vem", agents=n, seed=seed, size=(3.0,) * dim, parameters={"eta": 0.0},
        kinds=[Kind("shark", 3, v0=0.05, to={"flock": chase(1.5, 1.4)})],
        to={"shark": flee(2.0, 0.8)},
    )  # fmt: skip
    flock = Flock(spec, interpret=interpret)
    relations = {(0.0, 1.0): (-2.0, 0.8), (1.0, 0.0): (1.5, 1.4)}
    wish = naive_wishes(flock, relations, flock.parameters.r, 3.0)
    heading = wish / np.linalg.norm(wish, axis=1)[:, None]
    position = (flock.position + flock.own["v0"][:, None] * heading) % 3.0
    flock.run(1)
    off = separations(np.stack([position, flock.position]).reshape(-1, dim), 3.0)
    assert np.allclose(flock.heading, heading, atol=1e-9)
    assert (
        np.abs(off[np.arange(len(position)), np.arange(len(position)) + len(position)]).max() < 1e-9
    )


def equal_kinds(name, **words):
    """A flock of one kind, and one of two that take each other as their own; 25 ticks of both."""
    model = MODELS[name]
    if "neighbours" in model.parameters.model_fields:
        words = {"neighbours": "metric"} | words
    alike = Flock(name, agents=24, rng=3, **words)
    spec = alike.spec.but(agents=16, kinds=[Kind("b", 8, to={"flock": "own"})], to={"b": "own"})
    kinds = Flock(spec)
    alike.run(25)
    kinds.run(25)
    assert model.name == name
    return alike, kinds


def test_two_kinds_that_are_equal_have_the_bits_of_one():
    for name in ("vem", "hwvem", "couzin"):
        alike, kinds = equal_kinds(name)
        assert np.array_equal(alike.position, kinds.position)
        assert np.array_equal(alike.heading, kinds.heading)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", MODELS)
def test_two_equal_kinds_of_any_model_fly_as_one(name):
    alike, kinds = equal_kinds(name)
    far = max(1.0, np.abs(alike.position).max())
    assert np.abs(alike.position - kinds.position).max() <= 1e-9 * far


@pytest.mark.parametrize(
    "words", [{"activation": "random"}, {"delay": 2.0}, {"noise": "vectorial"}],
    ids=lambda words: next(iter(words)),
)  # fmt: skip
def test_equal_kinds_are_one_in_turn_and_late_too(words):
    alike, kinds = equal_kinds("vem", **words)
    assert np.allclose(alike.position, kinds.position, atol=1e-12)


def test_who_is_ignored_is_not_met():
    """Two kinds that ignore each other: the ordinary agents fly as if they were alone."""
    parameters = {"eta": 0.0}
    kinds = [Kind("b", 20)]
    both = Flock(Spec("vem", agents=30, seed=1, size=SIZE, parameters=parameters, kinds=kinds))
    mine = both.rows_of("flock")
    start = {"position": both.position[mine], "heading": both.heading[mine]}
    alone = Flock("vem", rng=1, size=SIZE, eta=0.0, start=start)
    both.run(40)
    alone.run(40)
    assert np.allclose(both.position[mine], alone.position, atol=1e-9)


def test_what_comes_first_is_all_that_counts():
    start = {"position": [[1.0, 1.0], [1.5, 1.0], [1.0, 1.4]], "heading": [[0.0, 1.0]] * 3}
    spec = Spec(
        "vem", seed=1, size=SIZE, parameters={"eta": 0.0},
        kinds=[Kind("shark", 1)], to={"shark": flee(1.0, 2.0, first=True)},
    )  # fmt: skip
    flock = Flock(spec, start=start)
    flock.run(1)
    away = np.array([1.0, 1.0]) - np.array([1.0, 1.4])
    assert np.allclose(flock.heading[0], away / np.linalg.norm(away))


@pytest.mark.parametrize("power", [None, 1.0, 2.0])
def test_the_wish_falls_with_distance_as_it_is_asked_to(power):
    start = {"position": [[1.0, 1.0], [1.0, 1.5]], "heading": [[1.0, 0.0]] * 2}
    spec = Spec(
        "vem", seed=1, size=SIZE, parameters={"eta": 0.0},
        kinds=[Kind("shark", 1)], to={"shark": chase(0.7, 2.0, power=power)},
    )  # fmt: skip
    flock = Flock(spec, start=start)
    flock.run(1)
    share = 0.7 * (1.0 - 0.5 / 2.0 if power is None else 0.5**-power)
    wish = np.array([1.0, share])
    assert np.allclose(flock.heading[0], wish / np.linalg.norm(wish))


def test_a_kind_sees_as_far_round_as_its_rule():
    """Couzin's agents have a blind angle behind them: a hunter there is not fled from."""
    behind = {"position": [[20.0, 20.0, 20.0], [15.0, 20.0, 20.0]], "heading": [[1.0, 0, 0]] * 2}
    for alpha, turns in ((90.0, False), (360.0, True)):
        spec = Spec(
            "couzin", seed=1, parameters={"alpha": alpha, "sigma": 0.0},
            kinds=[Kind("shark", 1)], to={"shark": flee(1.0, 10.0)},
        )  # fmt: skip
        flock = Flock(spec, start={**behind, "heading": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]})
        flock.heading[0] = [0.6, 0.8, 0.0]
        flock.run(1)
        assert (abs(flock.heading[0] - [0.6, 0.8, 0.0]).max() > 1e-6) == turns


@pytest.mark.parametrize("words", [{"activation": "sequential"}, {"delay": 2.0}, {}], ids=str)
def test_prey_flee_and_hunters_follow_in_every_kind_of_tick(words):
    flock = hunt(**words)
    flock.run(60)
    assert flock.observe("kind-distance") > 0.0
    assert np.isfinite(flock.position).all()


def test_threads_change_nothing():
    one, two = hunt(agents=300), Flock(hunt(agents=300).spec, threads=2)
    two.split_from = 2
    one.run(30)
    two.run(30)
    assert np.array_equal(one.position, two.position)


# Catches.


def meeting(caught, hunters=1, speed=0.0, **more):
    """Prey at (1, 1), (1.3, 1), (3, 3), which stand still, and hunters near the first."""
    places = [[1.0, 1.0], [1.3, 1.0], [3.0, 3.0], *([1.05 + 0.02 * k, 1.0] for k in range(hunters))]
    sharks = Kind(
        "shark", hunters, v0=speed, to={"flock": chase(0.0, 1.0, catch=0.2, caught=caught)}
    )
    spec = Spec(
        "vem", seed=1, size=SIZE, parameters={"eta": 0.0, "v0": 0.0}, kinds=[sharks],
        to={"shark": "ignore"}, **more,
    )  # fmt: skip
    return Flock(spec, start={"position": places, "heading": [[1.0, 0.0]] * len(places)})


def test_who_is_taken_leaves_the_flock():
    flock = meeting("taken")
    flock.run(1)
    assert flock.ids.tolist() == [2, 3, 4]
    assert flock.catches.id.tolist() == [1]
    assert flock.catches.gate.tolist() == [4]
    assert flock.observe("catches") == 1
    flock.run(5)
    assert flock.observe("catches") == 1


def test_who_is_frozen_stands_still_and_is_met_by_nobody():
    flock = meeting("frozen")
    flock.run(3)
    assert flock.kind_names.tolist() == ["caught", "flock", "flock", "shark"]
    assert flock.position[0].tolist() == [1.0, 1.0]
    assert len(flock.snapshot().measurable().ids) == 3
    assert flock.observe("catches") == 1


def test_who_is_moved_begins_anew_elsewhere():
    flock, again = meeting("moved"), meeting("moved")
    flock.run(1)
    again.run(1)
    assert np.linalg.norm(flock.position[0] - [1.0, 1.0]) > 0.2
    assert np.array_equal(flock.position, again.position)
    assert len(flock.ids) == 4


def test_who_is_counted_is_counted_in_every_tick():
    flock = meeting("counted")
    flock.run(4)
    assert flock.observe("catches") == 4


def test_of_two_that_claim_one_the_nearer_has_it_and_one_catches_one_at_most():
    flock = meeting("taken", hunters=2)
    flock.run(1)
    assert flock.catches.gate.tolist() == [4]
    both = meeting("taken", hunters=9)
    both.run(1)
    assert sorted(both.catches.id.tolist()) == [1, 2]


def test_a_hunter_that_runs_past_within_a_tick_catches():
    flock = meeting("taken", speed=0.9)
    flock.position[3] = [0.5, 1.05]
    flock.run(1)
    assert flock.position[-1, 0] > 1.35
    assert flock.catches.id.tolist() == [1]


@pytest.mark.parametrize("caught", ["taken", "counted"])
def test_a_hunter_of_its_own_kind_catches_another_and_never_itself(caught):
    """Two within reach of each other catch each other; who is alone is caught by nobody."""
    cannibal = Kind("shark", 3, v0=0.0, to={"shark": chase(0.0, 1.0, catch=0.2, caught=caught)})
    spec = Spec("vem", seed=1, size=SIZE, parameters={"eta": 0.0}, kinds=[cannibal])
    places = [[1.0, 1.0], [1.1, 1.0], [4.0, 4.0]]
    flock = Flock(spec, start={"position": places, "heading": [[1.0, 0.0]] * 3})
    flock.run(1)
    assert sorted(zip(flock.catches.gate.tolist(), flock.catches.id.tolist(), strict=True)) == [
        (1, 2),
        (2, 1),
    ]
    assert flock.ids.tolist() == ([3] if caught == "taken" else [1, 2, 3])


def test_a_flock_whose_prey_is_gone_says_so_and_runs_on():
    flock = meeting("taken")
    flock.position[:3] = [1.0, 1.0]
    flock.run(10)
    assert flock.rows_of("flock").tolist() == []
    assert "nobody of kind flock is left" in flock.warning
    flock.run(10)


# Files, copies, scripts.


def test_a_hunt_that_is_begun_again_has_the_relations_that_it_was_made_with():
    flock = hunt()
    flock.run(10)
    before = flock.position.copy()
    flock.relate("shark", "flock", chase(5.0, 2.0))
    flock.restart(3)
    flock.run(10)
    assert np.array_equal(flock.position, before)


def test_a_saved_hunt_goes_on_to_the_bit(tmp_path):
    flock = hunt()
    flock.relate("shark", "flock", chase(1.5, 2.0, catch=0.3))
    flock.run(40)
    assert flock.observe("catches") > 0
    flock.save(tmp_path / "hunt.parquet")
    again = Flock.load(tmp_path / "hunt.parquet")
    assert again.catches.id.tolist() == flock.catches.id.tolist()
    flock.run(20)
    again.run(20)
    assert np.array_equal(flock.position, again.position)
    assert flock.catches.id.tolist() == again.catches.id.tolist()


def test_a_spec_keeps_kinds():
    flock = Flock(
        Spec(
            "vem", agents=20, seed=1,
            kinds=[Kind("shark", 2, v0=normal(0.05, 0.01), colour="#b03a2e", start=[[0, 0], [1, 1]],
                        to={"all": {"chase": 2.0, "radius": 3.0, "catch": 0.1, "caught": "frozen"}}
                   )],
        )
    )  # fmt: skip
    again = Spec.from_toml(flock.spec.to_toml())
    assert again.kinds == flock.spec.kinds
    assert again.to_toml() == flock.spec.to_toml()
    assert np.array_equal(Flock(again).own["v0"], flock.own["v0"])
    assert (flock.position[flock.rows_of("shark")] <= 1.0).all()
    assert flock.kinds.of("flock", "shark").deed == "flee"


def test_a_kind_has_its_own_numbers_and_another_spread_of_all_leaves_them():
    flock = hunt(v0=normal(0.03, 0.002))
    sharks, prey = flock.rows_of("shark"), flock.rows_of("prey")
    assert (flock.own["v0"][sharks] == 0.05).all()
    assert flock.own["v0"][prey].std() > 0.0
    flock.set(v0=0.02)
    assert (flock.own["v0"][sharks] == 0.05).all()
    flock.set_kind("shark", v0=0.07)
    assert (flock.own["v0"][sharks] == 0.07).all()
    assert (flock.own["v0"][prey] == 0.02).all()


def test_numbers_of_a_kind_that_are_drawn_again_are_said():
    kinds = [Kind("shark", 30, v0=0.05, eta=normal(0.1, 0.3))]
    flock = Flock(Spec("vem", agents=40, seed=1, parameters={"eta": normal(0.1, 0.3)}, kinds=kinds))
    sharks, prey = flock.redrawn["eta of shark"], flock.redrawn["eta"]
    assert sharks > 0
    assert prey > 0
    assert (flock.own["eta"] >= 0.0).all()
    said = "outside of the range of the parameter"
    assert f"eta of shark = normal(0.1, 0.3): {sharks} numbers of 30 drawn again, {said}" in (
        flock.warning
    )
    assert f"eta = normal(0.1, 0.3): {prey} numbers of 40 drawn again, {said}" in flock.warning
    assert "v0" not in flock.warning
    flock.set_kind("shark", eta=0.2)
    assert "shark" not in flock.warning


def test_numbers_of_a_kind_stay_as_they_were_set_by_hand_when_something_else_changes():
    flock = hunt(agents=10)
    sharks = flock.rows_of("shark")
    flock.members[sharks[0]].v0 = 0.06
    flock.relate("shark", "flock", chase(1.0, 1.0))
    flock.set(v0=0.02)
    flock.set_kind("shark", eta=0.1)
    assert flock.own["v0"][sharks].tolist() == [0.06, 0.05, 0.05]
    flock.set_kind("shark", v0=0.04)
    assert flock.own["v0"][sharks].tolist() == [0.04] * 3


def test_who_joins_a_flock_whose_kind_has_numbers_agent_by_agent_is_ordinary():
    kinds = [Kind("shark", 2, v0=[0.04, 0.05])]
    flock = Flock(Spec("vem", agents=3, seed=1, kinds=kinds))
    Member(flock)
    assert flock.kind_names[-1] == "flock"
    assert flock.own["v0"][flock.rows_of("shark")].tolist() == [0.04, 0.05]


def test_mesa_groups_and_selects_by_kind():
    flock = hunt(agents=10)
    groups = dict(flock.agents.groupby("kind"))
    assert {name: len(agents) for name, agents in groups.items()} == {"flock": 10, "shark": 3}
    sharks = flock.agents.select(lambda agent: agent.kind == "shark")
    sharks.set("v0", 0.06)
    assert flock.own["v0"].max() == 0.06
    assert set(flock.to_dataframe()["kind"]) == {"flock", "shark"}
    assert flock.observe("polarisation", kind="shark") != flock.observe("polarisation")


def test_information_agents_are_asked_for_as_a_kind_is():
    flock = Flock("hwvem", agents=20, informed=3, rng=1)
    flock.run(2)
    rows = flock.rows_of("informed")
    assert rows.tolist() == np.flatnonzero(flock.informed).tolist()
    mean = np.linalg.norm(flock.heading[rows].mean(axis=0))
    assert np.isclose(flock.observe("polarisation", kind="informed"), mean)
    one = find_observable("polarisation of informed")
    assert one.applies(flock)
    assert np.isclose(one.measure(flock.snapshot()), mean)
    assert not one.applies(Flock("vem", agents=5, rng=1))
    with pytest.raises(InputError, match="unknown kind 'informd': did you mean 'informed'"):
        flock.rows_of("informd")


def test_a_kind_that_is_called_informed_is_asked_for_by_its_name():
    flock = Flock(Spec("vem", agents=5, seed=1, kinds=[Kind("informed", 2)]))
    assert len(flock.rows_of("informed")) == 2
    assert (flock.kind_names[flock.rows_of("informed")] == "informed").all()


def test_information_agents_that_were_caught_are_not_among_them():
    flock = meeting("frozen")
    flock.informed[0] = True
    flock.run(1)
    assert flock.kind_names[0] == "caught"
    assert len(flock.rows_of("informed")) == 0


def test_each_follows_from_its_seed_and_identity_alone():
    """Two more hunters leave the ordinary agents where they start."""
    spec = Spec("vem", agents=20, seed=5, size=SIZE, kinds=[Kind("shark", 1)])
    few, many = Flock(spec), Flock(spec.but(kinds=[Kind("shark", 3)]))
    by_id = dict(zip(many.ids.tolist(), many.position.tolist(), strict=True))
    ordinary = few.rows_of("flock")
    assert [by_id[k] for k in few.ids[ordinary].tolist()] == few.position[ordinary].tolist()


# What is refused.


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"kinds": [{"agents": 2}]}, "a kind has no name"),
        ({"kinds": [Kind("a", 1), Kind("a", 1)]}, "two kinds are called a"),
        ({"kinds": [{"name": "flock"}]}, "kind 'flock' is not allowed"),
        ({"kinds": [{"name": "a", "agents": -1}]}, "kind a: agents = -1 is not allowed"),
        ({"kinds": [{"name": "a", "colour": "red"}]}, "colour = 'red' of kind a is not #rrggbb"),
        ({"kinds": [{"name": "a", "hunts": 1}]}, "unknown key of a kind 'hunts'"),
        ({"kinds": [Kind("a", 1, v0=99.0)]}, r"kind a: v0 = 99\.0 .* is outside"),
        ({"kinds": [Kind("a", 1, vo=0.1)]}, "kind a: unknown parameter 'vo'"),
        ({"kinds": [Kind("a", 1, k=3.0)]}, "kind a: k cannot differ"),
        ({"kinds": [Kind("a", 1, to={"b": "flee"})]}, r"unknown kind 'b' .*\(flee of a\)"),
        ({"kinds": [{"name": "a", "to": {"flock": {"hunt": 1.0}}}]}, "kind a: unknown key 'hunt'"),
        ({"kinds": [{"name": "a", "to": {"flock": {"flee": -1.0}}}]}, "weight = -1.0 of flee"),
        ({"kinds": [{"name": "a", "to": {"flock": {"flee": 1, "chase": 1}}}]}, "is not a relation"),
        ({"kinds": [{"name": "a", "to": {"flock": {"flee": 1, "catch": 1}}}]}, "only who chases"),
        ({"to": {"a": "flee"}}, r"unknown kind 'a' .*\(flee of flock\)"),
        ({"kinds": [Kind(f"k{n}", 1) for n in range(9)]}, "9 kinds are not allowed: 8 at most"),
        ({"kinds": [Kind("a", 1, start=[[0, 0, 0], [1, 1, 1]])]}, "start of kind a has 3"),
        ({"kinds": "shark"}, "a list of kinds is needed"),
        (
            {"kinds": [Kind("a", 1)], "parameters": {"neighbours": "nearest"}},
            "set neighbours=metric",
        ),
    ],
)  # fmt: skip
def test_what_is_wrong_is_refused_in_one_line(words, message):
    with pytest.raises(InputError, match=message) as refusal:
        Flock(Spec("vem", agents=5, seed=1, **words))
    assert "\n" not in str(refusal.value)


def test_more_of_kinds_than_there_are_agents_is_refused():
    start = {"position": [[1.0, 1.0]], "heading": [[1.0, 0.0]]}
    with pytest.raises(InputError, match="kinds have 3 agents, and the flock has 1"):
        Flock(Spec("vem", seed=1, size=SIZE, kinds=[Kind("a", 3)]), start=start)


def test_in_a_world_of_obstacles_they_start_clear_of_them():
    flock = Flock(
        Spec("hwvem-nav", agents=10, seed=1, kinds=[Kind("shark", 2, to={"flock": chase(1.0)})])
    )
    assert isinstance(flock.world, World)
    flock.run(30)
    assert flock.stray() is None
