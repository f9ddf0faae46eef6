"""Agents that differ, as a page draws and catches them, against the same of a flock here."""

from __future__ import annotations

import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.engine.cells import Space
from agents.engine.heeding import MOST_KINDS
from agents.flock import Flock
from agents.individuals import Distribution, draw_values, lognormal, normal, one_of, uniform
from agents.kinds import Kind, chase, flee, kind_table
from agents.motion.flock_loop import pad_to_space
from agents.web.web_kinds import (
    FAMILIES,
    Hunt,
    OwnDraw,
    claim_prey,
    draw_own,
    note_steps,
    page_values,
)
from agents.web.web_math import FUNCTIONS, page_function
from agents.web.web_program import web_program
from tests.worlds.test_web_assembly import Running
from worlds.compilation import plain_python
from worlds.input_error import InputError
from worlds.web_assembly import MemoryImage, linked_code, web_module

KEY = 0x70000000
"""Of a parameter's name: a crc32 may be as large."""


def draw_task(drawn_from: Distribution, low: float, high: float, key: int) -> OwnDraw:
    """The task of a page that draws the second column of all."""
    values = np.zeros(8)
    values[: len(drawn_from.numbers)] = drawn_from.numbers
    takes = np.ones(MOST_KINDS + 2, np.uint8)
    family, count = FAMILIES[drawn_from.kind], len(drawn_from.numbers)
    return OwnDraw(values, takes, 1, family, count, low, high, key)


def differing_flock(agents: int) -> Flock:
    """A flock with a table of own numbers."""
    return Flock("vem", agents=agents, rng=1, eta=normal(0.5, 0.1))


@pytest.fixture(scope="module")
def drawing() -> bytes:
    """A module that draws."""
    flock = differing_flock(3)
    given_ = flock.arrays, draw_task(normal(0.0, 1.0), 0.0, 1.0, KEY), 1
    own = {name: lambda name=name: page_function(name) for name in FUNCTIONS}
    return web_module({"go": linked_code(draw_own, given_)}, own).content


CASES = [
    (normal(3.0, 0.5), (0.0, 9.0)),
    (normal(0.0, 2.0), (0.0, 1.0)),
    (normal(1.0, 0.0), (-np.inf, np.inf)),
    (lognormal(2.0, 0.7), (0.5, 4.0)),
    (uniform(-1.0, 1.0), (0.0, 1.0)),
    (one_of(1.0, 2.0, 3.5), (1.5, 9.0)),
]


@pytest.mark.parametrize(("drawn_from", "bounds"), CASES)
def test_a_page_draws_the_numbers_that_a_flock_draws(drawing, drawn_from, bounds):
    import zlib

    flock, seed = differing_flock(400), 2**62 + 5
    image = MemoryImage()
    image.add("flock", flock.arrays)
    image.add("draw", draw_task(drawn_from, *bounds, key=zlib.crc32(b"speed")))
    image.add("seed", seed)
    image.finish()
    running = Running(drawing, image)
    running.call("go", image)
    expected, redrawn = draw_values(drawn_from, seed, "speed", flock.ids, bounds)
    own = running.array(image, "flock.own")
    assert own[:, 1] == pytest.approx(expected, rel=1e-14, abs=1e-15)
    assert (np.delete(own, 1, axis=1) == np.delete(flock.arrays.own, 1, axis=1)).all()
    first = drawn_from.draw(seed, "speed", flock.ids)
    outside = np.count_nonzero((first < bounds[0]) | (first > bounds[1]))
    assert redrawn == outside
    assert running.read(image.answer, "<d")[0] >= outside


def test_what_is_hardly_ever_in_range_ends():
    flock = differing_flock(20)
    with plain_python():
        assert draw_own(flock.arrays, draw_task(normal(0.0, 1.0), 9.0, 9.1, KEY), 3) == -1.0


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([2, 3]), st.booleans(), st.booleans())
def test_a_page_finds_who_is_caught_as_a_flock_does(seed, dim, closes, hunts_own):
    """In a box that closes or does not, on straight ways, ties among them, some caught before."""
    rng = np.random.default_rng(seed)
    prey = "hunter" if hunts_own else "flock"
    hunter = Kind("hunter", 6, to={prey: chase(1.0, 1.0, catch=0.7)})
    world = "wrap" if closes else "open"
    flock = Flock("vem", agents=12, rng=1, dim=dim, size=3.0, world=world, kinds=[hunter])
    n = len(flock.ids)
    before = np.round(rng.uniform(0.0, 3.0, (n, dim)), rng.integers(1, 9))
    flock.position[:] = before + np.round(rng.normal(0.0, 0.4, (n, dim)), rng.integers(1, 9))
    if closes:
        flock.position[:] %= 3.0
    flock.arrays.kind[rng.random(n) < 0.1] = -1.0
    flock._came_from = flock.ids.copy(), before.copy()
    step = flock._steps()
    kind = {name: np.flatnonzero(flock.kind_names == name) for name in ("hunter", prey)}
    space = Space(
        pad_to_space(flock.world.size, float),
        pad_to_space(flock.world.wraps, int),
        pad_to_space(flock.world.images, int),
        0.0,
    )
    reach = float(rng.choice([0.2, 0.7]))
    names = flock.kinds.names
    hunt = Hunt(
        before, np.zeros(n, np.int64), np.zeros(n), names.index("hunter"), names.index(prey), reach
    )
    with plain_python():
        note_steps(flock.arrays, hunt, space)
        count = claim_prey(flock.arrays, hunt, space)
    assert hunt.step == pytest.approx(step, abs=1e-15)
    expected: dict[int, int] = {}
    if len(kind["hunter"]) and len(kind[prey]):
        claims = flock._claims(kind["hunter"], kind[prey], reach, step)
        expected = dict(zip(claims.prey.tolist(), claims.hunters.tolist(), strict=True))
    found = {row: int(by) for row, by in enumerate(hunt.claimed) if by >= 0}
    assert found == expected
    assert count == len(expected)


def test_sliders_are_called_as_the_axes_of_sweeps(monkeypatch):
    monkeypatch.setattr("agents.web.web_program.web_measures", lambda *_: [])
    monkeypatch.setattr("agents.web.web_program.module_of", lambda *_: web_module_of_nothing())
    shark = Kind("shark", 2, v0=uniform(0.04, 0.06), to={"flock": chase(2.0, 1.5, catch=0.1)})
    slow = Kind("slow", 4, v0=0.01, to={"flock": "own"})
    flock = Flock(
        "vem",
        agents=9,
        rng=1,
        eta=normal(0.5, 0.1),
        kinds=[shark, slow],
        to={"shark": flee(3.0), "slow": "own"},
    )
    before = flock.arrays.own.copy()
    sliders = {one["name"]: one for one in web_program(flock).manifest["parameters"]}
    assert list(sliders) == [
        *("r", "eta", "eta.spread", "v0"),
        *("shark.v0", "shark.v0.spread"),
        *("shark.flock.weight", "shark.flock.radius", "shark.flock.catch"),
        *("slow.v0", "flock.shark.weight"),
    ]
    for name, value in {
        "eta": 0.5,
        "eta.spread": 0.1,
        "shark.v0": 0.05,
        "shark.v0.spread": 0.01,
        "shark.flock.weight": 2.0,
        "shark.flock.radius": 1.5,
        "shark.flock.catch": 0.1,
        "slow.v0": 0.01,
        "flock.shark.weight": 3.0,
    }.items():
        assert sliders[name]["value"] == pytest.approx(value), name
        assert sliders[name]["low"] <= value <= sliders[name]["high"]
    assert np.array_equal(flock.arrays.own, before)
    assert flock.individuals == {"eta": normal(0.5, 0.1)}


def web_module_of_nothing() -> bytes:
    """A module that has nothing in it."""
    return b"\0asm" + struct.pack("<I", 1)


def test_who_flees_because_it_is_chased_follows_the_slider_of_the_chase():
    hunter = Kind("hunter", 1, to={"flock": chase(2.0, 1.0)})
    assert kind_table((hunter,), {}).explicit == (("hunter", "flock"),)
    assert kind_table((hunter,), {"hunter": flee(1.0)}).explicit == (
        ("flock", "hunter"),
        ("hunter", "flock"),
    )
    to_all = Kind("wolf", 1, to={"all": chase(1.0), "prey": flee(1.0)})
    assert kind_table((hunter, to_all), {}).explicit == (
        ("hunter", "flock"),
        ("wolf", "flock"),
        ("wolf", "hunter"),
    )


def test_a_page_knows_all_relations_and_what_numbers_are_drawn_from():
    hunter = Kind("hunter", 2, v0=0.05, start=((0, 0), (1, 1)), to={"flock": chase(catch=0.1)})
    flock = Flock("vem", agents=5, rng=1, kinds=[hunter], eta=uniform(0.0, 1.0))
    told = page_values(flock)
    assert [one["name"] for one in told["kinds"]] == ["flock", "hunter"]
    assert told["kinds"][1] == {
        "name": "hunter",
        "agents": 2,
        "start": ((0.0, 0.0), (1.0, 1.0)),
    }
    assert told["catchers"] == [[1, 0, "taken"]]
    assert told["heeds"] == [[True, False], [False, True]]
    columns = flock.model.individual
    eta, v0 = columns.index("eta"), columns.index("v0")
    assert [eta, 0, FAMILIES["uniform"], (0.0, 1.0)] in told["draws"]
    assert told["draws"][-1] == [v0, 1, 0, (0.05,)]


@pytest.mark.parametrize(
    ("kind", "why"),
    [(Kind("robot", 2, steered=True), "agents of kind robot are steered from outside")],
)
def test_kinds_that_no_page_can_fly_are_refused_in_a_line(kind, why):
    with pytest.raises(InputError, match=why) as caught:
        web_program(Flock("vem", agents=5, rng=1, kinds=[kind]))
    assert "\n" not in str(caught.value)
