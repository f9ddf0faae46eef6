"""What Mesa promises: every public name does what stock Mesa does, or is refused with the reason.

Each check below is made of a stock model and of a flock; a name that Mesa adds fails until it has
one. What is random is compared by what does not depend on the draw.
"""

from __future__ import annotations

import copy
import pickle
import tempfile
from pathlib import Path

import mesa
import numpy as np
import pandas as pd
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from mesa.agent import AgentSet
from mesa.experimental.continuous_space import ContinuousSpace, ContinuousSpaceAgent
from mesa.time import Schedule

from agents import Flock, Member
from worlds.input_error import InputError

SIDE = 4.0
PLACES = np.array([[0.5, 0.5], [1.0, 0.5], [0.5, 3.9], [3.0, 3.0], [2.0, 1.0], [2.5, 3.5]])
"""A torus of this side, with two agents that are near each other across its seam."""
REFUSED = object()
"""The name is refused: what to use instead is in the message."""


class StockAgent(ContinuousSpaceAgent):
    """An agent as Mesa's own space has it."""

    def __init__(self, model, place=(1.0, 1.0)):
        super().__init__(model.space, model)
        self.position = np.array(place, float)
        self.informed = False
        self.speed = 0.0

    def step(self):
        """Nothing."""


class Stock(mesa.Model):
    """A model of Mesa alone, with the same agents."""

    def __init__(self, rng=1):
        super().__init__(rng=rng)
        self.space = ContinuousSpace([[0, SIDE], [0, SIDE]], torus=True, random=self.random)
        for place in PLACES:
            StockAgent(self, place)


def stock():
    return Stock()


def flock(**more):
    heading = np.tile([1.0, 0.0], (len(PLACES), 1))
    begin = {"position": PLACES, "heading": heading}
    words = {"size": SIDE, "world": "wrap", "rng": 1, "eta": 0.0, "v0": 1e-9} | more
    return Flock("vem", start=begin, **words)


def identities(agents):
    return [agent.unique_id for agent in agents]


def heard(model):
    """How much a subscriber of Mesa's time hears in three steps, and after it has left."""
    signals = []

    def hear(signal):
        signals.append(signal)

    model.observe("time", "changed", hear)
    for _ in range(3):
        model.step()
    model.unobserve("time", "changed", hear)
    model.step()
    return len(signals)


def cleared(model):
    signals = []

    def hear(signal):
        signals.append(signal)

    model.observe("time", "changed", hear)
    model.clear_all_subscriptions("time")
    model.step()
    return len(signals)


def held(model, how):
    signals = []

    def hear(signal):
        signals.append(signal)

    model.observe("time", "changed", hear)
    with getattr(model, how)():
        model.step()
        within = len(signals)
    return within, len(signals)


def fired(model):
    """When events happen, of one and of many."""
    when = []

    def look():
        when.append(model.time)

    model.schedule_event(look, at=2.0)
    model.schedule_event(look, after=3.5)
    for _ in range(6):
        model.step()
    return when


def recurring(model):
    when = []

    def look():
        when.append(model.time)

    model.schedule_recurring(look, Schedule(interval=2.0, start=1.0))
    for _ in range(6):
        model.step()
    return when


def removed(model):
    """A removed agent is in no set, and a second `remove` does nothing or says so."""
    agent = list(model.agents)[2]
    agent.remove()
    return identities(model.agents), len(model.agents_by_type[type(agent)])


def deregistered(model):
    model.deregister_agent(next(iter(model.agents)))
    return identities(model.agents)


def stopped(model):
    def stop():
        model.running = False

    model.schedule_event(stop, at=5.0)
    model.run_model()
    return model.steps, model.time


def ran(model, how, *given):
    getattr(model, how)(*given)
    return model.steps, model.time


def emptied(model):
    model.remove_all_agents()
    return (
        len(model.agents),
        len(model.agent_types),
        [len(s) for s in model.agents_by_type.values()],
    )


def made(model):
    """An agent that is made is in the sets, under the next identity."""
    kind = type(next(iter(model.agents)))
    kind(model)
    return identities(model.agents)


MODEL = {
    "agent_types": lambda one: len(one.agent_types),
    "agents": lambda one: (identities(one.agents), type(one.agents).__name__),
    "agents_by_type": lambda one: [len(agents) for agents in one.agents_by_type.values()],
    "batch": lambda one: held(one, "batch"),
    "clear_all_subscriptions": cleared,
    "deregister_agent": deregistered,
    "notify": lambda one: one.notify("time", "changed"),
    "observables": lambda one: {"time", "agents"} <= set(one.observables),
    "observe": heard,
    "register_agent": made,
    "remove_all_agents": emptied,
    "reset_randomizer": REFUSED,
    "reset_rng": REFUSED,
    "run_for": lambda one: ran(one, "run_for", 3),
    "run_model": stopped,
    "run_until": lambda one: ran(one, "run_until", 7),
    "scenario": lambda one: one.scenario.model is one,
    "schedule_event": fired,
    "schedule_recurring": recurring,
    "step": lambda one: ran(one, "step"),
    "suppress": lambda one: held(one, "suppress"),
    "time": lambda one: one.time,
    "unobserve": heard,
    "subscribers": lambda one: isinstance(one.subscribers, dict),
    "running": lambda one: one.running,
    "steps": lambda one: one.steps,
    "agent_id_counter": lambda one: one.agent_id_counter,
    "rng": lambda one: isinstance(one.rng, np.random.Generator),
    "random": lambda one: 0.0 <= one.random.random() < 1.0,
    "data_registry": lambda one: type(one.data_registry).__name__,
}
"""By the public names of `mesa.Model`, and of one that is made."""


def changed(agents, how):
    """What is left of a set of the first three once it was changed."""
    some = AgentSet(agents.to_list()[:3], random=agents.random)
    how(some)
    return identities(some)


SET = {
    "add": lambda a: changed(a, lambda some: some.add(a.to_list()[4])),
    "agg": lambda a: a.agg("unique_id", max),
    "clear": lambda a: changed(a, lambda some: some.clear()),
    "copy": lambda a: identities(a.copy()),
    "count": lambda a: AgentSet(a.to_list(), random=a.random).count(6),
    "discard": lambda a: changed(a, lambda some: some.discard(a.to_list()[1])),
    "do": lambda a: len(a.do("step")),
    "get": lambda a: a.get("unique_id"),
    "groupby": lambda a: sorted(a.groupby(lambda one: one.unique_id % 2).count().items()),
    "index": lambda a: AgentSet(a.to_list(), random=a.random).index(a.to_list()[3]),
    "isdisjoint": lambda a: a.isdisjoint(a),
    "map": lambda a: a.map(lambda one: one.unique_id),
    "pop": lambda a: len(changed(a, lambda some: some.pop())),
    "random": lambda a: a.random is next(iter(a)).model.random,
    "remove": lambda a: changed(a, lambda some: some.remove(a.to_list()[0])),
    "select": lambda a: identities(a.select(lambda one: one.unique_id > 3, at_most=2)),
    "set": lambda a: a.set("tag", 3).get("tag"),
    "shuffle": lambda a: sorted(identities(a.shuffle())),
    "shuffle_do": lambda a: len(a.shuffle_do("step")),
    "sort": lambda a: identities(a.sort("unique_id", ascending=True)),
    "to_list": lambda a: identities(a.to_list()),
}
"""By the public names of `AgentSet`."""


def moved(agent):
    agent.position = np.array([SIDE + 0.5, -0.5])
    return agent.position.tolist()


def near(found):
    agents, apart = found
    order = np.argsort(apart)
    return [agents[k].unique_id for k in order], np.round(np.asarray(apart)[order], 9).tolist()


AGENT = {
    "advance": lambda agent: agent.advance(),
    "create_agents": lambda agent: len(type(agent).create_agents(agent.model, 2)),
    "from_dataframe": lambda agent: len(
        type(agent).from_dataframe(agent.model, pd.DataFrame(index=range(2)))
    ),
    "get_nearest_neighbors": lambda agent: near(agent.get_nearest_neighbors(2)),
    "get_neighbors_in_radius": lambda agent: near(agent.get_neighbors_in_radius(1.0)),
    "informed": lambda agent: agent.informed,
    "model": lambda agent: agent in agent.model.agents,
    "pos": lambda agent: np.asarray(agent.pos).tolist(),
    "position": moved,
    "random": lambda agent: agent.random is agent.model.random,
    "remove": lambda agent: removed(agent.model),
    "rng": lambda agent: agent.rng is agent.model.rng,
    "scenario": lambda agent: agent.scenario is agent.model.scenario,
    "space": lambda agent: len(agent.space.agents),
    "speed": lambda agent: round(agent.speed, 6),
    "step": lambda agent: agent.step(),
    "unique_id": lambda agent: agent.unique_id,
}
"""By the public names of `mesa.Agent` and `ContinuousSpaceAgent`."""

SPACE = {
    "active_agents": lambda space: identities(space.active_agents),
    "agent_positions": lambda space: space.agent_positions.tolist(),
    "agents": lambda space: identities(space.agents),
    "calculate_difference_vector": lambda space: np.round(
        space.calculate_difference_vector(np.array([0.25, 0.25])), 9
    ).tolist(),
    "calculate_distances": lambda space: np.round(
        space.calculate_distances(np.array([0.25, 0.25]))[0], 9
    ).tolist(),
    "center": lambda space: space.center.tolist(),
    "dimensions": lambda space: np.asarray(space.dimensions).tolist(),
    "get_agents_in_radius": lambda space: near(space.get_agents_in_radius(np.array([0.5, 0.0]), 1)),
    "get_k_nearest_agents": lambda space: near(space.get_k_nearest_agents(np.array([0.5, 0.0]), 3)),
    "height": lambda space: space.height,
    "in_bounds": lambda space: [space.in_bounds(np.array([x, 1.0])) for x in (1.0, 5.0)],
    "ndims": lambda space: space.ndims,
    "random": lambda space: space.random is space.agents[0].model.random,
    "size": lambda space: np.asarray(space.size).tolist(),
    "torus": lambda space: space.torus,
    "torus_correct": lambda space: np.asarray(space.torus_correct(np.array([4.5, -0.5]))).tolist(),
    "width": lambda space: space.width,
    **{
        name: lambda space, name=name: float(getattr(space, name))
        for name in ("x_max", "x_min", "y_max", "y_min")
    },
}
"""By the public names of `ContinuousSpace`."""


def public(kind):
    return {name for name in dir(kind) if not name.startswith("_")}


def test_every_public_name_of_mesa_has_its_check():
    one = stock()
    agent = next(iter(one.agents))
    assert set(MODEL) == public(mesa.Model) | public(mesa.Model())
    assert set(SET) == public(AgentSet) | public(one.agents)
    assert set(AGENT) == public(mesa.Agent) | public(ContinuousSpaceAgent) | public(agent)
    assert set(SPACE) == public(ContinuousSpace) | public(one.space)


@pytest.mark.parametrize("name", MODEL)
def test_a_flock_is_a_model_in_every_name(name):
    check = MODEL[name]
    if check is REFUSED:
        with pytest.raises(InputError, match=rf"{name} .*make a new Flock"):
            getattr(flock(), name)()
    else:
        assert check(flock()) == check(stock())


@pytest.mark.parametrize("name", SET)
def test_its_agents_are_an_agent_set_in_every_name(name):
    assert SET[name](flock().agents) == SET[name](stock().agents)


@pytest.mark.parametrize("name", AGENT)
def test_an_agent_is_one_of_mesa_in_every_name(name):
    ours, theirs = (AGENT[name](next(iter(one.agents))) for one in (flock(), stock()))
    assert ours == theirs


@pytest.mark.parametrize("name", SPACE)
def test_the_space_is_one_of_mesa_in_every_name(name):
    assert SPACE[name](flock().space) == SPACE[name](stock().space)


@pytest.mark.parametrize("world", ["corridor", "walkway"])
def test_the_space_of_a_world_that_wraps_along_one_axis_is_near_across_that_seam(world):
    one = Flock("vem", agents=3, world=world, rng=1)
    wraps, size = one.world.wraps, np.asarray(one.world.size)
    assert sorted(wraps.tolist()) == [False, True]
    along = np.where(wraps, 0.01, 0.0)
    one.position[:] = [
        0.5 * size,
        0.5 * size * ~wraps + along,
        0.5 * size * ~wraps + size * wraps - along,
    ]
    here = one.position[1]
    assert one.space.calculate_distances(here)[0][2] == pytest.approx(0.02)
    assert one.space.calculate_difference_vector(here)[2] == pytest.approx(-2.0 * along)
    assert identities(one.space.get_agents_in_radius(here, 0.1)[0]) == identities(one.members[1:])
    outside = np.where(wraps, size + 0.01, -1.0)
    assert one.space.torus_correct(outside) == pytest.approx(np.where(wraps, 0.01, -1.0))


# --- time, whoever makes it pass ---------------------------------------------------------------


def test_time_and_steps_are_the_tick_however_it_came():
    one = flock(collect=["polarisation"])
    one.run(50)
    assert (one.time, one.steps, one.tick) == (50.0, 50, 50)
    one.datacollector.collect(one)
    assert one.datacollector.get_model_vars_dataframe().shape[0] == 1
    one.agents.do("step")
    one.step()
    assert one.time == one.steps == one.tick


def test_events_come_at_their_tick_while_compiled_code_runs():
    one, when = flock(), []

    def look():
        when.append((one.time, one.tick))

    for at in (3.0, 10.0, 11.0):
        one.schedule_event(look, at=at)
    one.run(20)
    assert when == [(3.0, 3), (10.0, 10), (11.0, 11)]


def test_seeds_of_every_kind():
    generator = np.random.default_rng(3)
    assert flock(rng=generator).seed == flock(rng=np.random.default_rng(3)).seed
    assert flock(rng=np.int64(7)).seed == 7
    drawn = flock(rng=None)
    drawn.datacollector.collect(drawn)
    assert drawn.datacollector.get_model_vars_dataframe()["seed"].tolist() == [drawn.seed]


@pytest.mark.parametrize("how", [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))])
def test_a_flock_that_has_run_is_copied_and_goes_on_alike(how):
    one = flock(eta=1.0)
    one.run(7)
    other = how(one)
    for each in (one, other):
        each.run(5)
    np.testing.assert_array_equal(one.heading, other.heading)
    assert other.time == 12.0


def test_reporters_and_values_are_given_as_in_mesa():
    one = flock(model_reporters={"twice": lambda model: 2 * model.tick})
    one.step()
    assert one.datacollector.get_model_vars_dataframe()["twice"].tolist() == [2]
    with pytest.raises(InputError, match="a parameter: set v0"):
        one.agents.set("speed", 0.0)


# --- agents that are gone ----------------------------------------------------------------------


def test_a_handle_whose_agent_is_gone_says_only_that():
    one = flock()
    gone, other = one.members[1], one.members[2]
    gone.remove()
    gone.remove()
    assert identities(one.agents) == [1, 3, 4, 5, 6]
    assert gone.is_gone
    assert "gone" in repr(gone)
    for read in (lambda: gone.position, lambda: gone.heading, gone.step, lambda: gone.row):
        with pytest.raises(InputError, match="agent 2 is gone: it left the flock at tick 0"):
            read()
    with pytest.raises(InputError, match="agent 2 is gone"):
        gone.heading = (0.0, 1.0)
    assert other.position.tolist() == PLACES[2].tolist()


class Handles(RuleBasedStateMachine):
    """A flock beside a plain list of what each agent is, in any order of what can be done."""

    @initialize(delay=st.sampled_from((0, 2)), informed=st.sampled_from((0, 1)))
    def begin(self, delay, informed):
        model = "hwvem" if informed else "vem"  # with layers, from the informed one on
        self.one = Flock(model, agents=4, informed=informed, size=SIDE, rng=1, delay=delay)
        self.plain = {agent.unique_id: agent for agent in self.one.agents}
        self.gone = []
        self.note()

    def note(self):
        """Keep what each agent is, apart from the flock's arrays."""
        self.values = {
            identity: (agent.position.tolist(), agent.heading.tolist(), agent.informed)
            for identity, agent in self.plain.items()
        }

    @rule(x=st.floats(0.0, 1.9))
    def add(self, x):
        agent = Member(self.one, position=(x, 0.5), heading=(0.0, -1.0))
        assert agent.unique_id not in self.plain
        self.plain[agent.unique_id] = agent
        self.values[agent.unique_id] = [x, 0.5], [0.0, -1.0], False

    @precondition(lambda self: len(self.plain) > 1)
    @rule(data=st.data())
    def remove(self, data):
        identity = data.draw(st.sampled_from(sorted(self.plain)))
        agent = self.plain.pop(identity)
        del self.values[identity]
        agent.remove()
        self.gone.append(agent)

    @precondition(lambda self: self.gone)
    @rule(data=st.data())
    def remove_again(self, data):
        data.draw(st.sampled_from(self.gone)).remove()

    @rule(data=st.data())
    def turn(self, data):
        identity = data.draw(st.sampled_from(sorted(self.plain)))
        place, _, informed = self.values[identity]
        self.plain[identity].heading = (0.0, 1.0)
        self.values[identity] = place, [0.0, 1.0], informed

    @rule(ticks=st.integers(1, 3))
    def run_on(self, ticks):
        self.one.run(ticks)
        self.note()

    @rule(data=st.data())
    def step_one(self, data):
        self.plain[data.draw(st.sampled_from(sorted(self.plain)))].step()
        self.note()

    def again(self, pickled):
        if pickled:
            return pickle.loads(pickle.dumps(self.one))
        with tempfile.TemporaryDirectory() as folder:
            self.one.save(Path(folder) / "state.parquet")
            return Flock.load(Path(folder) / "state.parquet")

    @rule(pickled=st.booleans())
    def save_and_load(self, pickled):
        before, old = self.one, self.plain
        if before._acted:
            with pytest.raises(InputError, match="the flock between ticks"):
                self.again(pickled)
            return
        self.one = self.again(pickled)
        self.plain = {agent.unique_id: agent for agent in self.one.agents}
        for identity, agent in old.items():  # handles of the flock that was saved stay its own
            assert agent.model is before
            assert agent is not self.plain[identity]
        self.gone = []

    @invariant()
    def each_handle_is_its_agent(self):
        if not hasattr(self, "one"):
            return
        assert sorted(identities(self.one.agents)) == sorted(self.plain)
        for identity, agent in self.plain.items():
            assert self.one.ids[agent.row] == identity
            assert np.shares_memory(agent.position, self.one.position)
            found = agent.position.tolist(), agent.heading.tolist(), agent.informed
            assert found == self.values[identity]
        assert all(agent.is_gone for agent in self.gone)


TestHandles = Handles.TestCase
TestHandles.settings = settings(max_examples=60, stateful_step_count=20, deadline=None)
