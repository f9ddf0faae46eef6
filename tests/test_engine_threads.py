"""Any number of threads gives the same bits, however crowded the cells."""

from __future__ import annotations

from unittest.mock import Mock

import numpy as np
import pytest

from agents import Flock
from agents.engine import arrays
from agents.engine.runner import SPLIT_FROM
from worlds.compilation import LoopDispatcher

N = SPLIT_FROM + 1_234
LATE = {"delay": 2.0}


def run(model: str, threads: int, dim: int, side: float, ticks: int = 6) -> Flock:
    flock = Flock(model, agents=N, size=side, dim=dim, rng=5, eta=0.7, v0=0.05, threads=threads)
    flock.run(ticks)
    return flock


@pytest.mark.parametrize(
    ("model", "dim", "side"),
    [
        ("vem", 2, 53.0),
        ("vem-a", 2, 53.0),
        ("vem", 3, 14.0),
        ("inertial-spin", 2, 53.0),
        ("hwvem", 2, 53.0),
        ("ivem", 2, 53.0),
    ],
)
def test_threads_do_not_change_the_bits(model, dim, side):
    one, three = run(model, 1, dim, side), run(model, 3, dim, side)
    assert np.array_equal(one.position, three.position)
    assert np.array_equal(one.heading, three.heading)
    assert np.array_equal(one.signals(), three.signals())


@pytest.mark.parametrize(("model", "least"), [("vem", 10_000), ("ivem", 20_000)])
def test_a_tick_is_shared_from_where_threads_gain(model, least):
    few, many = (Flock(model, agents=n, rng=1, threads=2) for n in (least - 1, least))
    assert (few.engine.parts, many.engine.parts) == (1, 2)


def test_crowds_make_the_desks_grow_on_every_thread():
    """A flock that clumps while it runs on threads outgrows its first workspaces without harm."""
    rng = np.random.default_rng(3)
    position = rng.uniform(0.0, 60.0, (N, 2))
    position[:400] = 30.0 + rng.uniform(0.0, 0.5, (400, 2))
    heading = np.tile([1.0, 0.0], (N, 1))

    def after(threads):
        start = {"position": position, "heading": heading}
        flock = Flock("ivem", start=start, size=60.0, rng=1, eta=0.3, threads=threads)
        flock.run(3)
        assert flock.engine.workspaces[0].block.shape[1] >= 400
        return flock.position

    assert np.array_equal(after(1), after(2))


@pytest.mark.parametrize(
    ("model", "options"),
    [
        ("vem", {}),
        pytest.param("hwvem", {}, marks=pytest.mark.exhaustive),
        pytest.param("topological", {}, marks=pytest.mark.exhaustive),
        pytest.param("vem", {"activation": "random"}, marks=pytest.mark.exhaustive),
        pytest.param("vem", LATE, marks=pytest.mark.exhaustive),
    ],
)
def test_wide_indices_have_the_bits_of_narrow_ones(model, options, monkeypatch):
    """From 2**31 agents on rows are numbered by int64; here from ten on."""

    def after(threads, wide):
        monkeypatch.setattr(arrays, "WIDE_FROM", 10 if wide else 2**31)
        flock = Flock(model, agents=500, rng=2, threads=threads, **options)
        flock.split_from = 1
        flock.run(5)
        assert flock.engine.slots.row.dtype == (np.int64 if wide else np.int32)
        assert flock.engine.grid.start.dtype == flock.engine.slots.row.dtype
        return flock

    narrow, wide, shared = after(1, False), after(1, True), after(2, True)
    for flock in (wide, shared):
        assert np.array_equal(narrow.position, flock.position)
        assert np.array_equal(narrow.heading, flock.heading)
        assert np.array_equal(narrow.signals(), flock.signals())


def test_models_whose_parameters_have_the_same_names_are_each_called_at_once(monkeypatch):
    """numba looks up how to call by names; where it is misled, every call takes its slow way."""
    flocks = [Flock("vem", agents=20, dim=dim, rng=1) for dim in (2, 3)]
    flocks += [Flock("vem", agents=20, rng=1, **way) for way in ({"activation": "random"}, LATE)]
    for flock in flocks:
        flock.run(1)
    slow = Mock()
    monkeypatch.setattr(LoopDispatcher, "compile", slow)
    for flock in flocks:
        flock.run(1)
    assert not slow.called
