"""Observables as compiled loops give what the same observables give in NumPy."""

from __future__ import annotations

import inspect
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.flock import Flock
from agents.observables.catalogue import OBSERVABLES
from agents.observables.of_rows import empty_cells
from agents.web_program import first_call
from worlds.compilation import plain_python

COMPILED = {name: one for name, one in OBSERVABLES.items() if one.compiled is not None}
FLOCKS = {
    "in a box that closes": ("vem", {"agents": 40}),
    "in space": ("couzin", {"agents": 30}),
    "to a goal": ("hwvem-nav", {"agents": 20}),
    "led": ("hwvem", {"agents": 25}),
    "along walls": ("pedestrian", {"agents": 20}),
    "with crashes": ("thesis", {"agents": 30}),
    "alone": ("vem", {"agents": 1}),
    "two": ("vem", {"agents": 2}),
}


def as_a_page_has_it(flock: Flock, name: str) -> float:
    """The value of an observable by its loop over rows, as plain Python."""
    call = first_call(flock)
    names = inspect.signature(call.function.py_func).parameters
    given = dict(zip(names, call.arguments, strict=True)) | {
        "cells": empty_cells(len(flock.ids)),
        "converges": bool(flock.model.rule.converges),
        "together": flock.together,
        "tick": flock.tick,
    }
    compute = COMPILED[name].compiled.py_func
    with plain_python():
        return compute(*(given[name] for name in inspect.signature(compute).parameters))


@pytest.mark.parametrize("case", FLOCKS)
def test_a_loop_over_rows_gives_what_numpy_gives(case):
    model, options = FLOCKS[case]
    flock = Flock(model, rng=4, **options)
    for _ in range(3):
        for name, observable in COMPILED.items():
            if observable.applies(flock):
                expected = flock.observe(name)
                assert as_a_page_has_it(flock, name) == pytest.approx(
                    expected, rel=1e-9, abs=1e-9, nan_ok=True
                ), name
        flock.run(15)


def apart(a: np.ndarray, b: np.ndarray, size: np.ndarray, images: np.ndarray) -> float:
    """The distance of two places, by the nearest image."""
    offset = b - a
    return float(np.linalg.norm(np.where(images, offset - size * np.round(offset / size), offset)))


def pieces(near: np.ndarray) -> list[int]:
    """How many agents each connected group has, (N, N) bool."""
    left, sizes = set(range(len(near))), []
    while left:
        group = {min(left)}
        while more := {j for i in group for j in np.flatnonzero(near[i])} - group:
            group |= more
        left -= group
        sizes.append(len(group))
    return sizes


@settings(max_examples=100, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(2, 3),
    st.integers(2, 25),
    st.sampled_from([0.02, 0.3, 1.0, 3.0]),
)
def test_who_is_near_whom_is_found_however_they_stand(seed, dim, agents, reach):
    """In one heap or far apart, on a line, over the seam or not, some of them crashed."""
    rng = np.random.default_rng(seed)
    size, images = rng.uniform(1.0, 5.0, 3), rng.integers(0, 2, 3)
    shape = rng.choice([1.0, 0.0, 1e-3], 3) * rng.choice([0.01, 1.0])
    position = (rng.uniform(-1.0, 1.0, (agents, 3)) * size * shape)[:, :dim]
    crash_record = np.where(rng.random((agents, 1)) < 0.2, 1.0, -1.0)
    flock = SimpleNamespace(position=position, crash_record=crash_record)
    space = SimpleNamespace(size=size, images=images)
    there = position[crash_record[:, 0] < 0.0]
    closes = images[:dim].astype(bool)
    distance = np.array([[apart(a, b, size[:dim], closes) for b in there] for a in there])
    distance = distance.reshape(len(there), len(there))
    near = (distance > 0.0) & (distance <= reach)
    others = distance[~np.eye(len(there), dtype=bool)]
    given = {
        "flock": flock,
        "space": space,
        "context": SimpleNamespace(reach=reach),
        "together": reach,
        "cells": empty_cells(agents),
    }
    expected = {
        "nearest-neighbour": min(others, default=np.inf),
        "mean-neighbours": near.sum() / len(there) if len(there) else 0.0,
        "groups": len(pieces(near)),
        "largest-group": max(pieces(near), default=0),
    }
    for name, value in expected.items():
        compute = COMPILED[name].compiled.py_func
        with plain_python():
            found = compute(*(given[one] for one in inspect.signature(compute).parameters))
        assert found == pytest.approx(value, rel=1e-9, abs=1e-12), name
