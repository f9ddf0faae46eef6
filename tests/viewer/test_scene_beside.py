"""Two flocks in one scene: where the second one stands, and which of them a click means."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import viser

from app.viewer.scene.cameras.viewpoints import TITLE, extent, scene_corners
from app.viewer.scene.draw.drawn_frame import Picture, picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.scene import (
    GAP,
    ROOT,
    TITLED,
    Scene,
    find_clicked,
    offset,
    room,
    sights,
    stands_below,
    title_place,
)
from app.viewer.scene.shown.drawing_style import DrawingStyle
from app.viewer.scene.shown.frame import Frame
from worlds.world import World

DOWN = np.array([0.0, 0.0, -1.0])


def frame(size: tuple[float, ...], edge: str = "wrap", count: int = 5) -> Frame:
    dim = len(size)
    rng = np.random.default_rng(1)
    heading = np.tile(np.eye(dim)[0], (count, 1))
    return Frame(
        run=1,
        tick=0,
        world=World("box", size, (edge,) * dim),
        reach=1.0,
        speed_scale=1.0,
        position=rng.random((count, dim)) * size,
        heading=heading,
        speed=np.ones(count),
        informed=np.arange(count) < 1,
        ids=np.arange(count),
        title="One",
    )


def drawn(one: Frame) -> Picture:
    return picture(one, DrawingStyle(), Stage.of(one))


@pytest.mark.parametrize(
    "size", [(8.0, 8.0), (8.0, 6.0), (3.0, 9.0), (62.0, 18.0), (4.0, 5.0, 2.0)]
)
def test_the_second_room_stands_clear_of_the_first_and_a_wide_one_below(size):
    shown = drawn(frame(size))
    low, high = room(shown)
    away = offset(shown)
    below = size == (62.0, 18.0)
    assert (away[0] == 0.0, away[1] == 0.0) == (below, not below)
    gap = -away[1] - (high - low)[1] if below else away[0] - (high - low)[0]
    assert 0.0 < gap < 0.3 * shown.stage.side
    cells = away[:2] / (shown.stage.side / 20)
    assert cells == pytest.approx(np.rint(cells))


@pytest.mark.parametrize(
    ("size", "aspects", "below"),
    [
        ((8.0, 8.0), [0.8], True),
        ((8.0, 8.0), [1.5], False),
        ((8.0, 8.0), [0.8, 1.5, 1.5], False),
        ((62.0, 18.0), [1.0], True),
        ((62.0, 18.0), [4.0], False),
        ((3.0, 9.0), [0.5], False),
        ((4.0, 5.0, 2.0), [0.5], False),
    ],
)
def test_two_rooms_stand_as_they_are_larger_in_the_browsers_there_are(size, aspects, below):
    shown = drawn(frame(size))
    assert stands_below(shown, aspects) == below
    assert (offset(shown, below)[0] == 0.0) == below


def test_two_rooms_change_over_only_where_that_is_worth_it():
    shown = drawn(frame((8.0, 8.0)))
    aspect = (2.0 + GAP) / (2.0 + TITLED + TITLE[2])  # as large both ways
    assert [stands_below(shown, [aspect], now) for now in (False, True)] == [False, True]


@pytest.mark.parametrize("size", [(8.0, 8.0), (62.0, 18.0), (4.0, 5.0, 2.0)])
def test_cameras_take_in_both_rooms_and_their_titles(size):
    shown = drawn(frame(size))
    both = sights(shown, shown)
    low, high = scene_corners(both)
    for picture_, aside in both:
        mine = [corner + aside for corner in extent(picture_)] + [aside + title_place(picture_)]
        for corner in mine:
            assert np.all(corner >= low - 1e-9)
            assert np.all(corner <= high + 1e-9)
    alone = scene_corners(sights(shown, None))
    np.testing.assert_array_equal(alone, extent(shown))


def test_a_click_means_the_agent_it_hits_in_the_flock_it_is_in():
    shown = drawn(frame((8.0, 8.0)))
    both = sights(shown, shown)
    for side, (one, aside) in enumerate(both):
        for row, at in enumerate(one.at):
            assert find_clicked(both, at + aside + [0.0, 0.0, 40.0], DOWN, 1e-4) == (side, row)
        half = one.stage.half
        corner = aside + np.array([0.98 * half[0], -0.98 * half[1], 40.0])
        assert find_clicked(both, corner, DOWN, 1e-4) == (side, None)
    assert find_clicked(both, np.zeros(3), np.array([1.0, 0.0, 0.0]), 1e-4)[1] is None


@pytest.fixture
def server():
    made = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield made
    made.stop()


def test_the_second_room_comes_and_goes(server):
    scene = Scene(server)
    look = DrawingStyle(trails="line", reach=True, labels=True)
    nodes = server.scene._handle_from_node_name

    def beside() -> list[str]:
        return [name for name in nodes if name.startswith((ROOT, "/titles/"))]

    for size in ((8.0, 8.0), (62.0, 18.0), (4.0, 5.0, 2.0)):
        one = frame(size, edge="open")
        scene.show(one, look)
        alone = set(nodes)
        assert not beside()
        two = replace(one, tick=1, beside=replace(one, title="Two", position=one.position * 3.0))
        scene.show(two, look)
        assert {name.removeprefix(ROOT) for name in beside()} >= {
            name for name in alone if name.startswith(("/flock/", "/world/"))
        }
        titles = [nodes[f"/titles/{name}"] for name in ("first", "second")]
        assert [title.text for title in titles] == ["One", "Two"]
        assert nodes[ROOT].position == pytest.approx(offset(drawn(one)))
        # Each is moved by itself: in a browser a label does not follow a room that moves.
        aside = titles[1].position - titles[0].position
        assert aside == pytest.approx(nodes[ROOT].position)
        scene.show(replace(one, tick=2), look)
        assert not beside()
