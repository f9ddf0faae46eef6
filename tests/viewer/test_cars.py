"""Cars on the display: their meshes, sizes, wheels and marks, the injected car, the fence."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents import Flock
from agents.models.declare import Vehicle
from app.viewer.run.frame_builder import FrameBuilder
from app.viewer.scene.draw.agent_meshes import AXLES, TRACK, TREAD, WHEEL, cabin, hubs, hull, wheel
from app.viewer.scene.draw.drawn_frame import LEAST_CAR
from app.viewer.scene.marks.agents import Agents, FlockMotion
from app.viewer.scene.marks.area import INSIDE, Fence, fence
from app.viewer.scene.marks.car_outlines import RADIUS, StuckMarks
from app.viewer.scene.marks.fleet import wheels
from app.viewer.scene.marks.flock_marks import RADIUS_CAR
from app.viewer.scene.marks.labels import name
from app.viewer.scene.marks.mission_marks import InjectedCar, MissionMarks, route_azimuth
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.drawing_style import DrawingStyle, legend
from app.viewer.scene.shown.frame import MissionProgress, cars
from tests.viewer.fleet import AREA, frame, known, node, shown
from tests.viewer.test_scene_geometry import rotated
from tests.viewer.test_scene_worlds import Stand, draw
from tests.viewer.test_solids import is_closed
from worlds.mission import Goal, Mission


def test_meshes_are_closed_and_fill_the_box_that_they_are_scaled_to():
    for mesh in (hull(), cabin(), wheel()):
        assert is_closed(mesh)
        vertices, _ = mesh
        assert {tuple(v) for v in np.round(vertices * [1.0, -1.0, 1.0], 9)} == {
            tuple(v) for v in np.round(vertices, 9)
        }
    vertices, _ = hull()
    assert (vertices[:, 0].min(), vertices[:, 0].max()) == (-0.5, 0.5)
    assert (vertices[:, 2].min() > 0.0, vertices[:, 2].max()) == (True, pytest.approx(1.0))
    assert cabin()[0][:, 2].max() < vertices[:, 2].max()
    assert pytest.approx(0.5) == TRACK + 0.5 * TREAD
    assert hubs().tolist() == [[x, side * TRACK] for x in AXLES for side in (-1.0, 1.0)]


@given(
    st.floats(-3.0, 3.0),
    st.floats(-0.8, 0.8),
    st.floats(-4.0, 4.0),
    st.floats(0.05, 3.0),
    st.floats(0.05, 3.0),
)
def test_front_wheels_are_turned_and_all_stand_where_the_car_takes_them(
    azimuth, steering, x, length, width
):
    at, size = np.array([[x, 1.0, 0.0]]), np.array([[length, width]])
    hub, wxyz = wheels(at, np.array([azimuth]), np.array([steering]), size)
    turn = np.array(
        [[math.cos(azimuth), -math.sin(azimuth)], [math.sin(azimuth), math.cos(azimuth)]]
    )
    for k, (ahead, left) in enumerate(hubs()):
        assert hub[k, :2] == pytest.approx(at[0, :2] + turn @ [ahead * length, left * width])
        assert hub[k, 2] == pytest.approx(0.5 * WHEEL * length)
        angle = azimuth + (steering if ahead > 0.0 else 0.0)
        rolls = rotated(wxyz[k], np.array([1.0, 0.0, 0.0]))
        assert rolls == pytest.approx([math.cos(angle), math.sin(angle), 0.0], abs=1e-6)


def test_cars_are_true_to_scale_and_never_too_small_to_see():
    one = shown(frame())
    assert one.length == pytest.approx(0.22 * 10.0 / 8.0)
    assert one.size.tolist() == [1.0, 1.0, 1.0]
    wide = replace(AREA, size=(60.0, 80.0))
    assert shown(frame(world=wide)).length == pytest.approx(LEAST_CAR * 10.0)
    leading = shown(frame(informed=np.array([True, False, False])))
    assert leading.size.tolist() == [1.0, 1.0, 1.0]


def test_a_flock_of_cars_is_drawn_as_cars_and_any_other_as_before():
    for one, seen in ((frame(), True), (frame(cars=None), False)):
        scene = Stand()
        draw(Agents(scene, "", FlockMotion()), shown(one))
        assert [node(scene, f"/cars/{part}").visible for part in ("hulls", "cabins", "wheels")] == [
            seen
        ] * 3
        assert node(scene, "/darts").visible is not seen
    scene = Stand()
    draw(Agents(scene, "", FlockMotion()), shown(frame(cars=known(steering=np.full(3, 0.4)))))
    hulls = node(scene, "/cars/hulls")
    assert hulls.batched_positions == pytest.approx(
        np.array([[-1.25, 0.625, 0.0], [0.0, 0.625, 0.0], [1.25, 0.625, 0.0]])
    )
    assert hulls.batched_scales[0, :2] == pytest.approx([0.22 * 1.25, 0.12 * 1.25])
    assert hulls.batched_colors.tolist() == palette.lit_bytes(shown(frame()).colour).tolist()
    assert len(node(scene, "/cars/wheels").batched_positions) == 12


def test_a_predator_has_its_own_colour_and_name():
    one = frame(cars=known(predator=np.array([False, True, False])))
    assert shown(one).colour[1] == pytest.approx(palette.LEADER)
    assert shown(one).colour[0] == pytest.approx(shown(frame()).colour[0])
    assert [name(shown(one), row) for row in range(3)] == ["1", "2 predator", "3"]
    assert ("predator", palette.css(palette.LEADER)) in legend(DrawingStyle(), one)
    assert "predator" not in dict(legend(DrawingStyle(), frame()))


def test_the_injected_car_stands_for_the_goal_of_cars():
    for one, car in ((frame(), True), (frame(cars=None), False)):
        scene = Stand()
        draw(MissionMarks(scene), shown(one))
        assert node(scene, "/goal/car/hulls").visible is car
        assert node(scene, "/goal/bead").visible is not car
        assert node(scene, "/goal/rim").visible is not car
    scene = Stand()
    draw(MissionMarks(scene), shown(frame(), DrawingStyle(mission=False)))
    assert not node(scene, "/goal/car/hulls").visible


def test_the_injected_car_looks_along_its_route_and_then_where_it_goes():
    scene = Stand()
    car = InjectedCar(scene, "/goal")

    def looks(tick: int, *at: float, run: int = 1) -> np.ndarray:
        one = shown(frame(tick, run=run, progress=MissionProgress(np.array(at))))
        for handle, prop, value in car.draw(one, np.array(at)):
            setattr(handle, prop, value)
        hulls = node(scene, "/car/hulls")
        assert hulls.batched_positions[0, :2] == pytest.approx(1.25 * np.array(at), abs=1e-6)
        return rotated(hulls.batched_wxyzs[0], np.array([1.0, 0.0, 0.0]))[:2]

    half = math.sqrt(0.5)
    assert looks(0, 1.0, 1.0) == pytest.approx([-half, half], abs=1e-6)
    assert looks(1, 1.0, 0.5) == pytest.approx([0.0, -1.0], abs=1e-6)
    assert looks(2, 1.0, 0.5) == pytest.approx([0.0, -1.0], abs=1e-6)
    assert looks(0, -1.0, -1.0, run=2) == pytest.approx([half, -half], abs=1e-6)
    still = replace(AREA, mission=Mission(goal=Goal(route=((1.0, 1.0),))))
    assert route_azimuth(shown(frame(world=still)), np.array([1.0, 1.0])) == 0.0


def test_the_fence_is_half_a_metre_inside_an_open_area_of_cars():
    low, high = fence(shown(frame()))
    assert (low.tolist(), high.tolist()) == ([-2.5, -3.5], [2.5, 3.5])
    assert INSIDE == 0.5
    assert fence(shown(frame(), DrawingStyle(fence=False))) is None
    assert fence(shown(frame(cars=None))) is None
    assert fence(shown(frame(world=replace(AREA, edges=("solid", "open"))))) is None
    assert fence(shown(frame(world=replace(AREA, size=(2.0, 8.0))))) is None
    scene = Stand()
    part = Fence(scene)
    draw(part, shown(frame()))
    lines = node(scene, "/fence")
    assert lines.visible
    assert np.abs(lines.points[..., 0]).max() == pytest.approx(2.5 * 1.25)
    assert np.abs(lines.points[..., 1]).max() == pytest.approx(3.5 * 1.25)
    draw(part, shown(frame(), DrawingStyle(fence=False)))
    assert not lines.visible


def test_a_start_region_that_is_the_fence_is_drawn_once():
    room = (np.array([-2.5, -3.5]), np.array([2.5, 3.5]))
    for look, other, seen in (
        (DrawingStyle(), 0.0, False),
        (DrawingStyle(), 0.2, True),
        (DrawingStyle(fence=False), 0.0, True),
    ):
        scene = Stand()
        draw(MissionMarks(scene), shown(frame(room=(room[0] + other, room[1])), look))
        assert node(scene, "/start").visible is seen


def test_what_is_stuck_has_a_ring():
    scene = Stand()
    marks = StuckMarks(scene)
    draw(marks, shown(frame(cars=known(stuck=np.array([False, False, True])))))
    lines = node(scene, "/stuck")
    away = lines.points[..., :2] - 1.25 * np.array([1.0, 0.5])
    assert np.linalg.norm(away, axis=-1) == pytest.approx(RADIUS * 0.22 * 1.25)
    draw(marks, shown(frame()))
    assert not lines.visible
    assert 0.5 * math.hypot(1.0, Vehicle().width / Vehicle().length) < RADIUS_CAR


@pytest.mark.parametrize("model", ["squashing", "squashing-cars"])
def test_a_camera_tells_what_the_bodies_know(model):
    flock = Flock(model, agents=3, rng=2, world="cars-circle")
    for ticks in (0, 30):
        flock.advance(ticks)
        taken = FrameBuilder(flock, run=1).build()
        assert (taken.cars.length, taken.cars.width) == (0.22, 0.12)
        assert np.isfinite(taken.cars.steering).all()
        assert not taken.cars.stuck.any()
        assert not taken.cars.predator.any()
        if ticks == 0:
            assert not taken.cars.steering.any()
    if model == "squashing-cars":
        assert taken.cars.steering.tolist() == flock.signal("steering").tolist()
        assert np.abs(taken.cars.steering).max() > 0.01
    else:
        assert not taken.cars.steering.any()


def test_other_flocks_are_no_cars():
    assert cars(Flock("vem-a", agents=5, rng=1)) is None
