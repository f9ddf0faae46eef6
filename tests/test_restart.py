"""`flock.restart(seed)`: the same run with another seed is as a new flock, whatever was done."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from agents import Flock, Member
from agents.catalogue import MODELS
from agents.engine import noise
from agents.individuals import lognormal
from agents.kinds import Kind, chase
from agents.motion.flock_start import begin_in_place
from agents.state.start import FIRST
from worlds.compilation import DISABLED, plain_python
from worlds.input_error import InputError

OTHERS = [
    {"model": "vem", "activation": "random"},
    {"model": "vem", "activation": "sequential", "noise": "vectorial"},
    {"model": "hwvem", "gusts": 0.2, "wind": 0.1, "pulse": 0.3},
    {"model": "hwvem", "delay": 2.0, "jitter": 1.0, "lost": 0.1, "place_error": 0.01},
    {"model": "reynolds", "world": "thesis-blocks", "agents": 5},
    {"model": "couzin", "dim": 3, "spacing": 0.2},
    {"model": "vem-a", "informed": 3, "threads": 2},
    {"model": "vem", "agents": 60, "size": 12.0, "r": lognormal(0.3, 0.6)},
]

DRAWN = [OTHERS[2], OTHERS[3], OTHERS[4], OTHERS[7], {"model": "guarded"}]
"""Those of which more is drawn, or remembered, than where agents begin, and how."""


def as_new(flock: Flock, new: Flock) -> None:
    """Nothing tells the one from the other: not to the last bit."""
    assert (flock.spec, flock.tick, flock.next_id) == (new.spec, new.tick, new.next_id)
    assert (flock.world, flock.parameters) == (new.world, new.parameters)
    for name, array in flock.arrays._asdict().items():
        assert np.array_equal(array, getattr(new.arrays, name), equal_nan=array.dtype == float), (
            name
        )
    assert flock.context.reach == new.context.reach
    assert flock.engine.surroundings.reach >= flock.sight
    assert (flock.time, flock.steps, flock.running) == (new.time, new.steps, new.running)
    assert flock.random.getstate() == new.random.getstate()
    assert flock.rng.bit_generator.state == new.rng.bit_generator.state
    assert flock.datacollector.model_vars == new.datacollector.model_vars


def demand_same_arrays(flock: Flock, new: Flock) -> None:
    """The arrays of both are the same to the last bit."""
    for name, array in flock.arrays._asdict().items():
        assert array.tobytes() == getattr(new.arrays, name).tobytes(), name


def demand_begun_in_place(flock: Flock, seed: int, words: dict[str, Any]) -> None:
    """The arrays that a flock has, and another has, are filled with those of new ones."""
    flocks = [flock, Flock(**words, rng=2)]
    arrays = [one.arrays for one in flocks]
    begin_in_place(flocks, [seed, seed + 1])
    for k, one in enumerate(flocks):
        assert one.arrays is arrays[k]
        demand_same_arrays(one, Flock(**words, rng=seed + k))


@pytest.mark.parametrize(
    "words", [*({"model": name} for name in MODELS), *OTHERS], ids=lambda words: str(words)
)
def test_it_is_as_a_new_flock(words):
    is_drawn = words in DRAWN
    words = {"agents": 12} | words
    flock = Flock(**words, rng=1)
    flock.run(15)
    assert flock.can_begin_in_place != is_drawn
    if not is_drawn:
        demand_begun_in_place(flock, 9, words)
    flock.restart(7)
    new = Flock(**words, rng=7)
    as_new(flock, new)
    for either in (flock, new):
        either.run(15)
    as_new(flock, new)
    for either in (flock, new):
        either.step()
    as_new(flock, new)


def test_what_was_done_to_it_is_undone():
    flock = Flock("vem-a", agents=20, rng=1)
    flock.step()
    members, space = list(flock.agents), flock.space
    members[3].remove()
    Member(flock, position=(0.5, 0.5), heading=(1.0, 0.0))
    members[0].step()
    flock.set(eta=3.0)

    def event():
        flock.set(eta=5.0)

    flock.schedule_event(event, after=3.0)
    flock.running = False
    flock.restart(2)
    new = Flock("vem-a", agents=20, rng=2)
    as_new(flock, new)
    assert all(member.is_gone for member in members)
    assert flock.space is not space
    assert len(flock.agents) == 21
    for either in (flock, new):
        for _ in range(5):
            either.step()
        either.agents.shuffle_do("step")
    as_new(flock, new)


def test_a_world_of_random_obstacles_is_drawn_anew():
    flock = Flock("reynolds", world="thesis-blocks", agents=10, rng=1)
    flock.run(3)
    before = flock.world
    flock.restart(2)
    assert flock.world != before
    flock.restart(1)
    assert flock.world == before


def test_what_cannot_be_begun_again_is_refused():
    start = {"position": [(1.0, 1.0)], "heading": [(1.0, 0.0)]}
    given = Flock("vem", start=start, size=4.0)
    with pytest.raises(InputError, match="a run from given arrays has no random start"):
        given.restart(2)
    flock = Flock("vem", agents=5, rng=1)
    flock.run(3)
    with pytest.raises(InputError, match="seed = -1 is not allowed"):
        flock.restart(-1)
    assert (flock.tick, flock.seed) == (3, 1)


def test_the_compiled_call_is_used_again_where_nothing_of_it_has_changed():
    flock = Flock("hwvem", agents=12, rng=1)
    engine = flock.engine
    flock.restart(2)
    assert flock.engine is engine
    flock.set(v0=0.2)
    flock.restart(3)
    assert flock.engine is not engine


def test_compiled_code_draws_the_same_random_numbers():
    """Those of a start, of an order of turns, of gusts: before it is compiled and after."""
    asked = [
        (seed, tick, np.arange(first, first + 50), draws, first)
        for seed in (0, 7, 2**63 - 1)
        for tick in (0, noise.ORDERS + 3, FIRST + 2)
        for draws, first in ((1, 0), (2, 0), (3, 4), (6, 0))
    ]
    with plain_python():
        plain = [noise.uniform_numbers(*one) for one in asked]
    noise.compile_draws()
    assert noise.fill_uniform.overloads or DISABLED
    for one, numbers in zip(asked, plain, strict=True):
        assert np.array_equal(noise.uniform_numbers(*one), numbers)


def test_a_flock_of_kinds_begins_again_as_a_new_one_whatever_became_of_it():
    fish = Kind("fish", 6, v0=0.1)
    sharks = Kind("shark", 2, v0=0.2, to={"fish": chase(2.0, 3.0, catch=0.3)})
    words = {"agents": 10, "size": 4.0, "kinds": [fish, sharks]}
    flock = Flock("vem", rng=1, **words)
    changes = (
        lambda: None,
        lambda: flock.set_kind("shark", v0=0.3),
        lambda: flock.set(eta=0.9),
        lambda: flock.members[0].remove(),
        lambda: setattr(flock.members[3], "v0", 0.01),
        lambda: None,
    )
    for seed, change in enumerate(changes, 4):
        flock.restart(seed)
        new = Flock("vem", rng=seed, **words)
        for one in (flock, new):
            one.run(15)
        for name in ("position", "heading", "speed", "ids", "kind", "own"):
            assert np.array_equal(getattr(flock.arrays, name), getattr(new.arrays, name))
        assert flock.context.reach == new.context.reach
        change()
        flock.run(3)


@pytest.mark.parametrize(
    "words",
    [
        {"world": "obstacles"},
        {"world": "obstacles", "spacing": 0.1, "informed": 2},
        {"model": "couzin", "dim": 3},
        {"world": "wu2023-wall"},
        {"model": "vasarhelyi"},
        {"model": "prey-swarm"},
    ],
    ids=str,
)
def test_arrays_of_kinds_begin_in_place_as_those_of_a_new_flock(words):
    model = words.get("model", "vem")
    name = "s" if model == "couzin" else "v0"
    own = {} if model in ("vasarhelyi", "prey-swarm") else {name: 0.1}
    words = {"agents": 9, **words, "kinds": [Kind("robot", 3, steered=True, **own)]}
    flock = Flock(rng=1, **words)
    flock.run(3)
    flock.steer("robot", flock.heading[flock.rows_of("robot")])
    assert flock.can_begin_in_place
    demand_begun_in_place(flock, 5, words)
    if own:
        assert np.array_equal(flock.speed, getattr(flock, name))
        assert len(set(flock.speed.tolist())) == 2


def test_a_kind_with_a_box_of_its_own_begins_in_place_there():
    box = ((1.0, 1.0), (2.0, 1.5))
    kinds = [Kind("robot", 3, steered=True, start=box)]
    words = {"model": "vem", "agents": 9, "size": 4.0, "kinds": kinds}
    flock = Flock(rng=1, **words)
    flock.run(3)
    demand_begun_in_place(flock, 5, words)
    position = flock.position[flock.rows_of("robot")]
    assert ((position >= box[0]) & (position <= box[1])).all()


def test_arrays_of_fewer_agents_than_begin_cannot_be_begun_in_place():
    sharks = Kind("shark", 3, v0=0.3, to={"flock": chase(3.0, 4.0, catch=0.5, caught="taken")})
    flock = Flock("vem", agents=9, size=3.0, kinds=[sharks], rng=1)
    assert flock.can_begin_in_place
    flock.run(30)
    assert len(flock.ids) < 12
    assert not flock.can_begin_in_place
