"""Cars on the display: their meshes, sizes, wheels and marks, the injected car, fence and bands."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from agents import Flock
from app.viewer.cars import LENGTH, WIDTH, Cars, cars
from app.viewer.frame import Errand, Frame
from app.viewer.picture import Camera
from app.viewer.scene import TRAILS, Look, palette, tone
from app.viewer.scene.agents import Agents
from app.viewer.scene.car import AXLES, TRACK, TREAD, WHEEL, cabin, hubs, hull, wheel
from app.viewer.scene.colouring import legend
from app.viewer.scene.crashes import RADIUS_CAR
from app.viewer.scene.fence import INSIDE, Fence, fence
from app.viewer.scene.fleet import wheels
from app.viewer.scene.flight import Flight
from app.viewer.scene.injected import InjectedCar, along_route
from app.viewer.scene.labels import name
from app.viewer.scene.mission import MissionMarks
from app.viewer.scene.past import Past
from app.viewer.scene.picture import LEAST_CAR, Picture, picture
from app.viewer.scene.ribbons import INJECTED, LAID, RISE, Ribbons, heights, walkers
from app.viewer.scene.stage import Stage
from app.viewer.scene.stuck import RADIUS, StuckMarks
from tests.viewer.test_scene_geometry import rotated
from tests.viewer.test_scene_worlds import Stand, draw
from tests.viewer.test_solids import is_closed
from worlds.mission import Goal, Mission
from worlds.world import World

ROUTE = ((2.0, 0.0), (0.0, 2.0), (-2.0, 0.0), (0.0, -2.0))
AREA = World("area", (6.0, 8.0), ("open", "open"), low=(-3.0, -4.0))
ROUND = replace(AREA, mission=Mission(goal=Goal(route=ROUTE, speed=1.0, closed=True)))


def known(count: int = 3, **changes: Any) -> Cars:
    none = np.zeros(count, bool)
    return replace(Cars(0.22, 0.12, np.zeros(count), none, none), **changes)


def frame(tick: int = 0, **changes: Any) -> Frame:
    """Three cars in a row that look along +x, +y and -x."""
    made = Frame(
        run=1,
        tick=tick,
        world=ROUND,
        reach=20.0,
        speed_scale=1.0,
        position=np.array([[-1.0, 0.5], [0.0, 0.5], [1.0, 0.5]]),
        heading=np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0]]),
        speed=np.ones(3),
        informed=np.zeros(3, bool),
        ids=np.arange(1, 4),
        dt=0.01,
        unit="s",
        errand=Errand(np.array([2.0, 0.0])),
        cars=known(),
    )
    return replace(made, **changes)


def shown(one: Frame, look: Look | None = None) -> Picture:
    return picture(one, look or Look(), Stage.of(one))


def node(scene: Stand, end: str) -> Any:
    (found,) = [each for each in scene.sent if each.name.endswith(end)]
    return found


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
        draw(Agents(scene, "", Flight()), shown(one))
        assert [node(scene, f"/cars/{part}").visible for part in ("hulls", "cabins", "wheels")] == [
            seen
        ] * 3
        assert node(scene, "/darts").visible is not seen
    scene = Stand()
    draw(Agents(scene, "", Flight()), shown(frame(cars=known(steering=np.full(3, 0.4)))))
    hulls = node(scene, "/cars/hulls")
    assert hulls.batched_positions == pytest.approx(
        np.array([[-1.25, 0.625, 0.0], [0.0, 0.625, 0.0], [1.25, 0.625, 0.0]])
    )
    assert hulls.batched_scales[0, :2] == pytest.approx([0.22 * 1.25, 0.12 * 1.25])
    assert hulls.batched_colors.tolist() == tone.lit(shown(frame()).colour).tolist()
    assert len(node(scene, "/cars/wheels").batched_positions) == 12


def test_a_predator_has_its_own_colour_and_name():
    one = frame(cars=known(predator=np.array([False, True, False])))
    assert shown(one).colour[1] == pytest.approx(palette.LEADER)
    assert shown(one).colour[0] == pytest.approx(shown(frame()).colour[0])
    assert [name(shown(one), row) for row in range(3)] == ["1", "2 predator", "3"]
    assert ("predator", palette.css(palette.LEADER)) in legend(Look(), one)
    assert "predator" not in dict(legend(Look(), frame()))


def test_the_injected_car_stands_for_the_goal_of_cars():
    for one, car in ((frame(), True), (frame(cars=None), False)):
        scene = Stand()
        draw(MissionMarks(scene), shown(one))
        assert node(scene, "/goal/car/hulls").visible is car
        assert node(scene, "/goal/bead").visible is not car
        assert node(scene, "/goal/rim").visible is not car
    scene = Stand()
    draw(MissionMarks(scene), shown(frame(), Look(mission=False)))
    assert not node(scene, "/goal/car/hulls").visible


def test_the_injected_car_looks_along_its_route_and_then_where_it_goes():
    scene = Stand()
    car = InjectedCar(scene, "/goal")

    def looks(tick: int, *at: float, run: int = 1) -> np.ndarray:
        one = shown(frame(tick, run=run, errand=Errand(np.array(at))))
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
    assert along_route(shown(frame(world=still)), np.array([1.0, 1.0])) == 0.0


def test_the_fence_is_half_a_metre_inside_an_open_area_of_cars():
    low, high = fence(shown(frame()))
    assert (low.tolist(), high.tolist()) == ([-2.5, -3.5], [2.5, 3.5])
    assert INSIDE == 0.5
    assert fence(shown(frame(), Look(fence=False))) is None
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
    draw(part, shown(frame(), Look(fence=False)))
    assert not lines.visible


def test_a_start_region_that_is_the_fence_is_drawn_once():
    room = (np.array([-2.5, -3.5]), np.array([2.5, 3.5]))
    for look, other, seen in (
        (Look(), 0.0, False),
        (Look(), 0.2, True),
        (Look(fence=False), 0.0, True),
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
    assert 0.5 * math.hypot(1.0, WIDTH / LENGTH) < RADIUS_CAR


def band(trails: str, ticks: range, length: int = 40, **changes: Any) -> tuple[Any, Any, Picture]:
    """What is drawn behind a car along +x, 0.01 a tick, after these ticks."""
    scene = Stand()
    part = Ribbons(scene)
    for tick in ticks:
        one = frame(
            tick,
            **{
                "position": np.array([[-2.0 + 0.01 * tick, 0.0]]),
                "heading": np.array([[1.0, 0.0]]),
                "speed": np.ones(1),
                "informed": np.zeros(1, bool),
                "ids": np.array([1]),
                "cars": known(1),
                "errand": Errand(),
                "world": AREA,
            }
            | changes,
        )
        last = shown(one, Look(trails=trails, trail_length=length))
        draw(part, last)
    return node(scene, "/pieces"), node(scene, "/plumb"), last


def test_a_flat_ribbon_lies_where_the_car_has_been():
    pieces, plumb, last = band("ribbon", range(101))
    assert pieces.visible
    assert not plumb.visible
    at = pieces.batched_positions
    assert at[:, 2] == pytest.approx(LAID)
    assert at[:, 0].min() >= 1.25 * (-2.0 + 0.01 * 60) - 1e-5
    assert at[:, 0].max() <= 1.25 * (-2.0 + 0.01 * 100) + 1e-5
    assert np.sum(np.diff(np.sort(at[:, 0]))) == pytest.approx(1.25 * 0.39, rel=0.02)
    assert np.all(pieces.batched_scales[:, 1] < last.length * WIDTH / LENGTH)


def test_a_band_that_rises_does_so_with_time_up_to_the_present_above_the_car():
    for ticks, height in ((range(21), 0.5), (range(101), 1.0)):
        pieces, plumb, last = band("rising in time", ticks)
        order = np.argsort(pieces.batched_positions[:, 0])
        along, up = pieces.batched_positions[order][:, [0, 2]].T
        assert np.all(np.diff(up) > 0.0)
        slope = np.diff(up) / np.diff(along)
        assert slope == pytest.approx(RISE * 10.0 / 40 / (0.01 * 1.25), rel=1e-3)
        ((top, foot),) = plumb.points
        assert top == pytest.approx([*last.at[0, :2], height * RISE * 10.0 + LAID], rel=1e-5)
        assert foot == pytest.approx([*last.at[0, :2], 0.0])


def test_bands_break_at_the_seam_and_are_forgotten():
    seam = World("wrap", (6.0, 8.0), ("wrap", "wrap"))
    scene = Stand()
    part = Ribbons(scene)
    for tick, x in enumerate([5.7, 5.8, 5.9, 0.0, 0.1]):
        place = np.array([[x, 0.0]] * 3)
        one = frame(tick, world=seam, position=place, errand=Errand(), cars=None)
        draw(part, shown(one, Look(trails="ribbon", trail_length=16)))
    pieces = node(scene, "/pieces")
    assert len(pieces.batched_positions) == 3 * 3
    draw(part, shown(one, Look(trails="line", trail_length=16)))
    assert not pieces.visible
    draw(part, shown(replace(one, tick=9), Look(trails="ribbon", trail_length=16)))
    assert not pieces.visible


def test_the_injected_car_leaves_a_band_too():
    ids, here, colour = walkers(shown(frame()))
    assert ids.tolist() == [1, 2, 3, INJECTED]
    assert here[-1] == pytest.approx([2.5, 0.0, 0.0])
    assert colour[-1] == pytest.approx(palette.GOAL)
    assert len(walkers(shown(frame(), Look(mission=False)))[0]) == 3
    assert len(walkers(shown(frame(cars=None)))[0]) == 3


@given(st.integers(0, 500), st.integers(0, 500), st.integers(1, 300))
def test_heights_go_from_the_oldest_shown_to_the_present(began, lasted, length):
    now = began + lasted
    first = max(began, now - length)
    up = heights(np.arange(first, now + 1), began, now, length)
    assert up[0] == 0.0
    assert up[-1] == pytest.approx(min(lasted, length) / length)
    assert np.all(np.diff(up) > 0.0)


def test_the_past_keeps_no_more_than_it_is_asked_for():
    past = Past()
    for tick in range(100):
        here = np.array([[float(tick), 0.0, 0.0]])
        changed = past.remember(frame(tick), np.array([7]), here, length=40, knots=10)
        assert changed is (tick % 4 == 0)
    assert past.ticks == list(range(56, 97, 4))
    assert [knot[0, 0] for knot in past.knots] == past.ticks
    assert past.began == 0


def test_a_look_refuses_a_trail_that_nobody_knows():
    with pytest.raises(ValueError, match="trails = 'smoke' is not one of off, line, ribbon"):
        Look(trails="smoke")
    assert [Look(trails=one).trails for one in TRAILS] == list(TRAILS)


@pytest.mark.parametrize("model", ["squashing", "squashing-cars"])
def test_a_camera_tells_what_the_bodies_know(model):
    flock = Flock(model, agents=3, rng=2, world="cars-circle")
    for ticks in (0, 30):
        flock.advance(ticks)
        taken = Camera(flock, run=1).take()
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
