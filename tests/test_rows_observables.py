"""Observables as compiled loops give what the same observables give in NumPy."""

from __future__ import annotations

import inspect
import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.flock import Flock, measure_observable
from agents.individuals import uniform
from agents.kinds import Kind, chase
from agents.observables import of_rows, order
from agents.observables.catalogue import OBSERVABLES
from agents.observables.groups import rank_groups
from agents.observables.of_rows import empty_cells, groups, layers
from agents.web.web_program import first_call
from worlds.compilation import plain_python

COMPILED = {name: one for name, one in OBSERVABLES.items() if one.compiled is not None}
HUNTERS = Kind("hunter", 3, to={"flock": chase(2.0, 2.0, catch=0.3, caught="frozen")})
FLOCKS = {
    "in a box that closes": ("vem", {"agents": 40}),
    "in space": ("couzin", {"agents": 30}),
    "to a goal": ("hwvem-nav", {"agents": 20}),
    "led": ("hwvem", {"agents": 25}),
    "along walls": ("pedestrian", {"agents": 20}),
    "with crashes": ("thesis", {"agents": 30}),
    "with hunters": ("vem", {"agents": 40, "kinds": [HUNTERS]}),
    "of two kinds": ("vem", {"agents": 30, "kinds": [Kind("slow", 20, v0=0.01)]}),
    "with speeds of their own": ("couzin", {"agents": 30, "dim": 2, "s": uniform(2.0, 4.0)}),
    "alone": ("vem", {"agents": 1}),
    "two": ("vem", {"agents": 2}),
}


def loop_arguments(flock: Flock) -> dict[str, Any]:
    """What a page has for its loops over rows."""
    call = first_call(flock)
    names = inspect.signature(call.function.py_func).parameters
    return dict(zip(names, call.arguments, strict=True)) | {
        "cells": empty_cells(len(flock.ids)),
        "converges": bool(flock.model.rule.converges),
        "together": flock.together,
        "caught": float(len(flock.catches)),
        "tick": flock.tick,
    }


def as_a_page_has_it(flock: Flock, name: str, **changes: float) -> float:
    """The value of an observable by its loop over rows, as plain Python."""
    given = loop_arguments(flock) | changes
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


def test_a_loop_measures_agents_of_a_kind_alone_where_the_others_count_as_caught():
    """As a page does: see `measure` of static/export/kinds.js."""
    model, options = FLOCKS["with hunters"]
    flock = Flock(model, rng=4, **options)
    flock.run(60)
    caught = {name: float(len(flock.catches_of(name))) for name in flock.kinds.names}
    assert caught["flock"] > 0 == caught["hunter"]
    before = flock.arrays.kind.copy()
    for kind, count in caught.items():
        for name, observable in COMPILED.items():
            if not observable.applies(flock):
                continue
            expected = measure_observable(flock, name, kind)
            flock.arrays.kind[before != flock.kinds.number(kind)] = -1.0
            value = as_a_page_has_it(flock, name, caught=count)
            flock.arrays.kind[:] = before
            assert value == pytest.approx(expected, rel=1e-9, abs=1e-9, nan_ok=True), name


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(2, 3), st.integers(0, 30), st.booleans())
def test_ranks_and_kinds_are_those_of_numpy_with_ties_and_who_is_out(seed, dim, agents, closes):
    """Some are as fast as others, some stand still or crashed, some were caught."""
    rng = np.random.default_rng(seed)
    size = rng.uniform(1.0, 5.0, dim)
    images = np.full(dim, closes)
    position = rng.uniform(0.0, 1.0, (agents, dim)) * size
    heading = rng.normal(size=(agents, dim))
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    speed = rng.choice([0.0, 1.0, 1.5, 2.0], agents)
    kind = rng.choice([-1.0, 0.0, 1.0, 2.0], agents, p=[0.2, 0.4, 0.3, 0.1])
    crash_record = np.where(rng.random((agents, 1)) < 0.2, 1.0, -1.0)
    flock = SimpleNamespace(
        position=position, heading=heading, speed=speed, kind=kind, crash_record=crash_record
    )
    padded = np.ones(3), np.zeros(3, int)
    padded[0][:dim], padded[1][:dim] = size, images
    space, cells = SimpleNamespace(size=padded[0], images=padded[1]), empty_cells(agents)
    reach = float(rng.uniform(0.1, 1.5))
    active = (crash_record[:, 0] < 0.0) & (kind >= 0.0)
    there, of = position[active], kind[active]
    distance = np.array([[apart(a, b, size, images) for b in there] for a in there])
    differs = of[:, None] != of
    near = (distance <= reach) & ~np.eye(len(there), dtype=bool)
    has_two = len(set(of)) > 1
    nearest = [row[other].min() for row, other in zip(distance, differs, strict=True) if has_two]
    expected = {
        of_rows.kind_distance: np.mean(nearest) if has_two else math.nan,
        of_rows.kind_mixing: differs[near].mean() if has_two and near.any() else math.nan,
        of_rows.direction: order.direction(heading[active]),
        of_rows.fast_in_front: order.fast_in_front(
            there, (heading * speed[:, None])[active], size, images
        ),
    }
    given_ = {
        "flock": flock,
        "space": space,
        "context": SimpleNamespace(reach=reach),
        "cells": cells,
    }
    with plain_python():
        for compute, value in expected.items():
            loop = compute.py_func
            found = loop(*(given_[name] for name in inspect.signature(loop).parameters))
            assert found == pytest.approx(value, rel=1e-9, abs=1e-9, nan_ok=True), loop.__name__


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


def hops(near: np.ndarray, informed: np.ndarray, agents: int) -> list[int]:
    """The layer of each of those that are near each other, (N, N) bool; one more than all: none."""
    layer, reached = np.where(informed, 1, agents + 1), informed
    for depth in range(2, len(near) + 1):
        reached = near @ reached & (layer > agents)
        layer[reached] = depth
    return layer.tolist()


@pytest.mark.parametrize("case", ["in space", "to a goal", "led"])
def test_labels_of_groups_and_layers_are_those_of_the_flock(case):
    model, options = FLOCKS[case]
    flock = Flock(model, rng=4, **options)
    flock.run(15)
    given = loop_arguments(flock)
    cells = given["cells"]
    with plain_python():
        groups.py_func(*(given[one] for one in inspect.signature(groups.py_func).parameters))
        for row, other in enumerate(cells.parent):  # of a row before, whose own is known
            cells.parent[row] = cells.parent[other]
        assert rank_groups(cells.parent).tolist() == flock.group_labels().tolist()
        layers.py_func(*(given[one] for one in inspect.signature(layers.py_func).parameters))
    assert cells.parent.tolist() == flock.layers().tolist()


@settings(max_examples=100, deadline=None)
@given(
    st.integers(0, 2**32 - 1),
    st.integers(2, 3),
    st.integers(2, 25),
    st.sampled_from([0.02, 0.3, 1.0, 3.0]),
)
def test_who_is_near_whom_is_found_however_they_stand(seed, dim, agents, reach):
    """In one heap or far apart, on a line, over the seam or not, some crashed or caught."""
    rng = np.random.default_rng(seed)
    size, images = rng.uniform(1.0, 5.0, 3), rng.integers(0, 2, 3)
    shape = rng.choice([1.0, 0.0, 1e-3], 3) * rng.choice([0.01, 1.0])
    position = (rng.uniform(-1.0, 1.0, (agents, 3)) * size * shape)[:, :dim]
    crash_record = np.where(rng.random((agents, 1)) < 0.2, 1.0, -1.0)
    informed = rng.random(agents) < 0.2
    kind = np.where(rng.random(agents) < 0.2, -1.0, 0.0)
    active = (crash_record[:, 0] < 0.0) & (kind >= 0.0)
    flock = SimpleNamespace(
        position=position, crash_record=crash_record, informed=informed, kind=kind
    )
    space = SimpleNamespace(size=size, images=images)
    there = position[active]
    closes = images[:dim].astype(bool)
    distance = np.array([[apart(a, b, size[:dim], closes) for b in there] for a in there])
    distance = distance.reshape(len(there), len(there))
    near = (distance > 0.0) & (distance <= reach)
    others = distance[~np.eye(len(there), dtype=bool)]
    cells = empty_cells(agents)
    given = {
        "flock": flock,
        "space": space,
        "context": SimpleNamespace(reach=reach),
        "together": reach,
        "cells": cells,
    }
    with plain_python():
        known = layers.py_func(flock, space, given["context"], cells)
    assert cells.parent[active].tolist() == hops(near, informed[active], agents)
    assert known == np.count_nonzero(cells.parent <= agents)
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
