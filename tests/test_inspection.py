"""An agent seen from close: the weights are those that its rule works with."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents import Flock
from agents.engine.cache import is_kept
from agents.inspection import UNSEEN, Shell, shells, zones_of

LINEAR = ["vem", "vem-a", "wvem", "hwvem"]


@pytest.mark.parametrize("model", LINEAR)
@pytest.mark.parametrize("dim", [2, 3])
def test_the_weighted_mean_of_the_inspected_is_the_next_heading(model, dim):
    flock = Flock(model, agents=80, dim=dim, size=3.2, rng=4)
    for _ in range(4):
        before, heading = (
            [flock.inspect(row) for row in range(81 - (model == "vem"))],
            flock.heading,
        )
        heading = heading.copy()
        flock.run(1)
        for seen in before:
            if flock.informed[seen.row]:
                assert not seen.weights.any()
                continue
            wish = seen.weights @ heading[seen.neighbours]
            if model.startswith("vem"):
                wish = wish + heading[seen.row]
            if np.linalg.norm(wish) > 1e-3 * max(1e-9, seen.weights.sum()):
                expected = wish / np.linalg.norm(wish)
                assert np.allclose(flock.heading[seen.row], expected, atol=1e-9)


def test_only_the_extremes_count_in_ivem():
    heading = [[np.cos(a), np.sin(a)] for a in (0.5, 1.0, 2.0, 3.0)]
    position = [[1.0, 1.0], [1.1, 1.0], [1.2, 1.0], [1.3, 1.0]]
    flock = Flock("ivem", start={"position": position, "heading": heading}, size=9.0, rng=1)
    assert flock.inspect(0).weights.tolist() == [1.0, 0.0, 1.0]


def test_contact_with_the_information_agent_outweighs_all_in_ivem_a():
    position = [[1.0, 1.0], [1.1, 1.0], [1.2, 1.0]]
    heading = [[1.0, 0.0], [0.0, 1.0], [0.6, 0.8]]
    start = {"position": position, "heading": heading, "informed": [True, False, False]}
    flock = Flock("ivem-a", start=start, size=9.0, rng=1)
    assert flock.inspect(1).weights.tolist() == [100.0, 1.0]


@pytest.mark.parametrize("seed", range(12))
def test_every_tick_can_be_inspected(seed):
    """The key of a tick is any 64-bit number."""
    flock = Flock("hwvem", agents=20, size=2.0, rng=seed)
    flock.run(seed)
    assert flock.inspect(3).id == flock.ids[3]


def test_what_an_inspection_calls_is_kept_for_the_next_process():
    flock = Flock("olfati-saber", agents=30, rng=2)
    assert any(len(flock.inspect(row).weights) for row in range(30))
    rule = flock.model.rule
    assert is_kept(rule.weigh.for_python)
    assert is_kept(rule.explain.for_python)


@pytest.mark.parametrize("model", ["olfati-saber", "boundary-points"])
def test_the_forces_on_the_inspected_are_what_moves_it(model):
    flock = Flock(model, world="wu2023-multi", agents=12, rng=2)
    flock.run(150)
    for _ in range(40):
        seen = [flock.inspect(row) for row in range(12)]
        before = flock.speed[:, None] * flock.heading
        flock.run(1)
        for one in seen:
            want = before[one.row] + flock.dt * sum(one.forces.values())
            speed = np.linalg.norm(want)
            moved = want * min(1.0, flock.parameters.p_max / speed)
            now = flock.speed[one.row] * flock.heading[one.row]
            assert np.allclose(now, moved, rtol=1e-9, atol=1e-9)


def test_the_inspected_perceives_the_boundary_points_within_reach():
    flock = Flock("boundary-points", world="wu2023-multi", agents=6, rng=2)
    flock.position[0] = (34.0, 31.0)
    surroundings = flock.engine.surroundings
    points = np.column_stack([surroundings.point_x, surroundings.point_y])
    near = points[np.linalg.norm(points - flock.position[0], axis=1) <= flock.reach]
    found = flock.inspect(0).points
    assert len(near) > 5
    assert sorted(map(tuple, found)) == sorted(map(tuple, near))
    assert len(Flock("hwvem-nav", agents=3, rng=1).inspect(1).points) == 0


def test_the_terms_of_a_body_are_its_velocity():
    flock = Flock("hwvem-nav", agents=30, rng=3)
    flock.run(5)
    seen = flock.inspect(7).forces
    assert list(seen) == ["alignment", "repulsion", "attraction"]
    assert np.linalg.norm(seen["alignment"]) == pytest.approx(flock.parameters.v0)


def test_an_information_agent_has_no_forces():
    flock = Flock("hwvem-nav", agents=5, rng=3)
    assert flock.inspect(0).forces == {}


def test_warming_leaves_the_flock_as_it_is():
    flock, twin = (Flock("boundary-points", agents=8, rng=2) for _ in range(2))
    flock.run(100)
    flock.warm()
    flock.run(50)
    twin.run(150)
    assert np.array_equal(flock.position, twin.position)


def zone_of(apart: np.ndarray, heading: np.ndarray, rings: tuple[Shell, ...], view: float) -> int:
    """The zone that one place is in, by an angle and an if for each case."""
    distance = float(np.sqrt(sum(float(c) ** 2 for c in apart)))
    off = np.degrees(np.arccos(np.clip(float(apart @ heading) / distance, -1.0, 1.0)))
    for index, ring in enumerate(rings):
        closed = index == len(rings) - 1
        if distance < ring.radius or (closed and distance == ring.radius):
            return index if ring.all_round or 2.0 * off <= view else UNSEEN
    return UNSEEN


@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from([2, 3]),
    st.floats(1.0, 359.0),
    st.lists(st.tuples(st.floats(0.0, 3.0), st.booleans()), min_size=1, max_size=4),
)
def test_every_place_is_in_the_zone_that_its_distance_and_angle_say(seed, dim, view, wide):
    rng = np.random.default_rng(seed)
    heading = rng.standard_normal(dim)
    heading /= np.linalg.norm(heading)
    radii = np.cumsum([width for width, _ in wide])
    rings = tuple(
        Shell(f"zone {k}", float(radius), round_)
        for k, (radius, (_, round_)) in enumerate(zip(radii, wide, strict=True))
    )
    apart = rng.standard_normal((60, dim)) * rng.uniform(0.1, 5.0, (60, 1))
    expected = [zone_of(place, heading, rings, view) for place in apart]
    assert zones_of(apart, heading, rings, view).tolist() == expected


def test_a_place_on_a_border_is_in_the_outer_zone_and_on_the_last_within():
    rings = (Shell("near", 1.0, False), Shell("far", 2.0, False))
    ahead = np.array([1.0, 0.0])
    apart = np.array([[1.0, 0.0], [2.0, 0.0], [0.01, 1.5], [-0.5, 0.0], [2.5, 0.0]])
    assert zones_of(apart, ahead, rings, 180.0).tolist() == [1, 1, 1, UNSEEN, UNSEEN]
    assert zones_of(apart, ahead, rings, 360.0).tolist() == [1, 1, 1, 0, UNSEEN]


@pytest.mark.parametrize("dim", [2, 3])
def test_those_that_count_in_couzins_rule_are_those_of_the_zones(dim):
    flock = Flock("couzin", agents=60, dim=dim, size=9.0, rng=5, dr_a=3.0, alpha=200.0)
    assert [(one.name, one.radius) for one in shells(flock)] == [
        ("repulsion", 1.0),
        ("orientation", 4.0),
        ("attraction", 7.0),
    ]
    repelled = 0
    for row in range(60):
        seen = flock.inspect(row)
        assert seen.view == 200.0
        close = seen.zone == 0
        repelled += close.any()
        wanted = close if close.any() else seen.zone > 0
        assert np.array_equal(seen.weights > 0.0, wanted)
    assert 0 < repelled < 60


def test_a_rule_without_zones_has_none():
    seen = Flock("vem", agents=20, rng=1).inspect(0)
    assert (len(seen.zone), seen.shells, seen.view) == (0, (), 360.0)


def test_the_crashed_are_nobodys_neighbours_and_listen_to_nobody():
    position = [[5.0, 5.0, 5.0], [5.2, 5.0, 5.0], [9.5, 5.0, 5.0]]
    heading = [[1.0, 0.0, 0.0]] * 3
    start = {"position": position, "heading": heading}
    flock = Flock("thesis", start=start, rng=1, d_a=6.0, alpha=360.0)
    assert flock.inspect(2).neighbours.tolist() == [0, 1]
    flock.run(1)
    assert flock.active.tolist() == [False, False, True]
    assert flock.inspect(2).neighbours.tolist() == []
    crashed = flock.inspect(0)
    assert len(crashed.neighbours) == len(crashed.weights) == len(crashed.zone) == 0
    assert (crashed.forces, crashed.shells) == ({}, ())
