"""What is between a camera and the agent that it follows: found, kept a while, drawn as glass."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.viewer.scene.cameras.viewpoints import Sight, Viewpoints
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks import see_through
from app.viewer.scene.marks.obstacle_marks import Obstacles, drawn_height
from app.viewer.scene.marks.see_through import (
    EVERY,
    GLASSY,
    LASTS,
    FollowedAgent,
    SeeThrough,
    Solids,
    ViewBlockers,
)
from app.viewer.scene.shown.drawing_style import RIDE
from tests.viewer.sky import Clock
from tests.viewer.test_ride import Browser, Server
from tests.viewer.test_scene_worlds import Stand, draw, shown
from worlds.obstacles import Box, Disc, Sphere
from worlds.world import World

HALL = World(
    "hall",
    (8.0, 6.0, 4.0),
    ("solid",) * 3,
    obstacles=(
        Sphere(centre=(2.0, 2.0, 2.0), radius=1.0),
        Box(low=(4.0, 1.0, 1.0), high=(5.0, 3.0, 2.0)),
        Disc(centre=(6.5, 4.0), radius=0.5),
    ),
)
LOG = Box(low=(4.0, 1.0), high=(4.5, 5.0))
YARD = World("yard", (8.0, 6.0), ("solid", "solid"), obstacles=(LOG,), height=3.0)
WIDE = 0.1
AT, BEHIND_BOX, BEHIND_BALL = np.array([[3.2, 2.0, 1.5], [7.5, 2.0, 1.5], [0.2, 2.0, 1.8]])


def solids(world: World) -> Solids:
    return Solids(world, Stage.of(shown(world).frame))


def inside(k: int, place: np.ndarray) -> bool:
    """Whether a place is in an obstacle of the hall: written apart."""
    x, y, z = place
    if k == 0:
        return (x - 2.0) ** 2 + (y - 2.0) ** 2 + (z - 2.0) ** 2 < 1.0
    if k == 1:
        return 4.0 < x < 5.0 and 1.0 < y < 3.0 and 1.0 < z < 2.0
    return (x - 6.5) ** 2 + (y - 4.0) ** 2 < 0.49**2 and 0.0 < z < 4.0


coordinates = st.tuples(*(st.floats(-1.0, side + 1.0) for side in HALL.size))


@given(coordinates, coordinates)
def test_what_a_line_of_sight_goes_through_is_in_the_way_and_what_is_far_from_it_is_not(eye, at):
    eye, at = np.array(eye), np.array(at)
    found = solids(HALL).blocking(eye, at, WIDE)
    length = float(np.linalg.norm(at - eye))
    assert length > WIDE or not found
    reach = max(0.0, 1.0 - WIDE / length) if length else 0.0
    along = eye + reach * np.linspace(0.0, 1.0, 400)[:, None] * (at - eye)
    for k in range(3):
        if any(inside(k, place) for place in along) and length > WIDE:
            assert k in found
    grown = ((1.0, 1.0, 1.0), (3.0, 3.0, 3.0)), ((4, 1, 1), (5, 3, 2)), ((6, 3.5, 0), (7, 4.5, 4))
    for k, (low, high) in enumerate(grown):
        near = np.all((along > np.array(low) - 0.2) & (along < np.array(high) + 0.2), axis=1)
        if not near.any():
            assert k not in found


def test_what_is_behind_an_agent_is_not_in_the_way():
    hall = solids(HALL)
    assert hall.blocking(BEHIND_BOX, AT, WIDE) == {1}
    assert hall.blocking(BEHIND_BALL, AT, WIDE) == {0}
    close = np.array([3.95, 2.0, 1.5])
    assert hall.blocking(BEHIND_BALL, close, WIDE) == {0}
    assert hall.blocking(close, close, WIDE) == set()


def test_in_the_plane_nothing_hides_anything_from_above():
    yard, height = solids(YARD), drawn_height(YARD)
    assert height < YARD.height
    agent = np.array([4.9, 3.0, 0.02])
    seen = ((0.0, 30.0, 0), (-2.0, 0.5 * height, 1), (-2.0, 4.0, 0), (2.0, 0.1, 0))
    for along, up, hidden in seen:
        eye = agent + np.array([along, 0.0, up])
        assert len(yard.blocking(eye, agent, WIDE)) == hidden


def test_what_was_in_the_way_stays_so_for_a_while():
    hall, one = solids(HALL), ViewBlockers()
    look = lambda eye, now: one.find_blockers(hall, np.array(eye), AT, WIDE, now)  # noqa: E731
    assert look(BEHIND_BOX, 10.0) == {1}
    aside = np.array([7.5, 2.0, 12.0])
    assert look(aside, 10.0 + 0.9 * LASTS) == {1}
    assert look(aside, 10.0 + 1.1 * LASTS) == set()
    # Twice as far as comes in, and not yet as far as goes out: no flicker between the two.
    edge = [7.5, 3.0 + 1.25 * WIDE, 1.5]
    agent = np.array([3.2, 3.0 + 1.25 * WIDE, 1.5])
    fresh = ViewBlockers()
    assert fresh.find_blockers(hall, np.array(edge), agent, WIDE, 0.0) == set()
    fresh.find_blockers(hall, BEHIND_BOX, AT, WIDE, 1.0)
    for now in np.arange(1.2, 5.0, 0.2):
        assert fresh.find_blockers(hall, np.array(edge), agent, WIDE, now) == {1}


class Client:
    """Stands for a browser with a scene of its own."""

    def __init__(self, number: int) -> None:
        self.client_id, self.scene = number, Stand()

    def atomic(self) -> Any:
        return nullcontext()

    def there(self) -> dict[str, Any]:
        return {node.name: node for node in self.scene.sent if node.there}


@pytest.fixture
def clock(monkeypatch):
    made = Clock()
    monkeypatch.setattr(see_through, "time", SimpleNamespace(monotonic=made))
    return made


def watched(client: Client, eye: np.ndarray, world: World = HALL, root: str = "") -> FollowedAgent:
    at = np.array([AT, [6.5, 1.0, 1.0], [7.0, 1.0, 1.0]])
    made = shown(world, position=at, informed=np.zeros(3, bool))
    return FollowedAgent(client, made, 0, made.stage.place_on_display(eye), root)  # type: ignore[arg-type]


def test_only_the_browser_that_follows_sees_through_and_only_what_is_in_its_way(clock):
    scene, one, other = SeeThrough(), Client(1), Client(2)
    aside = np.array([3.2, 5.5, 3.5])
    scene.look(lambda: [watched(one, BEHIND_BOX), watched(other, aside)])
    assert other.scene.sent == []
    there = one.there()
    glass = there["/world/obstacles/glass/solid"]
    assert glass.opacity == GLASSY
    assert there["/world/obstacles/others/solid"].opacity is None
    assert "/world/obstacles/others/spheres" in there
    assert "/world/obstacles/glass/spheres" not in there
    shared = Stand()
    draw(Obstacles(shared), shown(HALL))
    for name in shared.names():
        assert there[name].visible is False
    sent = len(one.scene.sent)
    clock.now += EVERY
    scene.look(lambda: [watched(one, BEHIND_BOX)])
    assert len(one.scene.sent) == sent
    clock.now += EVERY
    scene.look(list)
    assert one.there() == {}


def test_it_looks_a_few_times_a_second_and_a_change_of_the_world_is_drawn(clock):
    scene, one, asked = SeeThrough(), Client(1), []

    def view() -> list[FollowedAgent]:
        asked.append(clock.now)
        return [watched(one, BEHIND_BOX, world)]

    world = HALL
    for _ in range(100):
        scene.look(view)
        clock.now += 0.01
    assert len(asked) == pytest.approx(1.0 / EVERY, abs=1)
    world = replace(HALL, obstacles=HALL.obstacles[:1])
    clock.now += EVERY
    scene.look(view)
    assert one.there() == {}
    world = replace(HALL, obstacles=HALL.obstacles[1:])
    clock.now += EVERY
    scene.look(view)
    assert "/world/obstacles/glass/solid" in one.there()


def test_in_the_second_room_it_is_that_ones_obstacles(clock):
    scene, one = SeeThrough(), Client(1)
    scene.look(lambda: [watched(one, BEHIND_BOX, root="/beside")])
    assert all(name.startswith("/beside/world/obstacles/") for name in one.there())
    clock.now += EVERY
    scene.look(lambda: [watched(one, BEHIND_BOX)])
    assert one.there()
    assert not [name for name in one.there() if name.startswith("/beside")]


def test_who_follows_and_who_rides_is_known():
    browsers = [Browser(1), Browser(2), Browser(3)]
    viewpoints = Viewpoints(Server(browsers))  # type: ignore[arg-type]
    made = shown(HALL, ids=np.array([7, 8, 9]))
    viewpoints.update((Sight(made, np.zeros(3)),))
    assert viewpoints.followed() == []
    viewpoints.follow(browsers[1], 2)  # type: ignore[arg-type]
    viewpoints.place(browsers[2], RIDE)  # type: ignore[arg-type]
    viewpoints.update((Sight(shown(HALL, ids=np.array([9, 8, 7])), np.zeros(3)),))
    assert viewpoints.followed() == [(browsers[1], 0, 0), (browsers[2], 0, 2)]
