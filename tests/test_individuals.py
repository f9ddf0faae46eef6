"""Check parameters that differ from agent to agent: draws, ticks, files, and what is refused."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.individuals import (
    Distribution,
    as_distribution,
    draw_values,
    each,
    lognormal,
    normal,
    one_of,
    uniform,
)
from agents.kinds import Kind
from agents.models.declare import declared
from agents.spec import Spec
from worlds.input_error import InputError

ROUNDING = 1e-14
"""Where a rule goes over a block of agents, compiled code may add it up in another order."""


def spreads(model):
    """A spread of a fifth about the default of all that can differ, unless others are shown it."""
    shown = model.parameters_read(model.rule.show) if model.rule.show else frozenset()
    found = {}
    for declaration in declared(model.parameters):
        name = declaration.name
        if name not in model.individual or name in shown:
            continue
        middle, top = declaration.default, 0.1 * declaration.proposed[1]
        low, high = sorted((0.8 * middle, 1.2 * middle)) if middle else (0.0, top)
        low, high = max(low, declaration.low), min(high, declaration.high)
        if low < high:
            found[name] = uniform(low, high)
    return found


def as_uniform(flock, state, row):
    """The flock at a state, with the numbers of the agent of a row for all."""
    alike = state.arrays._replace(own=np.empty((len(state.ids), 0)))
    flock.return_to(
        replace(state, parameters=state.parameters_of(row), individuals={}, arrays=alike)
    )


def demand_own_numbers(name, agents=18, ticks=8, rows=6, **words):
    """Each agent of a flock moves as in a flock in which all have its numbers."""
    model = MODELS[name]
    flock = Flock(name, agents=agents, rng=5, **spreads(model), **words)
    alike = Flock(name, agents=agents, rng=5, **words)
    flock.run(ticks)
    state = flock.snapshot()
    flock.run(1)
    off = 0.0
    for row in range(0, len(flock.ids), max(1, len(flock.ids) // rows)):
        as_uniform(alike, state, row)
        alike.run(1)
        off = max(off, np.abs(alike.position[row] - flock.position[row]).max())
        off = max(off, np.abs(alike.heading[row] - flock.heading[row]).max())
    return off


@pytest.mark.parametrize("name", ["vem", "couzin"])
def test_each_moves_as_a_flock_with_its_numbers_to_the_bit(name):
    assert demand_own_numbers(name) == 0.0


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", MODELS)
def test_each_moves_as_a_flock_with_its_numbers(name):
    if spreads(MODELS[name]):
        assert demand_own_numbers(name) <= ROUNDING * max(
            1.0, max(MODELS[name].parameters().model_dump().get("m", 1.0), 1.0)
        )


@pytest.mark.parametrize(
    "words",
    [{"activation": "random"}, {"delay": 2.0}, {"noise": "vectorial"}, {"dim": 3}],
    ids=lambda words: "-".join(map(str, words)),
)
def test_in_turn_late_and_in_space_they_do_so_too(words):
    """In turn the agents before it have moved by their own numbers: only the first is compared."""
    model = MODELS["vem"]
    flock = Flock("vem", agents=20, rng=2, **spreads(model), **words)
    alike = Flock("vem", agents=20, rng=2, **words)
    for _ in range(4):
        flock.run(1)
    state = flock.snapshot()
    flock.run(1)
    off = []
    for row in range(20):
        as_uniform(alike, state, row)
        alike.run(1)
        off.append(np.abs(alike.position[row] - flock.position[row]).max())
    assert min(off) == 0.0 if "activation" in words else max(off) <= ROUNDING


@pytest.mark.parametrize("threads", [1, 2])
def test_one_number_for_all_has_the_bits_of_a_shared_one(threads):
    flock = Flock("vem", agents=100, rng=3)
    own = Flock("vem", agents=100, rng=3, threads=threads, eta=each([flock.eta] * 100))
    own.split_from = 2
    flock.run(40)
    own.run(40)
    assert np.array_equal(flock.position, own.position)
    assert np.array_equal(flock.heading, own.heading)


def test_alone_each_goes_at_its_own_speed_and_turns_by_its_own_noise():
    """Agents that meet nobody: the way per tick is v0, the mean cosine of turns that of a wide
    uniform angle, 2 sin(eta / 2) / eta."""
    eta = np.repeat([0.5, 3.0], 400)
    flock = Flock("vem", agents=800, rng=1, r=0.05, v0=uniform(0.01, 0.05), eta=eta, size=1000.0)
    speed, before = flock.own["v0"].copy(), flock.heading.copy()
    start = flock.position.copy()
    flock.run(1)
    way = np.linalg.norm(flock.position - start, axis=1)
    inside = way < 1.0
    assert np.allclose(way[inside], speed[inside], atol=1e-12)
    cosine = (before * flock.heading).sum(axis=1)
    for value in (0.5, 3.0):
        expected = 2.0 * np.sin(value / 2.0) / value
        assert abs(cosine[eta == value].mean() - expected) < 5.0 * cosine[eta == value].std() / 20.0


def test_the_plain_python_of_a_model_moves_them_alike():
    words = {"agents": 8, "rng": 4, "s": normal(3.0, 0.5), "r_r": uniform(0.5, 1.5)}
    compiled, plain = Flock("couzin", **words), Flock("couzin", interpret=True, **words)
    compiled.run(3)
    plain.run(3)
    assert np.allclose(compiled.position, plain.position, atol=1e-9)


# What is drawn.


@given(
    st.sampled_from([normal(3.0, 0.5), lognormal(2.0, 1.0), uniform(1.0, 2.0), one_of(1.0, 2.0)]),
    st.integers(0, 2**63 - 1),
    st.integers(1, 60),
)
def test_one_agent_more_changes_nobody_elses_number(distribution, seed, n):
    ids = np.arange(1, n + 1)
    some, _ = draw_values(distribution, seed, "s", ids, (-1e9, 1e9))
    more, _ = draw_values(distribution, seed, "s", np.arange(1, n + 2), (-1e9, 1e9))
    assert np.array_equal(some, more[:n])


@pytest.mark.parametrize(
    ("distribution", "mean", "deviation"),
    [
        (normal(3.0, 0.5), 3.0, 0.5),
        (lognormal(2.0, 0.8), 2.0, 0.8),
        (uniform(1.0, 4.0), 2.5, 3.0 / 12.0**0.5),
        (one_of(1.0, 3.0), 2.0, 1.0),
    ],
    ids=str,
)
def test_draws_have_the_mean_and_the_deviation(distribution, mean, deviation):
    n = 20_000
    values, redrawn = draw_values(distribution, 7, "s", np.arange(n), (-1e9, 1e9))
    assert redrawn == 0
    assert abs(values.mean() - mean) < 5.0 * deviation / n**0.5
    assert abs(values.std() - deviation) < 0.05 * deviation


def test_another_spread_moves_the_same_draws():
    ids = np.arange(100)
    narrow, _ = draw_values(normal(3.0, 0.1), 7, "s", ids, (-99.0, 99.0))
    wide, _ = draw_values(normal(3.0, 0.4), 7, "s", ids, (-99.0, 99.0))
    assert np.allclose((wide - 3.0) / (narrow - 3.0), 4.0)
    none, _ = draw_values(normal(3.0, 0.0), 7, "s", ids, (-99.0, 99.0))
    assert (none == 3.0).all()


def test_what_is_outside_of_the_range_is_drawn_again_and_said():
    flock = Flock("vem", agents=200, rng=1, eta=normal(0.1, 0.3))
    own = flock.own["eta"]
    assert own.min() >= 0.0
    assert f"{flock.redrawn['eta']} numbers of 200 drawn again" in flock.warning
    assert Flock("vem", agents=20, rng=1).warning == ""
    with pytest.raises(InputError, match="next to nothing of it is in"):
        draw_values(normal(-50.0, 0.1), 1, "eta", np.arange(3), (0.0, 1.0))


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("normal(3, .5)", normal(3.0, 0.5)),
        ("normal:3:0.5", normal(3.0, 0.5)),
        (" uniform( 1 ,2 ) ", uniform(1.0, 2.0)),
        ("one_of(1,2,3)", one_of(1.0, 2.0, 3.0)),
        ({"lognormal": [2, 1]}, lognormal(2.0, 1.0)),
        ([1, 2], each([1.0, 2.0])),
        (3.0, None),
        ("nearest", None),
        (True, None),
    ],
)
def test_what_is_written_is_understood(text, meant):
    assert as_distribution(text) == meant


# Files, copies and scripts.


def test_a_saved_flock_goes_on_to_the_bit(tmp_path):
    flock = Flock("couzin", agents=30, rng=1, s=normal(3.0, 0.5), sigma=one_of(0.0, 0.1))
    flock.run(5)
    flock.members[4].s = 4.5
    flock.save(tmp_path / "state.parquet")
    again = Flock.load(tmp_path / "state.parquet")
    assert again.own["s"][4] == 4.5
    for copied in (pickle.loads(pickle.dumps(flock)), copy.deepcopy(flock), again):
        other = Flock.from_snapshot(flock.spec, flock.snapshot())
        other.run(10)
        copied.run(10)
        assert np.array_equal(other.position, copied.position)


def test_a_file_with_a_number_outside_of_its_range_is_refused_by_row(tmp_path):
    import pyarrow.parquet as pq

    flock = Flock("couzin", agents=5, rng=1, s=normal(3.0, 0.5))
    flock.save(tmp_path / "state.parquet")
    table = pq.read_table(tmp_path / "state.parquet")
    speeds = table["own_s"].to_pylist()
    speeds[3] = -1.0
    at = table.column_names.index("own_s")
    pq.write_table(table.set_column(at, "own_s", [speeds]), tmp_path / "wrong.parquet")
    with pytest.raises(InputError, match=r"holds a s outside of \[.*row 3 of its tick"):
        Flock.load(tmp_path / "wrong.parquet")


def test_a_spec_keeps_the_distribution():
    spec = Spec("couzin", agents=10, seed=1, parameters={"s": "normal(3,.5)", "r_r": 2.0})
    assert spec.individuals == {"s": normal(3.0, 0.5)}
    again = Spec.from_toml(spec.to_toml())
    assert again == spec
    flock = Flock(again)
    assert flock.spec.individuals == spec.individuals
    assert np.array_equal(flock.own["s"], Flock(flock.spec).own["s"])
    assert spec.taking(s=3.5).individuals == {}
    by_hand = Flock("vem", agents=4, rng=1, eta=[0.1, 0.2, 0.3, 0.4])
    assert np.array_equal(Flock(by_hand.spec).own["eta"], [0.1, 0.2, 0.3, 0.4])


def test_another_seed_draws_other_numbers():
    flock = Flock("vem", agents=20, rng=1, eta=uniform(0.0, 1.0))
    flock.restart(2)
    assert np.array_equal(
        flock.own["eta"], Flock("vem", agents=20, rng=2, eta=uniform(0.0, 1.0)).own["eta"]
    )


def test_a_running_flock_takes_and_gives_back_differences():
    flock = Flock("vem", agents=20, rng=1)
    flock.run(3)
    flock.set(eta=normal(0.5, 0.1))
    assert flock.eta.shape == (20,)
    first = flock.own["eta"].copy()
    flock.set(v0=0.04)
    assert np.array_equal(flock.own["eta"], first)
    flock.run(3)
    flock.set(eta=0.3)
    assert flock.eta == 0.3
    assert flock.own == {}
    flock.run(3)


def test_mesa_reads_and_writes_them():
    flock = Flock("couzin", agents=6, rng=1, agent_reporters={"s": "s"})
    agents = flock.agents
    agents[2].s = 4.0
    assert [agent.s for agent in agents] == [3.0, 3.0, 4.0, 3.0, 3.0, 3.0]
    flock.agents.select(lambda agent: agent.s > 3.5).set("s", 3.6)
    assert flock.own["s"].max() == 3.6
    flock.step()
    assert sorted(flock.datacollector.get_agent_vars_dataframe()["s"]) == [3.0] * 5 + [3.6]
    assert "s" in flock.to_dataframe()
    assert flock.spec.individuals["s"].kind == "each"
    with pytest.raises(InputError, match=r"s = -1\.0 .* is outside"):
        agents[0].s = -1.0
    agents[0].remove()
    flock.step()
    assert len(flock.own["s"]) == 5


def test_who_joins_draws_its_own_number():
    from agents.mesa_interface import Member

    flock = Flock("vem", agents=5, rng=1, eta=uniform(0.0, 1.0))
    drawn, _ = draw_values(uniform(0.0, 1.0), 1, "eta", np.arange(1, 7), (0.0, 9.0))
    Member(flock)
    assert flock.own["eta"][-1] == drawn[-1]
    by_hand = Flock("vem", agents=2, rng=1, eta=[0.1, 0.3])
    Member(by_hand)
    assert np.allclose(by_hand.own["eta"], [0.1, 0.3, 0.2])


def test_the_inspector_sees_an_agent_with_its_own_numbers():
    flock = Flock("couzin", agents=40, rng=1, r_r=uniform(0.5, 1.5), dr_o=uniform(1.0, 9.0))
    flock.run(20)
    for row in (0, 7):
        zones = flock.inspect(row).shells
        assert zones[0].radius == flock.own["r_r"][row]
    near = flock.inspect(0)
    assert (np.linalg.norm(near.separation, axis=1) <= near.shells[-1].radius).all()


def test_links_are_of_those_who_notice_one_another():
    flock = Flock("vem", agents=60, rng=1, r=one_of(0.2, 1.0), size=4.0)
    r = flock.own["r"]
    distance = np.abs(flock.position[:, None] - flock.position[None])
    distance = np.linalg.norm(np.minimum(distance, 4.0 - distance), axis=2)
    meets = (distance <= np.maximum(r[:, None], r[None])) & (distance > 0.0)
    assert {tuple(pair) for pair in flock.links().tolist()} == {
        (i, j) for i, j in np.argwhere(meets).tolist() if i < j
    }
    assert flock.reach == 1.0


# What is refused.


@pytest.mark.parametrize(
    ("model", "words", "message"),
    [
        ("vem", {"eta": [0.1, 0.2]}, "eta has 2 values for 5 agents: one each is needed"),
        ("vem", {"eta": [0.1, 0.2, 99.0, 0.1, 0.1]}, r"eta = 99 in row 2 is outside \[0, 6\.28"),
        ("vem", {"eta": "normal(1, nan)"}, "finite numbers are needed"),
        ("vem", {"eta": "normal(1, -2)"}, "a standard deviation is >= 0"),
        ("vem", {"eta": "normal(1)"}, "a mean and a standard deviation are needed"),
        ("vem", {"eta": "normal(1, x)"}, "finite numbers are needed"),
        ("vem", {"eta": {"gamma": [1, 2]}}, "unknown distribution 'gamma'"),
        ("vem", {"eta": {}}, "is not a distribution"),
        ("vem", {"eta": "uniform(2, 1)"}, "the low comes first"),
        ("vem", {"eta": "lognormal(0, 1)"}, "the mean of a lognormal is > 0"),
        ("vem", {"spped": "normal(1, 2)"}, "unknown parameter 'spped'"),
        ("couzin", {"tau": "normal(0.1, .01)"}, "tau cannot differ .* a tick is as long for all"),
        (
            "vem",
            {"k": "one_of(3, 4)"},
            "k cannot differ from agent to agent in vem: as many nearest",
        ),
        ("vem", {"neighbours": ["metric"]}, "finite numbers are needed"),
        ("hwvem", {"r": "normal(1, .1)"}, "r cannot differ .* looks at the whole flock"),
    ],
)
def test_what_is_wrong_is_refused_in_one_line(model, words, message):
    with pytest.raises(InputError, match=message) as refusal:
        Flock(model, agents=5, rng=1, **words)
    assert "\n" not in str(refusal.value)


def test_ranks_are_refused():
    with pytest.raises(InputError, match="agents differ in eta"):
        Flock("vem", agents=50, rng=1, eta=uniform(0.0, 1.0), ranks=2)


def test_a_refused_change_changes_nothing():
    flock = Flock("vem", agents=5, rng=1, eta=uniform(0.0, 1.0))
    before = flock.own["eta"].copy()
    for values in ({"eta": [1.0]}, {"k": [1.0] * 5}, {"eta": 0.3, "v0": -1.0}):
        with pytest.raises(InputError):
            flock.set(**values)
    assert np.array_equal(flock.own["eta"], before)
    assert isinstance(flock.individuals["eta"], Distribution)


def test_a_list_is_in_the_order_of_rows_also_of_a_kind_and_once_it_is_set_again():
    numbers, of_two = np.linspace(0.01, 0.05, 42), [0.1, 0.2]
    two = Kind("two", 2, v0=each(of_two), to={"flock": "own"})
    flock = Flock("vem", agents=40, rng=3, v0=each(numbers), kinds=[two])
    assert not np.array_equal(flock.ids, np.sort(flock.ids)), "rows follow space"
    is_two = flock.kind_names == "two"
    before = flock.own["v0"].copy()
    assert before[~is_two].tolist() == numbers[~is_two].tolist()
    assert before[is_two].tolist() == of_two
    flock.set(v0=each(numbers))
    assert flock.own["v0"].tolist() == before.tolist()
    flock.restart(3)
    assert flock.own["v0"].tolist() == before.tolist()
