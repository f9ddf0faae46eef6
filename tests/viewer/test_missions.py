"""What the laboratory measures and says of a mission, and what Setup knows of worlds."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.inspection import Inspection
from agents.observables.neighbours import nearest_neighbour
from agents.spec import Spec
from app.viewer.lab.panels.flock_monitors import (
    mission_numbers,
    mission_title,
    numbers,
    titled_cards,
)
from app.viewer.lab.panels.inspector import signal_facts
from app.viewer.lab.panels.setup import describe_differences
from app.viewer.measuring.flock_readings import (
    MOST_AGENTS,
    FlockReadings,
    MinimumDistances,
    arrived_share,
)
from app.viewer.run.flock_run import FlockRun
from app.viewer.run.frame_builder import FrameBuilder, FrameRequest
from app.viewer.run.run_preset import (
    lively_speed,
    preset_spec,
    world_defaults,
    world_title,
    world_titles,
)
from app.viewer.run.simulation_state import SimulationState
from app.viewer.scene.shown.frame import Frame, MissionProgress
from tests.viewer.waiting import until
from worlds.input_error import InputError
from worlds.layout import layout_names, world
from worlds.mission import Goal, Mission, Path
from worlds.queries.clearance import clearance
from worlds.world import World


def flying(name: str = "liu2021-mission", agents: int = 12, **more) -> Flock:
    return Flock("hwvem-nav", agents=agents, world=name, rng=5, **more)


def test_extremes_are_those_of_every_tick():
    flock, twin = flying("obstacles"), flying("obstacles")
    extremes = MinimumDistances(flock)
    gap = far = np.inf
    for ticks in (1, 7, 40):
        extremes.run(ticks)
    for tick in range(49):
        away = np.linalg.norm(twin.position[:, None] - twin.position, axis=2)
        gap = min(gap, away[np.triu_indices(len(away), 1)].min())
        far = min(far, clearance(twin.world, twin.position).min())
        if tick < 48:
            twin.advance(1)
    assert flock.tick == twin.tick == 48
    assert np.array_equal(flock.position, twin.position)
    assert extremes.values()["least-gap"] == pytest.approx(gap)
    least = extremes.values()["least-clearance"]
    assert least == (pytest.approx(far) if far <= flock.sight else np.inf)


def test_an_agent_inside_an_obstacle_is_a_collision():
    flock = flying("obstacles")
    flock.position[3] = (12.5, 19.0)
    assert MinimumDistances(flock).values()["inside"] == 1.0
    assert MinimumDistances(flock).values()["least-clearance"] == pytest.approx(-3.0, abs=0.01)


def test_nothing_is_watched_where_there_is_nothing_to_run_into():
    flock = Flock("vem", agents=10, rng=1)
    extremes = MinimumDistances(flock)
    extremes.run(3)
    assert flock.tick == 3
    assert extremes.values() == {}
    many = flying("obstacles", agents=MOST_AGENTS + 10)
    assert not MinimumDistances(many).is_wanted


def test_readings_of_a_mission_have_its_distance_and_who_follows():
    flock = flying()
    readings = FlockReadings(flock)
    readings.read(at_once=True)
    flock.advance(30)
    readings.read(at_once=True)
    end = np.array(flock.world.mission.path.waypoints[-1])
    away = np.linalg.norm(flock.position.mean(axis=0) - end)
    assert readings.values["goal-distance"] == pytest.approx(away)
    assert readings.values["following"] == pytest.approx(flock.observe("following"))
    ticks, distance = readings.series("goal-distance").arrays()
    assert ticks.tolist() == [0, 30]
    assert distance[1] == pytest.approx(away)
    assert "through" not in readings.values


def test_who_is_near_the_goal_has_arrived():
    flock = flying("obstacles", agents=9)
    goal = flock.goal_at([0])[0]
    flock.position[:] = goal + 30.0
    flock.position[:4] = goal
    assert arrived_share(flock) == pytest.approx(0.4)


def test_a_frame_knows_how_the_mission_stands():
    flock = flying("obstacles")
    frame = FrameBuilder(flock, 1).build()
    assert frame.world is flock.world
    assert frame.progress.goal.tolist() == [30.0, 5.0]
    assert frame.progress.done == 0
    assert [corner.tolist() for corner in frame.room] == [[2.0, 2.0], [14.0, 12.0]]
    flock.arrays.leg[flock.informed] = 2
    assert FrameBuilder(flock, 1).build().progress.done == 2
    assert FrameBuilder(Flock("vem", agents=3, rng=1), 1).build().progress == MissionProgress()


def test_a_start_region_of_a_density_depends_on_the_number_of_agents():
    low, high = FrameBuilder(flying(agents=49), 1).build().room
    assert np.prod(high - low) == pytest.approx(50 / 3.265)


def test_boundary_points_are_one_array_until_the_world_changes():
    flock = flying()
    camera = FrameBuilder(flock, 1, FrameRequest(points=True))
    camera.examine()
    first = camera.build().points
    away = clearance(flock.world, first)
    assert np.abs(away).max() < 1e-9
    camera.examine()
    assert camera.build().points is first
    flock.change_world(world("obstacles"))
    camera.examine()
    assert camera.build().points is not first
    camera.set_request(FrameRequest())
    camera.examine()
    assert camera.build().points is None


def test_an_agent_is_inspected_as_soon_as_what_it_takes_is_compiled():
    run = FlockRun(flying(), 1, FrameRequest(row=4))
    until(lambda: run.look(closely=False).inspected, 60)
    seen = run.look(closely=False).inspected
    assert list(seen.forces) == ["alignment", "repulsion", "attraction"]
    assert not run.troubles


def frame_of(place: World, **more) -> Frame:
    n = 2
    position = np.zeros((n, place.dim))
    given = {"informed": np.array([True, False])} | more
    return Frame(
        1, 615, place, 1.0, 1.0, position, position, np.zeros(n), ids=np.arange(n), **given
    )


def test_monitors_say_only_what_the_world_has():
    plain = World("wrap", (5.0, 5.0), ("wrap", "wrap"))
    assert (mission_title(frame_of(plain)), mission_numbers(frame_of(plain), {})) == ("", {})
    assert titled_cards("Mission", {}) == ""
    walled = World("box", (5.0, 5.0), ("solid", "solid"))
    told = mission_numbers(frame_of(walled), {"least-clearance": 0.25, "inside": 1.0})
    assert told == {"to obstacle": "0.25", "collisions": "1"}
    sent = World(
        "sent",
        (5.0, 5.0),
        ("open", "open"),
        mission=Mission(path=Path(waypoints=((1.0, 1.0), (2.0, 2.0)), switch=0.1)),
    )
    values = {"goal-distance": 3.14159, "following": 0.5, "least-gap": np.inf}
    told = mission_numbers(frame_of(sent, progress=MissionProgress(done=1)), values)
    assert told == {
        "to path's end": "3.14",
        "waypoint": "2 / 2",
        "following": "50 %",
        "closest pair": "far",
    }
    assert (
        mission_numbers(frame_of(sent, progress=MissionProgress(done=2)), {})["waypoint"]
        == "all done"
    )
    sought = World(
        "sought", (5.0, 5.0), ("open", "open"), mission=Mission(goal=Goal(route=((1.0, 1.0),)))
    )
    told = mission_numbers(frame_of(sought), {"goal-distance": 1.0, "through": 0.25})
    assert told == {"to goal": "1", "arrived": "25 %"}


def test_time_is_told_in_seconds_where_bodies_count_them():
    place = World("wrap", (5.0, 5.0), ("wrap", "wrap"))
    state = SimulationState(preset_spec("vem"))
    assert "time" not in numbers(state, frame_of(place), {}, 1)
    timed = frame_of(place, dt=0.02, unit="s")
    told = numbers(state, timed, {}, 1)
    assert (told["tick"], told["time"]) == ("615", "12.3 s")
    assert timed.pace_unit == "m/s"


def test_browsers_are_counted_when_there_are_several_and_rotation_where_there_are_zones():
    frame = frame_of(World("wrap", (5.0, 5.0), ("wrap", "wrap")))
    assert "browsers" not in numbers(SimulationState(preset_spec("vem")), frame, {}, 1)
    told = numbers(SimulationState(preset_spec("couzin")), frame, {"angular-momentum": 0.5}, 2)
    assert (told["browsers"], told["angular momentum"]) == ("2", "0.500")
    assert "consistency" not in told


def test_places_in_memory_are_told_as_points_and_only_while_they_count():
    signals = {"following": 1.0, "split_x": 1.0, "split_y": 2.0, "layer": np.inf}
    nobody = np.empty(0, int), np.empty((0, 2)), np.empty(0)
    seen = Inspection(1, 1, *nobody, signals, places=("split",), minds=True)
    told = signal_facts(seen)
    assert told == {"following": "1", "split": "(1.00, 2.00)", "layer": "unknown"}
    assert "split" not in signal_facts(replace(seen, minds=False))


def test_a_model_starts_in_the_world_that_it_is_at_home_in():
    own = preset_spec("hwvem-nav")
    assert (own.world, own.agents, own.dim) == ("liu2021-mission", 49, 2)
    assert preset_spec("hwvem-nav", agents=None, world="rooms-3d").dim == 3
    assert preset_spec("hwvem-nav", agents=7, world="rooms-3d", dim=3).agents == 7
    plain = {"agents": 100, "informed": 1, "world": "wrap", "dim": 2}
    assert preset_spec("hwvem") == preset_spec() == Spec("hwvem", seed=1, **plain)
    for name in MODELS:
        assert len(Flock(preset_spec(name, seed=2)).ids) >= 1
    with pytest.raises(InputError, match="obstacles"):
        preset_spec("hwvem", world="obstacle")


def test_a_model_starts_in_its_own_dimension_and_at_its_own_spacing():
    assert (preset_spec("couzin").dim, preset_spec("couzin", dim=2).dim) == (3, 2)
    assert (preset_spec("thesis").dim, preset_spec("thesis").world) == (3, "thesis-sky")
    assert Flock(preset_spec("echelon")).spec.spacing == MODELS["echelon"].spacing
    wide = Flock(preset_spec("thesis", spacing=2.0, agents=20, seed=4))
    assert nearest_neighbour(wide.position, wide.world.size, wide.world.images).min() >= 2.0
    apart = preset_spec("vem", spacing=1.0)
    assert describe_differences((preset_spec("vem"), None), (apart, None)) == ["spacing"]


def test_a_world_decides_its_dimension_and_its_side():
    assert world_defaults("wrap").dim is None
    assert not world_defaults("wrap").sized
    assert world_defaults("rooms-3d").dim == 3
    assert world_defaults("obstacles").sized
    assert world_defaults(world("obstacles")).dim == 2


def test_every_built_in_world_can_be_chosen_by_its_own_words(tmp_path):
    titles = world_titles()
    assert sorted(titles.values()) == layout_names()
    assert titles["wraps around"] == "wrap"
    assert all(world_title(name) == words for words, name in titles.items())
    file = tmp_path / "mine.toml"
    file.write_text('title = "My own"\nsize = [4.0, 4.0]\n')
    assert world_title(str(file)) == "My own"


def test_seconds_pass_faster_than_in_life():
    body = SimpleNamespace(unit="s", lasts=lambda _p: 0.02)
    made = SimpleNamespace(body=body, parameters=MODELS["vem"].parameters)
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(MODELS, "slow", made)
        assert lively_speed(Spec("slow")) == pytest.approx(250.0)
    assert lively_speed(preset_spec("vem")) == 15.0


def test_without_a_mission_nobody_is_told_who_follows():
    plain = World("wrap", (5.0, 5.0), ("wrap", "wrap"))
    assert mission_numbers(frame_of(plain), {"following": 0.5}) == {}
