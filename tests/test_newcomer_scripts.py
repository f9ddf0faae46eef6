"""What people write before they have read anything: Mesa's and NetLogo's habits work, or say what
does."""

from __future__ import annotations

import copy
import operator
import pickle

import matplotlib.pyplot as plt
import mesa
import numpy as np
import pandas as pd
import pytest

import flockscope
from agents.mesa_interface import OTHER_NAMES
from flockscope import MODELS, Flock, InputError, Member, World

# Scripts of somebody who knows Mesa. Each is one to three minutes of typing.


def test_steps_and_what_was_collected():
    model = Flock("vem", agents=40, seed=42)
    for _ in range(10):
        model.step()
    frame = model.datacollector.get_model_vars_dataframe()
    assert model.steps == len(frame) == 10
    assert frame["polarisation"].between(0, 1).all()
    assert len(model.agents) == 40


def test_reporters_are_functions_attributes_and_observables():
    model = Flock(
        "vem",
        agents=30,
        rng=1,
        model_reporters={"N": lambda m: len(m.agents), "eta": "eta", "order": "polarisation"},
        agent_reporters={"x": lambda a: a.pos[0], "speed": "speed"},
    )
    model.run_for(5)
    frame = model.datacollector.get_model_vars_dataframe()
    assert frame["N"].tolist() == [30] * 5
    assert frame["eta"].tolist() == [0.0] * 5
    assert frame["order"].tolist() == frame["polarisation"].tolist()
    assert set(model.datacollector.get_agent_vars_dataframe().columns) == {"x", "speed"}


class Counting(Flock):
    """A model of one's own that is a flock."""

    def __init__(self, n=20, noise=0.2, rng=None):
        super().__init__("vem", agents=n, eta=noise, rng=rng)
        self.east = 0

    def step(self):
        super().step()
        self.east = sum(agent.heading[0] > 0 for agent in self.agents)


def test_a_class_of_ones_own_counts():
    model = Counting(n=25, rng=3)
    model.run_for(4)
    assert 0 <= model.east <= 25
    assert len(model.datacollector.model_vars["polarisation"]) == 4


def test_mesa_s_batch_run_varies_it():
    results = mesa.batch_run(
        Counting,
        parameters={"n": [10, 20], "noise": [0.1, 1.0]},
        rng=range(2),
        max_steps=5,
        data_collection_period=-1,
        display_progress=False,
    )
    frame = pd.DataFrame(results)
    assert len(frame) == 8
    assert set(frame["n"]) == {10, 20}


def test_agent_sets_select_do_get_and_group():
    model = Flock("couzin", agents=30, dim=2, rng=5)
    model.run_for(3)
    side = model.world.size[0]
    left = model.agents.select(lambda agent: agent.pos[0] < side / 2)
    assert 0 < len(left) < 30
    assert np.array(model.agents.get("pos")).shape == (30, 2)
    assert model.agents.agg("speed", np.mean) > 0
    groups = model.agents.groupby(lambda agent: bool(agent.heading[0] > 0))
    assert sum(groups.count().values()) == 30
    model.agents.shuffle_do("step")
    model.agents.do(lambda agent: setattr(agent, "heading", (1.0, 0.0)))
    assert np.allclose(model.agents.get("heading"), (1.0, 0.0))


def test_agents_come_and_go():
    model = Flock("vem", agents=20, size=5.0, rng=1)
    for agent in list(model.agents)[:5]:
        agent.remove()
    Member(model, position=(1.0, 1.0), heading=(0.0, 1.0))
    model.step()
    assert len(model.agents) == len(model.position) == 16


def test_neighbours_are_found_in_its_space():
    model = Flock("vem", agents=50, size=5.0, rng=1)
    agent = next(iter(model.agents))
    near, distances = agent.get_neighbors_in_radius(1.0)
    assert len(near) == len(distances)
    assert (distances <= 1.0).all()
    agents, _ = model.space.get_agents_in_radius(agent.pos, 1.0)
    assert len(agents) == len(near) + 1


def test_parameters_are_attributes_that_act():
    model = Flock("vem", agents=50, size=5.0, rng=1)
    model.run_for(5)
    assert (model.eta, model.r) == (0.0, model.parameters.r)
    model.eta = 2.0
    assert model.parameters.eta == 2.0
    same = Flock("vem", agents=50, size=5.0, rng=1)
    same.run_for(5)
    same.set(eta=2.0)
    model.step()
    same.step()
    np.testing.assert_array_equal(model.position, same.position)
    with pytest.raises(InputError, match=r"eta = 99 rad is outside \[0, 6.283"):
        model.eta = 99


def test_events_and_running_until_something_happens():
    model = Flock("vem", agents=50, size=5.0, rng=1)
    seen = []

    def look():
        seen.append(model.time)

    model.schedule_event(look, at=3.0)
    while model.observe("polarisation") < 0.95 and model.steps < 500:
        model.step()
    assert seen == [3.0]
    assert model.steps < 500


def test_it_is_copied_pickled_and_reproduced():
    model = Flock("vem", agents=30, rng=np.random.default_rng(3))
    twin, stored = copy.deepcopy(model), pickle.dumps(model)
    again = Flock("vem", agents=30, seed=model.seed)
    for one in (model, twin, again):
        one.run_for(4)
    restored = pickle.loads(stored)
    restored.run_for(4)
    for one in (twin, again, restored):
        np.testing.assert_array_equal(one.position, model.position)


def test_positions_are_drawn_with_matplotlib():
    model = Flock("vem", agents=30, rng=1)
    model.run_for(2)
    frame = model.to_dataframe()
    figure, axes = plt.subplots()
    axes.quiver(frame.x, frame.y, frame.heading_x, frame.heading_y)
    axes.scatter(*np.array(model.agents.get("pos")).T)
    plt.close(figure)
    assert frame.index.name == "id"
    assert len(frame) == 30


def test_a_world_of_ones_own():
    pond = World(size=(20, 10), edges="solid")
    model = Flock("vem", agents=30, world=pond, rng=1)
    model.run_for(20)
    assert (model.position >= 0).all()
    assert (model.position <= (20, 10)).all()


def test_what_is_shown_of_things_is_short_and_has_a_picture():
    model = Flock("vem", agents=30, world="obstacles", rng=1)
    member = next(iter(model.agents))
    for value in (model, model.world, MODELS, MODELS["vem"], member):
        assert len(repr(value)) < 700
        assert "object at 0x" not in repr(value)
    assert model._repr_html_().count("<path") > 30
    assert "polarisation" in model._repr_html_()
    assert "<svg" in model.world._repr_html_()
    assert "Vicsek" in MODELS._repr_html_()
    assert "heading" in member._repr_html_()
    room = World(size=10, edges="open", low=(20.0, 5.0))
    assert "outside" not in Flock("vem", agents=10, world=room, rng=1)._repr_html_()
    member.remove()
    assert "gone" in member._repr_html_()
    assert flockscope.__version__.count(".") == 2


# What does not work says what does.


@pytest.mark.parametrize(
    ("begin", "words"),
    [
        (lambda: Flock(50), "Flock takes the name of a model, and everything else by name"),
        (lambda: Flock("vem", 50), r"Flock\('vem', agents=50\): 50 has none"),
        (lambda: Flock("vem", n=50), "unknown option 'n': it is called 'agents' here"),
        (lambda: Flock("vem", width=50, height=50), "'width': it is called 'size' here"),
        (lambda: Flock("boids"), "unknown model 'boids': did you mean reynolds"),
        (lambda: Flock("Flocking"), "unknown model 'Flocking': did you mean reynolds"),
        (lambda: Flock("vem", turtles=50), "'turtles': it is called 'agents' here"),
        (lambda: Flock("vem", random_seed=5), "'random_seed': it is called 'seed' here"),
        (lambda: Flock("vem", world_width=50), "'world_width': it is called 'size' here"),
        (lambda: Flock("vem", agents="fifty"), "agents = 'fifty' is not allowed: a whole number"),
        (lambda: Flock("vem", radius=2.0), "unknown parameter 'radius'"),
        (lambda: World((20, 10)), r"give the sides as World\(size=\(20, 10\)\)"),
        (lambda: World(size=(20, 10), edges="torus"), "unknown edge 'torus'"),
    ],
)
def test_other_tools_words_are_told_ours(begin, words):
    with pytest.raises(InputError, match=words):
        begin()


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ("schedule", "it is called 'agents' here"),
        ("grid", "it is called 'space' here"),
        ("turtles", "it is called 'agents' here"),
        ("ticks", "it is called 'tick' here"),
        ("ask", "it is called 'agents' here"),
        ("patches", "it is called 'world' here"),
        ("go", "it is called 'run' here"),
        ("setup", "it is called 'restart' here"),
        ("xcor", "it is called 'position' here"),
        ("polarisation", r"use observe\('polarisation'\)"),
    ],
)
def test_other_tools_attributes_are_told_ours(asked, words):
    model = Flock("vem", agents=10, size=5.0, rng=1)
    with pytest.raises(AttributeError, match=words):
        getattr(model, asked)


@pytest.mark.parametrize(("asked", "ours"), OTHER_NAMES.items())
def test_what_other_tools_attributes_are_called_here_is_there(asked, ours):
    model = Flock("vem", agents=10, size=5.0, rng=1)
    assert not hasattr(model, asked)
    operator.attrgetter(ours)(model)
