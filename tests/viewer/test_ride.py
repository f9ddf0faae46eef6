"""Riding along: a camera on an agent, by itself and in the hands of a browser."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from agents.inspection import Inspection
from app.viewer.scene.cameras.camera import BEHIND, STEEPEST, CameraView, Ride, limited_direction
from app.viewer.scene.cameras.viewpoints import Sight, Viewpoints
from app.viewer.scene.draw.drawn_frame import Picture, picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown.drawing_style import RIDE, STEP_OFF, DrawingStyle
from app.viewer.scene.shown.frame import Frame
from worlds.world import World

HERE = np.zeros(3)
BEFORE = CameraView(np.array([9.0, 0.0, 5.0]), HERE, 0.8)
LONG = 1e3
"""Seconds after which nothing is left to catch up with."""


def frame(dim: int, position: np.ndarray, heading: np.ndarray, **changes) -> Frame:
    known = {
        "run": 1,
        "tick": 0,
        "world": World("wrap", (20.0,) * dim, ("wrap",) * dim),
        "reach": 5.0,
        "speed_scale": 3.0,
        "position": np.atleast_2d(position),
        "heading": np.atleast_2d(heading),
        "speed": np.ones(len(np.atleast_2d(position))),
        "informed": np.zeros(len(np.atleast_2d(position)), bool),
        "ids": np.arange(1, len(np.atleast_2d(position)) + 1),
    }
    return Frame(**(known | changes))


def shown(one: Frame) -> Picture:
    return picture(one, DrawingStyle(), Stage.of(one))


@pytest.mark.parametrize("dim", [2, 3])
def test_the_camera_is_behind_and_over_the_agent_and_looks_ahead(dim):
    ahead = np.eye(dim)[1]
    made = shown(frame(dim, np.full(dim, 10.0), ahead))
    ride = Ride(made, 0, HERE, 0, BEFORE)
    back = ride.view.position - made.at[0]
    assert back[1] == pytest.approx(-BEHIND[dim] * made.length)
    assert back[0] == pytest.approx(0.0, abs=1e-12)
    assert back[2] > 0.0
    looks = ride.view.target - ride.view.position
    assert looks[1] > 0.0 > looks[2]


def test_it_catches_up_with_place_and_heading():
    east, north = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    ride = Ride(shown(frame(3, [5.0, 5.0, 10.0], east)), 0, HERE, 0, BEFORE)
    there = shown(frame(3, [7.0, 6.0, 11.0], north))
    gaps = []
    for _ in range(30):
        assert ride.move(there, HERE, 1 / 40)
        gaps.append(np.linalg.norm(ride._place - there.at[0]))
    assert all(later < earlier for earlier, later in pairwise(gaps))
    ride.move(there, HERE, LONG)
    at_once = Ride(there, 0, HERE, 0, BEFORE)
    assert ride.view.position == pytest.approx(at_once.view.position)
    assert ride.view.target == pytest.approx(at_once.view.target)


def test_through_a_seam_the_camera_goes_with_its_agent():
    east = np.array([1.0, 0.0, 0.0])
    last = shown(frame(3, [19.9, 5.0, 10.0], east))
    ride = Ride(last, 0, HERE, 0, BEFORE)
    before = ride.view.position - last.at[0]
    after = shown(frame(3, [0.1, 5.0, 10.0], east))
    ride.move(after, HERE, 1e-9)
    moved = np.array([-0.2 * after.stage.scale, 0.0, 0.0])
    assert ride.view.position - after.at[0] == pytest.approx(before + moved, abs=1e-6)


def test_it_stays_upright_and_above_the_floor_when_the_agent_crashes():
    dive = np.array([0.0, 0.0, -1.0])
    made = shown(frame(3, [10.0, 10.0, 0.3], dive))
    ride = Ride(made, 0, HERE, 0, BEFORE)
    looks = ride.view.target - ride.view.position
    assert np.hypot(*looks[:2]) > 0.3 * np.linalg.norm(looks)
    down = replace(made.frame, position=np.array([[10.0, 10.0, 0.0]]), active=np.array([False]))
    ahead = ride._ahead
    assert ride.move(shown(down), HERE, LONG)
    assert np.array_equal(ride._ahead, ahead)
    assert ride.view.position[2] > made.stage.floor


def test_headings_are_straightened_to_the_steepest():
    assert limited_direction(np.array([0.0, 1.0])).tolist() == [0.0, 1.0, 0.0]
    steep = limited_direction(np.array([0.1, 0.0, 0.995]))
    assert np.arcsin(steep[2]) == pytest.approx(STEEPEST)
    assert np.linalg.norm(limited_direction(np.array([0.0, 0.0, 1.0]))) == pytest.approx(1.0)
    level = np.array([0.6, 0.0, -0.8]) * 0.5
    assert limited_direction(level) == pytest.approx([np.cos(STEEPEST), 0.0, -np.sin(STEEPEST)])
    assert limited_direction(np.array([0.8, 0.0, 0.6])) == pytest.approx([0.8, 0.0, 0.6])


def test_an_agent_that_is_gone_ends_the_ride():
    made = shown(frame(2, [[5.0, 5.0], [6.0, 6.0]], np.tile([1.0, 0.0], (2, 1))))
    ride = Ride(made, 1, HERE, 0, BEFORE)
    assert ride.move(shown(replace(made.frame, ids=np.array([2, 7]))), HERE, LONG)
    assert ride._seen == pytest.approx(made.at[0])
    assert not ride.move(shown(replace(made.frame, ids=np.array([1, 7]))), HERE, LONG)


class Browser:
    """Stands for one of viser's clients."""

    def __init__(self, number: int) -> None:
        self.client_id = number
        self.camera = SimpleNamespace(
            position=np.array([1.0, 2.0, 3.0]),
            look_at=np.array([0.5, 0.0, 0.0]),
            fov=0.6,
            image_width=800,
            image_height=600,
        )
        self.tell()

    def tell(self, by: float = 0.0) -> None:
        """Say where its camera is, which a person has moved so far: viser makes its state anew."""
        self.camera.position = self.camera.position + by
        self.camera._state = object()

    def atomic(self):
        return self

    def __enter__(self) -> None: ...

    def __exit__(self, *_: object) -> None: ...


class Server:
    """Stands for viser's server."""

    def __init__(self, browsers: list[Browser]) -> None:
        self.browsers = {one.client_id: one for one in browsers}
        self.initial_camera = SimpleNamespace()

    def on_client_connect(self, _callback) -> None: ...

    def on_client_disconnect(self, _callback) -> None: ...

    def get_clients(self) -> dict[int, Browser]:
        return self.browsers


@pytest.fixture
def two():
    browsers = [Browser(1), Browser(2)]
    seen = Inspection(2, 1, np.empty(0, int), np.empty((0, 3)), np.empty(0), {})
    ahead = np.tile([1.0, 0.0, 0.0], (2, 1))
    one = frame(3, [[5.0, 5.0, 5.0], [9.0, 9.0, 9.0]], ahead, inspected=seen)
    viewpoints = Viewpoints(Server(browsers))
    viewpoints.update((Sight(shown(one), HERE),))
    return browsers, viewpoints, one


def pose(browser: Browser) -> list[float]:
    return [*browser.camera.position, *browser.camera.look_at, browser.camera.fov]


def test_only_the_rider_moves_and_comes_back_to_where_it_was(two):
    (rider, other), viewpoints, one = two
    start, elsewhere = pose(rider), pose(other)
    viewpoints.place(rider, RIDE)
    on = pose(rider)
    assert on != start
    at = shown(one).at[1]
    assert np.linalg.norm(rider.camera.position - at) < 3.0
    later = replace(one, tick=1, position=one.position + 1.0)
    viewpoints.update((Sight(shown(later), HERE),))
    assert pose(rider) != on
    assert pose(other) == elsewhere
    viewpoints.place(rider, RIDE)
    assert pose(rider) == pytest.approx(start)
    viewpoints.update((Sight(shown(replace(one, tick=2)), HERE),))
    assert pose(rider) == pytest.approx(start)


def test_escape_ends_a_ride_and_nothing_else(two):
    (rider, _), viewpoints, one = two
    start = pose(rider)
    viewpoints.place(rider, STEP_OFF)
    assert pose(rider) == start
    viewpoints.place(rider, RIDE)
    viewpoints.place(rider, STEP_OFF)
    assert pose(rider) == pytest.approx(start)
    viewpoints.place(rider, "follow")
    close = pose(rider)
    viewpoints.place(rider, STEP_OFF)
    for tick in range(1, 40):
        moved = replace(one, tick=tick, position=one.position + 0.1 * tick)
        viewpoints.update((Sight(shown(moved), HERE),))
        viewpoints._last -= 0.1
    assert pose(rider) != close


def test_what_rises_is_seen_from_aside_by_who_has_not_moved_the_camera():
    browsers = [Browser(1), Browser(2)]
    viewpoints = Viewpoints(Server(browsers))
    still, moved = browsers

    def show(trails: str) -> None:
        made = picture(plane, DrawingStyle(trails=trails), Stage.of(plane))
        viewpoints.update((Sight(made, HERE),))

    plane = frame(2, [[5.0, 5.0], [9.0, 9.0]], [[1.0, 0.0], [1.0, 0.0]])
    show("off")
    above = pose(still)
    assert above == pose(moved)
    viewpoints._stands[2].arrived = True
    moved.tell(1.0)
    elsewhere = pose(moved)
    show("rising in time")
    x, y, z = still.camera.position - still.camera.look_at
    assert np.hypot(x, y) > 0.5 * z > 0.0
    assert pose(moved) == elsewhere
    show("ribbon")
    assert pose(still) == pytest.approx(above)
    viewpoints.place(still, "side")
    show("rising in time")
    higher = pose(still)
    show("off")
    assert pose(still) != higher
    assert np.hypot(*(still.camera.position - still.camera.look_at)[:2]) > still.camera.position[2]


def test_a_browser_that_was_slow_to_begin_is_shown_the_whole_and_a_person_has_the_last_word(two):
    (slow, _), viewpoints, _ = two
    whole = pose(slow)
    viewpoints._stands[1].since -= 60.0
    start = viewpoints._server.initial_camera
    slow.camera.position, slow.camera.look_at = start.position.copy(), start.look_at.copy()
    slow.tell()
    viewpoints._fit(slow, slow.camera)
    assert pose(slow) == pytest.approx(whole)
    slow.tell()
    viewpoints._fit(slow, slow.camera)
    slow.tell(1.0)
    moved = pose(slow)
    viewpoints._fit(slow, slow.camera)
    assert pose(slow) == moved
    assert 1 not in viewpoints._stands


def test_what_a_browser_was_told_of_its_camera_is_not_what_it_says_of_it(two):
    (phone, _), viewpoints, _ = two
    viewpoints._fit(phone, phone.camera)  # as viser calls it once the browser is welcome
    phone.camera.position, phone.camera.look_at = np.array([3.0, 3.0, 3.0]), np.zeros(3)
    phone.tell()
    viewpoints._fit(phone, phone.camera)  # where it was before it was put anywhere
    assert 1 in viewpoints._stands
    phone.camera.image_width, phone.camera.image_height = 390, 678
    viewpoints.place(phone, "perspective")
    phone.tell()
    viewpoints._fit(phone, phone.camera)
    tall = pose(phone)
    phone.camera.image_height = 288
    phone.tell()
    viewpoints._fit(phone, phone.camera)
    assert pose(phone) != tall


def test_a_flock_that_flies_out_of_an_open_world_stays_in_view_of_who_has_not_moved_the_camera():
    browsers = [Browser(1), Browser(2)]
    viewpoints = Viewpoints(Server(browsers))
    still, moved = browsers

    def show(out: float, run: int = 1) -> None:
        at = np.array([[5.0, 5.0], [9.0 + out, 9.0]])
        world = World("open", (20.0, 20.0), ("open", "open"))
        one = frame(2, at, np.tile([1.0, 0.0], (2, 1)), world=world, run=run)
        viewpoints._looks = 0.0
        viewpoints.update((Sight(shown(one), HERE),))

    show(0.0)
    near = pose(still)
    viewpoints._stands[2].arrived = True
    moved.tell(1.0)
    elsewhere = pose(moved)
    show(5.0)
    assert pose(still) == near, "it is inside yet"
    show(60.0)
    far = pose(still)
    assert far[2] > 2.0 * near[2]
    assert far[3] > near[3]
    show(64.0)
    assert pose(still) == far, "it has room for a while"
    for out in (150.0, 400.0, 1e4):
        show(out)
    assert pose(still)[2] < 20.0 * near[2], "what is too small to be seen is let go"
    show(64.0)
    show(0.0)
    assert pose(still)[2] >= far[2], "nothing shrinks by itself"
    show(0.0, run=2)
    assert pose(still) == pytest.approx(near)
    assert pose(moved) == elsewhere


def test_a_preset_ends_a_ride(two):
    (rider, _), viewpoints, one = two
    viewpoints.place(rider, RIDE)
    viewpoints.place(rider, "top-down")
    above = pose(rider)
    viewpoints.update((Sight(shown(replace(one, tick=1, position=one.position + 1.0)), HERE),))
    assert pose(rider) == above


def test_a_ride_goes_on_after_a_crash_and_ends_with_the_agent(two):
    (rider, _), viewpoints, one = two
    start = pose(rider)
    viewpoints.place(rider, RIDE)
    fell = one.position - np.array([0.0, 0.0, 5.0])
    down = replace(one, tick=1, position=fell, active=np.array([True, False]))
    viewpoints._last -= LONG
    viewpoints.update((Sight(shown(down), HERE),))
    assert np.linalg.norm(rider.camera.position - shown(down).at[1]) < 3.0
    gone = frame(3, [5.0, 5.0, 5.0], [1.0, 0.0, 0.0], tick=2)
    viewpoints.update((Sight(shown(gone), HERE),))
    assert pose(rider) == pytest.approx(start)
