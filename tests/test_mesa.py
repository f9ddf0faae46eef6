"""A flock is a Mesa model: what Mesa's own tools do with it."""

import itertools

import mesa
import numpy as np
import pytest

from agents import Flock, Member


def test_a_flock_is_a_model_and_its_members_are_agents():
    flock = Flock("hwvem", agents=20, rng=1)
    assert isinstance(flock, mesa.Model)
    assert len(flock.agents) == 21
    assert all(isinstance(agent, mesa.Agent) for agent in flock.agents)
    assert list(flock.agents_by_type) == [Member]
    assert [agent.unique_id for agent in flock.agents] == list(range(1, 22))
    assert flock.steps == 0
    flock.step()
    assert (flock.steps, flock.tick) == (1, 1)


# --- members are views ------------------------------------------------------------------------


def test_members_are_views_of_rows():
    flock = Flock("vem", agents=10, rng=2)
    member = flock.members[3]
    flock.position[3] = 0.25, 0.5
    assert member.position.tolist() == [0.25, 0.5]
    assert np.shares_memory(member.position, flock.position)
    member.position = 0.75, 0.5
    assert flock.position[3].tolist() == [0.75, 0.5]
    member.heading = 0.0, -3.0
    assert flock.heading[3].tolist() == [0.0, -1.0]
    flock.run(1)
    assert member.speed == flock.speed[3] == 0.03


def test_pos_is_what_pictures_read():
    flock = Flock("vem", agents=10, rng=2)
    for agent in flock.agents:
        assert agent.pos is not None
        assert tuple(agent.pos) == tuple(flock.position[agent.row])
    agent.pos = 0.5, 0.75
    assert flock.position[agent.row].tolist() == [0.5, 0.75]


# --- agent sets -------------------------------------------------------------------------------


def test_select_get_agg_set_and_do():
    flock = Flock("hwvem", agents=30, rng=3)
    informed = flock.agents.select(lambda agent: agent.informed)
    assert [agent.row for agent in informed] == [0]
    assert len(flock.agents.select(at_most=7)) == 7
    assert flock.agents.get("unique_id") == sorted(flock.ids.tolist()) == list(range(1, 32))
    flock.run(1)
    assert flock.agents.agg("speed", max) == pytest.approx(0.03)
    heading = np.array(flock.agents.get("heading"))
    assert np.array_equal(heading, flock.heading[np.argsort(flock.ids)])
    flock.agents.set("heading", np.array([1.0, 0.0]))
    assert flock.observe("polarisation") == 1.0
    groups = flock.agents.groupby("informed")
    assert {key: len(group) for key, group in groups} == {True: 1, False: 30}


@pytest.mark.parametrize("how", ["do", "shuffle_do"])
def test_agents_that_step_one_by_one_are_one_tick(how):
    """Synchronous ticks give the same flock in any order of stepping, to the bit."""
    whole, single = (Flock("hwvem", agents=50, rng=4, eta=0.3) for _ in range(2))
    for _ in range(5):
        whole.step()
        getattr(single.agents, how)("step")
    assert single.tick == 5
    assert np.array_equal(single.position, whole.position)
    assert np.array_equal(single.heading, whole.heading)


def test_shuffling_is_by_the_seed():
    orders = []
    for seed in (5, 5, 6):
        flock = Flock("vem", agents=40, rng=seed)
        order = []
        flock.agents.shuffle_do(lambda agent, order=order: order.append(agent.row))
        orders.append(order)
    assert orders[0] == orders[1] != orders[2]


# --- adding and removing ----------------------------------------------------------------------


def test_a_member_is_added():
    flock = Flock("vem", agents=10, size=4.0, rng=6)
    before = flock.position.copy()
    member = Member(flock, position=(1.0, 2.0), heading=(0.0, 5.0))
    assert (member.row, member.unique_id, len(flock.agents)) == (10, 11, 11)
    assert member.position.tolist() == [1.0, 2.0]
    assert member.heading.tolist() == [0.0, 1.0]
    assert np.array_equal(flock.position[:10], before)
    assert member in flock.agents
    flock.step()
    assert np.isfinite(flock.position).all()


def test_a_random_member_is_in_the_box():
    flock = Flock("vem", agents=10, rng=6, size=(2.0, 3.0))
    for _ in range(20):
        member = Member(flock)
        assert (member.position >= 0).all()
        assert (member.position < flock.world.size).all()
        assert np.linalg.norm(member.heading) == pytest.approx(1.0)


def test_a_member_leaves_and_the_others_keep_their_identity():
    flock = Flock("vem", agents=10, rng=7)
    where = {member.unique_id: member.position.copy() for member in flock.members}
    gone = flock.members[4].unique_id
    flock.members[4].remove()
    assert len(flock.agents) == len(flock.members) == 9
    assert gone not in flock.ids
    for row, member in enumerate(flock.members):
        assert member.row == row
        assert member.unique_id == flock.ids[row]
        assert np.array_equal(member.position, where[member.unique_id])
    assert Member(flock).unique_id == 11, "an identity is never given twice"
    flock.step()


def test_agents_can_leave_while_others_act():
    flock = Flock("vem", agents=30, rng=8)
    for agent in flock.agents.select(lambda agent: agent.unique_id % 3 == 0):
        agent.remove()
    assert sorted(flock.ids.tolist()) == [k for k in range(1, 31) if k % 3]
    flock.run(3)
    flock.agents.do("remove")
    assert len(flock.agents) == 0
    flock.step()


# --- data collection --------------------------------------------------------------------------


def test_the_data_collector_holds_model_and_agent_reports():
    flock = Flock(
        "vem",
        agents=5,
        rng=9,
        collect=("polarisation", "groups"),
        agent_reporters={"speed": "speed", "x": lambda agent: float(agent.position[0])},
    )
    seen = []
    for _ in range(4):
        flock.step()
        by_identity = np.argsort(flock.ids)
        seen.append((flock.observe("polarisation"), flock.position[by_identity, 0]))
    model = flock.datacollector.get_model_vars_dataframe()
    assert list(model.columns) == ["polarisation", "groups"]
    assert model["polarisation"].tolist() == [polarisation for polarisation, _ in seen]
    agents = flock.datacollector.get_agent_vars_dataframe()
    assert len(agents) == 4 * 5
    assert np.allclose(agents["speed"], 0.03)
    assert agents["x"].to_numpy().reshape(4, 5).tolist() == [x.tolist() for _, x in seen]
    assert agents.index.get_level_values("AgentID").tolist() == [1, 2, 3, 4, 5] * 4


@pytest.mark.parametrize("processes", [1, 2])
def test_batch_run(processes):
    made = mesa.batch_run(
        Flock,
        {"model": "vem", "agents": 20, "eta": [0.0, 0.5], "r": [0.5, 1.0]},
        rng=[1, 2, 3],
        max_steps=10,
        number_processes=processes,
        display_progress=False,
    )
    assert len(made) == 12
    found = {(row["eta"], row["r"], row["rng"]): row["polarisation"] for row in made}
    assert set(found) == set(itertools.product((0.0, 0.5), (0.5, 1.0), (1, 2, 3)))
    for (eta, r, seed), polarisation in found.items():
        flock = Flock("vem", agents=20, eta=eta, r=r, rng=seed)
        flock.run(10)
        assert polarisation == flock.observe("polarisation")


# --- space ------------------------------------------------------------------------------------


def distances(flock, point):
    """Distance from a point to each agent, by hand: over all images where there are any."""
    size = np.array(flock.world.size)
    steps = (-1, 0, 1) if flock.world.images.any() else (0,)
    shifts = np.array(list(itertools.product(steps, repeat=flock.world.dim))) * size
    apart = flock.position[:, None, :] + shifts[None] - np.asarray(point)
    return np.sqrt((apart**2).sum(axis=2)).min(axis=1)


@pytest.mark.parametrize("world", ["wrap", "wrap-plain", "open"])
@pytest.mark.parametrize("dim", [2, 3])
def test_space_queries_see_the_flock_as_it_is(world, dim):
    flock = Flock("vem", agents=80, rng=10, dim=dim, world=world, size=4.0)
    for _ in range(3):
        point = flock.position[7].copy()
        exact = distances(flock, point)
        found, apart = flock.space.get_agents_in_radius(point, 1.0)
        assert [agent.row for agent in found] == np.flatnonzero(exact <= 1.0).tolist()
        assert np.allclose(apart, exact[exact <= 1.0])
        nearest, _ = flock.space.get_k_nearest_agents(point, 5)
        assert {agent.row for agent in nearest} == set(np.argsort(exact)[:5].tolist())
        flock.run(10)
        Member(flock)
        flock.members[0].remove()


def test_neighbours_are_those_within_reach():
    flock = Flock("vem", agents=60, rng=11, size=4.0)
    for member in flock.members[::7]:
        exact = distances(flock, member.position)
        rows = [agent.row for agent in member.neighbours]
        assert rows == np.flatnonzero((exact > 0) & (exact <= flock.reach)).tolist()


def test_the_space_knows_its_agents_and_bounds():
    flock = Flock("vem", agents=10, rng=12, size=(2.0, 3.0))
    assert list(flock.space.agents) == flock.members
    assert flock.space.size.tolist() == [2.0, 3.0]
    assert flock.space.in_bounds((1.0, 2.9))
    assert not flock.space.in_bounds((2.5, 1.0))
    assert flock.members[0].space is flock.space
