"""Experiments that look at a flock closely: its start, layers, turns, split points."""

import math
from dataclasses import replace

import numpy as np
import pytest

from agents import Flock
from agents.run_records import fly
from app.studies.experiment import flock_of
from app.studies.experiment_file import Overrides, with_goal
from app.studies.experiment_reader import read_experiment
from app.studies.figures.beginning import BeginningSettings, nearest_distances
from app.studies.figures.detours import A1, A2, A3, DetourSettings, DetourTrack, boundary_end
from app.studies.figures.evolution import EvolutionSettings
from app.studies.figures.holding import HoldingSettings
from app.studies.figures.layering import LayeringSettings, heeds_lower, shortest_way, shortest_ways
from app.studies.figures.mission import FlownMission
from app.studies.figures.mission_distances import measure_nearest
from app.studies.figures.tangents import TangentSettings, nearest_points
from worlds.input_error import InputError
from worlds.layout import world


def nothing():
    """Between two pieces of a run."""


def case(name, number=0):
    """An experiment's settings and one of its cases."""
    experiment = read_experiment(name)
    return experiment.settings, experiment.cases[number]


def deg_con(flock):
    """(28), (29) of Liu et al. 2021, the information UAV counted."""
    angle = np.arctan2(flock.heading[:, 1], flock.heading[:, 0])
    off = np.angle(np.exp(1j * (angle - math.pi / 4)))
    return 1.0 - math.sqrt((off**2).sum()) / (len(off) * math.pi)


def test_an_evolution_is_measured_at_both_ends():
    settings, one = case("liu2021-fig4")
    settings = settings.model_copy(update={"hold": 5, "limit": 200})
    assert isinstance(settings, EvolutionSettings)
    flock, again = flock_of(one, 3), flock_of(one, 3)
    before = deg_con(flock)
    found = settings.run(flock, nothing)
    assert found["k_con"] == again.run_until_consistent(200, settings.desired, 5)
    assert found["deg_0"] == pytest.approx(before, abs=1e-9)
    assert found["deg"] == pytest.approx(deg_con(flock), abs=1e-9)
    assert found["deg"] > settings.desired
    assert found["order_0"] < 0.3 < found["order"]


@pytest.mark.parametrize("number", [0, 5])
def test_where_a_flock_has_come_to_is_measured(number):
    settings, one = case("liu2021-table1", number)
    flock = flock_of(one, 3)
    found = settings.run(flock, nothing)
    angle = np.angle(np.exp(1j * np.arctan2(*flock.heading.sum(0)[::-1])) / np.exp(0.25j * np.pi))
    assert found["off"] == pytest.approx(np.degrees(abs(angle)), abs=1e-6)
    assert (found["off"] < 1.0) == (one.spec.model == "hwvem"), "vem comes together anywhere"


def test_a_start_is_measured_before_anything_moves():
    settings, one = case("thesis-fig5.6")
    assert isinstance(settings, BeginningSettings)
    flock = flock_of(one, 2)
    found = settings.run(flock, nothing)
    assert flock.tick == 0
    assert (found["agents"], found["obstacles"], found["crashed"], found["inside"]) == (
        50,
        20,
        0,
        0,
    )
    assert found["clear"] > 0.375, "half a body"
    assert found["speed"] == flock.speed.mean()
    flock.position[7] = flock.world.obstacles[0].footprint().centroid.coords[0] + (
        0.5 * sum(flock.world.obstacles[0].spans()[0][1:]),
    )
    flock.position[8, 2] = -0.1
    flock.heading[:] = (0.0, 0.0, 1.0)
    found = settings.run(flock, nothing)
    assert (found["inside"], found["p"]) == (2, 1.0)
    assert found["clear"] < 0.0


def test_gaps_are_seen_across_edges_that_wrap():
    flock = flock_of(case("thesis-fig5.3")[1], 1)
    flock.position[:] = 12.0
    flock.position[:2] = [[0.5, 12.0, 1.0], [23.0, 12.0, 1.0]]
    assert nearest_distances(flock)[:2] == pytest.approx([1.5, 1.5])


def test_the_least_distance_over_time_is_that_of_the_mission():
    one = case("wu2023-fig6", 1)[1]
    flock = flock_of(one, 4)
    record = fly(flock, 400, every=1)
    found = measure_nearest(FlownMission(flock, record))
    assert len(found.agent) == 401
    assert found.agent.min() == record.least_pair
    assert found.obstacle.min() == record.least_obstacle
    start = record.position[0]
    apart = np.linalg.norm(start[:, None] - start, axis=2)[np.triu_indices(30, 1)]
    assert found.agent[0] == pytest.approx(apart.min())


LINE = np.eye(6, k=1) + np.eye(6, k=-1) > 0


def test_layers_are_counted_along_the_shortest_sequence():
    first = np.arange(6) == 0
    assert shortest_ways(LINE, first).tolist() == [1, 2, 3, 4, 5, 6]
    ring = LINE.copy()
    ring[0, 5] = ring[5, 0] = True
    layers = shortest_ways(ring, first)
    assert layers.tolist() == [1, 2, 3, 4, 3, 2]
    assert shortest_way(layers, ring, 4) == [0, 5, 4]
    cut = LINE.copy()
    cut[2, 3] = cut[3, 2] = False
    assert shortest_ways(cut, first).tolist() == [1, 2, 3, 7, 7, 7]


def test_a_uav_that_heeds_a_lower_layer_is_found():
    settings, one = case("liu2021-fig2")
    assert isinstance(settings, LayeringSettings)
    flock = flock_of(one, 1)
    layers = flock.layers()
    near = [flock.inspect(row) for row in range(41)]
    assert not any(heeds_lower(found, layers, 41) for found in near)
    mixed = next(found for found in near if len(set(layers[found.neighbours])) > 1)
    assert heeds_lower(replace(mixed, weights=np.ones_like(mixed.weights)), layers, 41)


def test_layers_and_headings_are_those_counted_apart():
    settings, one = case("liu2021-fig2")
    found = settings.run(flock_of(one, 2), nothing)
    assert found["deepest"] >= 6
    assert (found["off"], found["upper"]) == (0, 0)
    assert found["angle"] < 1e-9


def test_nearest_points_of_discs_and_of_corners():
    scene = world("liu2021-mission", 2)
    places = np.array([[36.9, 7.0], [48.5, -1.5], [48.5, -0.5], [3.5, 6.0]])
    nearest, corner = nearest_points(scene, places)
    assert nearest == pytest.approx(
        np.array([[36.9, 6.45], [48.5, -1.2], [48.5, -0.7], [3.9, 6.3]]), abs=1e-9
    )
    assert corner.tolist() == [False, True, False, True]


def test_uavs_turn_along_tangents_and_nowhere_else():
    settings, one = case("liu2021-fig3")
    assert isinstance(settings, TangentSettings)
    found = settings.run(flock_of(one, 6), nothing)
    assert found["avoids"] > 50
    assert found["corners"] > 50
    assert found["off"] <= 1.5
    assert 45.0 < found["turned"] <= 90.0
    assert found["kept"] == 0.0
    literal = flock_of(one, 6)
    literal.set(theta_obstruct=0.01)
    assert settings.model_copy().run(literal, nothing)["avoids"] < 10


@pytest.mark.parametrize("number", [0, 1])
def test_split_and_rejoin_points_are_as_the_paper_defines_them(number):
    settings, one = case("wu2023-fig3", number)
    settings = settings.model_copy(update={"limit": 20.0})
    assert isinstance(settings, DetourSettings)
    flock, again = flock_of(one, 1), flock_of(one, 1)
    found, course = settings.run(flock, nothing), settings.follow_agent(again)
    assert found["splits"] >= found["again"] > 0
    assert found["rejoins"] == len(course.rejoin_ticks)
    for tick in course.split_ticks:
        assert course.split[tick].tolist() == course.position[tick].tolist()
    for tick in np.flatnonzero(course.scenario == A2):
        assert course.split[tick].tolist() == course.split[tick - 1].tolist()
    assert set(np.flatnonzero(course.scenario == A3)) <= set(course.rejoin_ticks)
    assert found["gained"] >= 0.0
    assert found["behind"] > 0.0
    assert found["off"] < 1e-9


def test_the_end_of_a_boundary_is_before_the_first_gap():
    flock = flock_of(case("wu2023-fig4")[1], 1)
    place = np.array([[43.0, 8.0]])
    none = np.zeros((1, 2))
    goal = np.array([75.0, 8.0])
    course = DetourTrack(place, np.array([A1]), none, none, none, np.zeros(1), goal)
    aim, phase = boundary_end(flock, course, 0)
    seen = aim - course.position[0]
    assert phase == pytest.approx(math.atan2(seen[1], seen[0]) % (2.0 * math.pi))
    flock.set(sense="clockwise")
    other, _ = boundary_end(flock, course, 0)
    assert aim[1] < 8.0 < other[1], "behind it the diamond spans less than half a turn"


def test_a_car_is_held_near_the_place():
    settings, one = case("jacobs-gallery1")
    settings = settings.model_copy(update={"limit": 20.0})
    assert isinstance(settings, HoldingSettings)
    flock = flock_of(one, 3)
    assert flock.goal_at([0, 1000]).tolist() == [[0.0, 0.0], [0.0, 0.0]]
    found = settings.run(flock, nothing)
    position = settings.drive(flock_of(one, 3))
    away = np.linalg.norm(position[:, 0], axis=1)
    assert found["furthest"] == pytest.approx(away[1000:].max())
    assert found["held"] == 100
    assert found["came"] == pytest.approx(flock.dt * np.flatnonzero(away <= 1.5)[0])
    assert found["collision"] == 0
    tight = settings.model_copy(update={"radius": 0.5})
    assert tight.run(flock_of(one, 3), nothing)["held"] == 0


def test_a_goal_rests_or_moves():
    with pytest.raises(ValueError, match="rests has no speed"):
        Overrides(rests=(0.0, 0.0), speed=1.0)
    with pytest.raises(InputError, match="has no goal"):
        with_goal(world("open", 2, 5.0), Overrides(rests=(1.0, 2.0)))
    with pytest.raises(InputError, match="it has no goal"):
        HoldingSettings(world="open", limit=1.0, radius=1.0, late=0.5).run(
            Flock("squashing-cars", agents=1, world="open", size=8.0, rng=1), nothing
        )
