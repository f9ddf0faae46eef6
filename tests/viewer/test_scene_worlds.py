"""Worlds and missions in the scene: what is drawn, where, and that it is sent once."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from agents.inspection import Inspection
from app.viewer.scene.cameras.viewpoints import extent
from app.viewer.scene.draw.drawn_frame import Picture, picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks.inspection_marks import ReasonMarks, arrows, remembered_places
from app.viewer.scene.marks.mission_marks import MissionMarks
from app.viewer.scene.marks.obstacle_marks import (
    BoundaryPointMarks,
    Obstacles,
    drawn_height,
    find_changed,
)
from app.viewer.scene.marks.world_box import Walls, edges_by_kind
from app.viewer.scene.shown.drawing_style import DrawingStyle
from app.viewer.scene.shown.frame import Frame, MissionProgress
from tests.viewer.test_solids import is_closed, volume
from worlds.mission import Goal, Mission, Path, StartRegion
from worlds.obstacles import Box, Disc, Ring, Sphere
from worlds.world import World

DISCS = tuple(Disc(centre=(float(x), 5.0), radius=1.0) for x in (0, 4, 8))
YARD = World(
    "yard",
    (20.0, 10.0),
    ("solid", "open"),
    low=(-4.0, 2.0),
    obstacles=(*DISCS, Ring(centre=(12.0, 8.0), radius=2.0, width=0.5)),
    height=1.0,
    mission=Mission(
        start=StartRegion(low=(-3.0, 3.0), high=(-1.0, 5.0)),
        path=Path(waypoints=((1.0, 3.0), (6.0, 3.0), (14.0, 3.0)), switch=0.5),
        goal=Goal(route=((14.0, 10.0),)),
    ),
)
HALL = World(
    "hall",
    (8.0, 6.0, 4.0),
    ("solid", "solid", "solid"),
    obstacles=(
        Sphere(centre=(2.0, 2.0, 2.0), radius=1.0),
        Box(low=(4.0, 1.0, 1.0), high=(5.0, 3.0, 2.0)),
    ),
)


class Node:
    """Stands for a handle of viser."""

    def __init__(self, name: str, given: tuple, named: dict[str, Any]) -> None:
        self.name, self.given, self.there = name, given, True
        for key, value in named.items():
            setattr(self, key, value)

    def remove(self) -> None:
        self.there = False


class Stand:
    """Stands for viser's scene: remembers every node that was sent."""

    def __init__(self) -> None:
        self.sent: list[Node] = []

    def __getattr__(self, _kind: str):
        def add(name: str, *given: Any, **named: Any) -> Node:
            node = Node(name, given, named)
            self.sent.append(node)
            return node

        return add

    def there(self, name: str) -> Node:
        (node,) = [node for node in self.sent if node.name == name and node.there]
        return node

    def names(self) -> Counter:
        return Counter(node.name for node in self.sent)


def shown(world: World, look: DrawingStyle | None = None, **changes: Any) -> Picture:
    """A picture of three agents in a world."""
    heading = np.zeros((3, world.dim))
    heading[:, 0] = 1.0
    frame = Frame(
        run=1,
        tick=0,
        world=world,
        reach=1.0,
        speed_scale=1.0,
        position=np.array(world.low) + 0.5 * np.array(world.size) + 0.1 * np.eye(3)[:, : world.dim],
        heading=heading,
        speed=np.ones(3),
        informed=np.array([True, False, False]),
        ids=np.arange(3),
    )
    frame = replace(frame, **changes)
    return picture(frame, look or DrawingStyle(), Stage.of(frame))


def draw(part: Any, shown: Picture) -> None:
    for handle, name, value in part.draw(shown):
        setattr(handle, name, value)


def test_a_stage_starts_at_the_lower_corner_of_the_world():
    stage = shown(YARD).stage
    assert stage.to_display(np.array([-4.0, 2.0])) == pytest.approx([-5.0, -2.5, 0.0])
    assert stage.to_display(np.array([16.0, 12.0])) == pytest.approx([5.0, 2.5, 0.0])
    assert stage.world(np.array([-5.0, -2.5, 0.0])) == pytest.approx([-4.0, 2.0])
    assert stage.place_on_display(np.array([6.0, 7.0, 1.0])) == pytest.approx([0.0, 0.0, 0.5])


def test_obstacles_of_a_flat_world_stand_on_its_floor_as_one_solid():
    scene = Stand()
    Obstacles(scene, "/left").draw(shown(YARD))
    mesh = scene.there("/left/world/obstacles/rest/solid").given
    area = sum(float(one.footprint().area) for one in YARD.obstacles)
    assert is_closed(mesh)
    assert volume(mesh) == pytest.approx(area * 1.0 * 0.5**3, rel=1e-5)
    assert np.unique(mesh[0][:, 2]).tolist() == [0.0, 0.5]


def test_what_is_tall_is_drawn_lower_in_a_flat_world():
    assert drawn_height(replace(YARD, height=9.0)) == 1.0


def test_overlapping_obstacles_have_no_walls_within():
    scene = Stand()
    Obstacles(scene).draw(shown(replace(YARD, obstacles=(DISCS[0], DISCS[0].moved(1.0, 0.0)))))
    mesh = scene.there("/world/obstacles/rest/solid").given
    union = DISCS[0].footprint().union(DISCS[0].moved(1.0, 0.0).footprint())
    assert volume(mesh) == pytest.approx(union.area * 0.5**3, rel=1e-5)


def test_solids_in_space_keep_their_heights_and_spheres_are_round():
    scene = Stand()
    Obstacles(scene).draw(shown(HALL))
    vertices, faces = scene.there("/world/obstacles/rest/solid").given
    assert volume((vertices, faces)) == pytest.approx(1.0 * 2.0 * 1.0, rel=1e-5)
    assert np.unique(vertices[:, 2]) == pytest.approx([-1.0, 0.0])
    balls = scene.there("/world/obstacles/rest/spheres")
    assert balls.batched_positions[0] == pytest.approx([-2.0, -1.0, 0.0])
    assert balls.batched_scales[0] == pytest.approx(1.0)


def test_what_does_not_change_is_sent_once():
    scene = Stand()
    parts = [kind(scene) for kind in (Obstacles, Walls, MissionMarks)]
    world = replace(YARD)
    for tick in range(5):
        for part in parts:
            draw(part, shown(world, tick=tick, room=(np.array([-3.0, 3.0]), np.array([-1.0, 5.0]))))
        if tick == 0:
            first = scene.names()
    assert scene.names() == first
    assert set(first.values()) == {1}


def test_only_the_obstacle_that_is_moved_is_sent_again():
    scene = Stand()
    part = Obstacles(scene)
    world = YARD
    part.draw(shown(world))
    for step in range(4):
        moved = (*world.obstacles[:1], world.obstacles[1].moved(0.1, 0.0), *world.obstacles[2:])
        world = replace(world, obstacles=moved)
        part.draw(shown(world))
        assert scene.names()["/world/obstacles/one/solid"] == step + 1
        assert scene.names()["/world/obstacles/rest/solid"] == 2
    rest = scene.there("/world/obstacles/rest/solid").given
    one = scene.there("/world/obstacles/one/solid").given
    area = sum(float(each.footprint().area) for each in world.obstacles)
    assert volume(rest) + volume(one) == pytest.approx(area * 0.5**3, rel=1e-5)


def test_obstacles_come_and_go():
    scene = Stand()
    part = Obstacles(scene)
    part.draw(shown(replace(YARD, obstacles=())))
    assert not scene.sent
    part.draw(shown(replace(YARD, obstacles=DISCS[:1])))
    assert scene.there("/world/obstacles/one/solid")
    part.draw(shown(replace(YARD, obstacles=())))
    assert not any(node.there for node in scene.sent)


def test_the_one_that_changed_is_found():
    assert find_changed("abc", "abc") is None
    assert find_changed("abc", "abz") == 2
    assert find_changed("abc", "xbz") is None
    assert find_changed("abc", "xbcd") is None
    assert find_changed("", "a") == 0


def test_a_rim_stands_along_solid_edges_and_panes_in_space():
    scene = Stand()
    Walls(scene).draw(shown(YARD))
    vertices, _ = scene.there("/world/walls/rim").given
    assert np.abs(vertices[:, 0]).min() == pytest.approx(5.0)
    assert np.abs(vertices[:, 1]).max() == pytest.approx(2.5)
    scene = Stand()
    Walls(scene).draw(shown(HALL))
    assert len(scene.there("/world/walls/glass").given[1]) == 12
    scene = Stand()
    Walls(scene).draw(shown(World("wrap", (4.0, 4.0), ("wrap", "wrap"))))
    assert not scene.sent


def test_edges_are_whole_where_solid_dashed_where_they_wrap_and_apart_where_open():
    solid = Stage(2, (2.0, 2.0), (False, True), solid=(True, False, False))
    closed, opened = edges_by_kind(solid)
    along_y = closed[closed[:, 0, 0] == closed[:, 1, 0]]
    along_x = closed[closed[:, 0, 1] == closed[:, 1, 1]]
    assert (len(along_y), len(opened)) == (2, 0)
    assert len(along_x) > 20
    length = np.linalg.norm(along_x[:, 1] - along_x[:, 0], axis=1).sum()
    assert 0.5 < length / (2.0 * solid.side) < 0.7
    closed, opened = edges_by_kind(Stage(3, (2.0, 2.0, 2.0), (False, False, True)))
    upright = opened[opened[:, 0, 2] != opened[:, 1, 2]]
    assert len(upright) == len(opened) == 4
    assert (closed[:, 0, 2] == closed[:, 1, 2]).all()


def test_waypoints_left_behind_are_dim():
    scene = Stand()
    part = MissionMarks(scene)
    draw(part, shown(YARD))
    ahead = np.array(scene.there("/mission/path/ahead").points)
    assert not scene.there("/mission/path/behind").visible
    draw(part, shown(YARD, progress=MissionProgress(done=2)))
    left = np.array(scene.there("/mission/path/ahead").points)
    done = np.array(scene.there("/mission/path/behind").points)
    assert len(left) + len(done) == len(ahead)
    assert done[..., 0].max() <= shown(YARD).stage.to_display(np.array([6.0, 3.0]))[0] + 1e-6
    colours = np.asarray(scene.there("/mission/path/waypoints").batched_colors, int)
    assert np.array_equal(colours[0], colours[1])
    assert colours[0].sum() > colours[2].sum()
    assert {node.given[0] for node in scene.sent if "number" in node.name} == {"1", "2", "3"}


def test_the_goal_moves_and_goes_with_the_switch():
    scene = Stand()
    part = MissionMarks(scene)
    at = np.array([14.0, 10.0])
    draw(part, shown(YARD, progress=MissionProgress(goal=at)))
    bead = scene.there("/mission/goal/bead")
    assert bead.visible
    assert bead.position[:2] == pytest.approx(shown(YARD).stage.to_display(at)[:2])
    draw(part, shown(YARD, progress=MissionProgress(goal=at - 1.0)))
    assert bead.position[:2] == pytest.approx(shown(YARD).stage.to_display(at - 1.0)[:2])
    draw(part, shown(YARD, DrawingStyle(mission=False), progress=MissionProgress(goal=at)))
    assert not bead.visible
    assert not scene.there("/mission/path/ahead").visible
    assert not any("number" in node.name and node.there for node in scene.sent)


def test_the_start_region_is_outlined_where_it_is():
    scene = Stand()
    part = MissionMarks(scene)
    room = np.array([-3.0, 3.0]), np.array([-1.0, 5.0])
    draw(part, shown(YARD, room=room))
    lines = scene.there("/mission/start")
    corners = shown(YARD).stage.to_display(np.array(room))
    assert np.array(lines.points)[..., :2].reshape(-1, 2).min(axis=0) == pytest.approx(
        corners[0, :2]
    )
    assert np.array(lines.points)[..., :2].reshape(-1, 2).max(axis=0) == pytest.approx(
        corners[1, :2]
    )
    draw(part, shown(YARD, DrawingStyle(start=False), room=room))
    assert not lines.visible


def test_boundary_points_are_dots_that_are_sent_once():
    scene = Stand()
    part = BoundaryPointMarks(scene)
    points = np.array([[1.0, 5.0], [3.0, 5.0]])
    part.draw(shown(YARD, DrawingStyle(points=True)))
    changes = part.draw(shown(YARD, DrawingStyle(points=True), points=points))
    drawn = {name: value for _, name, value in changes}
    assert drawn["points"][:, :2] == pytest.approx(shown(YARD).stage.to_display(points)[:, :2])
    assert part.draw(shown(YARD, DrawingStyle(points=True), points=points)) == []
    assert [change[1:] for change in part.draw(shown(YARD, points=points))] == [("visible", False)]


def test_a_mission_beyond_the_box_is_in_view():
    mission = Mission(path=Path(waypoints=((40.0, 7.0),), switch=1.0))
    _, high = extent(shown(replace(YARD, mission=mission)))
    assert high[0] == pytest.approx(15.0 + 2.0)


def test_a_close_flock_has_darts_that_can_be_told_apart():
    room = np.array([-3.0, 3.0]), np.array([-1.0, 5.0])
    close, wide = shown(YARD, room=room), shown(YARD)
    assert close.length < wide.length
    assert close.length <= 0.6 * 1.0 * close.stage.scale


def test_arrows_are_shares_of_the_strongest_force():
    ends, colour = arrows({"a": np.array([3.0, 4.0]), "b": np.zeros(2), "c": np.array([0.0, 1.0])})
    assert ends == pytest.approx(np.array([[0.6, 0.8, 0.0], [0.0, 0.2, 0.0]]))
    assert len(colour) == 2
    assert len(arrows({"a": np.zeros(2)})[0]) == 0
    assert len(arrows({})[0]) == 0


PLACES = {"following": 1.0, "split_x": 1.0, "split_y": 2.0, "rejoin_x": 0.0, "rejoin_y": 0.0}
PLACES |= {"aim_x": 3.0, "aim_y": 4.0}
SEEN = Inspection(
    1, 1, np.empty(0, int), np.empty((0, 2)), np.empty(0), PLACES,
    {"push": np.array([1.0, 0.0])}, np.array([[5.0, 5.0]]),
    places=("split", "rejoin", "aim"), minds=True,
)  # fmt: skip


def test_places_are_remembered_only_while_an_agent_follows_a_boundary():
    assert {k: v.tolist() for k, v in remembered_places(SEEN).items()} == {
        "split": [1, 2],
        "aim": [3, 4],
    }
    assert remembered_places(replace(SEEN, minds=False)) == {}
    assert remembered_places(replace(SEEN, places=())) == {}


def test_reasons_are_drawn_for_the_inspected_agent_and_gone_with_it():
    scene = Stand()
    part = ReasonMarks(scene)
    draw(part, shown(YARD, inspected=SEEN))
    tip = np.array(scene.there("/inspected/forces").points)[0, 1] - shown(YARD).at[1]
    assert tip[:2] == pytest.approx([0.85, 0.0], abs=1e-5)
    words = {node.given[0] for node in scene.sent if "words" in node.name and node.visible}
    assert words == {"split", "aim"}
    draw(part, shown(YARD))
    assert not any(node.visible for node in scene.sent)


def picture_of(at: np.ndarray) -> Any:
    """What a camera has to know of agents at places (N, 3) in the open, in a box of two by two."""
    stage = SimpleNamespace(
        half=np.array([1.0, 1.0, 0.0]), side=2.0, dim=2, to_display=lambda _: np.empty((0, 3))
    )
    frame = SimpleNamespace(room=None, world=SimpleNamespace(mission=None))
    return SimpleNamespace(at=at, count=len(at), leader=None, stage=stage, frame=frame)


@pytest.mark.parametrize(
    ("east", "low", "high"),
    [
        (0.5, -1.0, 1.0),
        (4.0, -1.0, 4.0),  # its world and the way from there
        (40.0, 39.0, 41.0),  # itself alone, in as much room
    ],
)
def test_a_flock_in_the_open_is_shown_with_its_world_until_it_is_far_from_it(east, low, high):
    corners = extent(picture_of(np.tile([east, 0.0, 0.0], (5, 1))))
    assert [corners[0][0], corners[1][0]] == pytest.approx([low, high])
    assert [corners[0][1], corners[1][1]] == pytest.approx([-1.0, 1.0])
