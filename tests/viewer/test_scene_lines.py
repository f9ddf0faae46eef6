"""Trails, links, picking, cameras and the gizmo, on a server without a browser."""

from dataclasses import replace

import numpy as np
import pytest
import viser

from app.package_files import STATIC
from app.viewer.scene.cameras.camera import view
from app.viewer.scene.draw.drawn_frame import picture
from app.viewer.scene.draw.line_segments import segments
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks.flock_marks import sample
from app.viewer.scene.marks.gizmo import check_pose
from app.viewer.scene.marks.labels import anchor
from app.viewer.scene.marks.trails import Trails, match_rows, trailed_rows
from app.viewer.scene.marks.world_box import floor_under, has_left_box
from app.viewer.scene.scene import Scene, pick_agent
from app.viewer.scene.shown.colouring import COLOURINGS
from app.viewer.scene.shown.drawing_style import CAMERAS, DrawingStyle, legend
from app.viewer.scene.shown.frame import Frame
from worlds.world import World

TORUS = World("wrap", (10.0, 10.0), ("wrap", "wrap"))
LOOK = DrawingStyle(trails="line", trail_length=16)


class Lines:
    """Stands for viser: remembers what lines were drawn."""

    def __init__(self) -> None:
        self.visible = False
        self.points = np.empty((0, 2, 3))
        self.colors = np.empty(0)

    def add_line_segments(self, *_args, **_kwargs) -> "Lines":
        return Lines()


def walker(tick: int, x: float, run: int = 1, ids: tuple[int, ...] = (0, 1)) -> Frame:
    """Agents flying along +x from `x`, on a torus of side 10."""
    count = len(ids)
    position = np.column_stack([np.full(count, x % 10.0), 2.0 + np.array(ids)])
    return Frame(
        run=run,
        tick=tick,
        world=TORUS,
        reach=1.0,
        speed_scale=1.0,
        position=position,
        heading=np.tile([1.0, 0.0], (count, 1)),
        speed=np.ones(count),
        informed=np.zeros(count, dtype=bool),
        ids=np.array(ids),
    )


def drawn(trails: Trails, frame: Frame, look: DrawingStyle = LOOK) -> np.ndarray:
    """All segments on show after a frame, (K, 2, 3)."""
    for handle, name, value in trails.draw(picture(frame, look, Stage.of(frame))):
        setattr(handle, name, value)
    handles = (trails._old, trails._young, trails._tip)
    return np.concatenate([handle.points for handle in handles if handle.visible] or [[]])


def moving(lines: np.ndarray) -> np.ndarray:
    return lines[np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > 0.0] if len(lines) else lines


def test_a_trail_reaches_back_its_length_in_ticks():
    trails = Trails(Lines())
    for tick in range(40):
        lines = drawn(trails, walker(tick, 0.1 * tick))
    of_one = lines[np.isclose(lines[:, 0, 1], 2.0 - 5.0)]
    length = np.linalg.norm(of_one[:, 1] - of_one[:, 0], axis=1).sum()
    assert length == pytest.approx(16 * 0.1, rel=1e-5)


def test_a_trail_breaks_at_the_seam():
    trails = Trails(Lines())
    for tick in range(12):
        lines = moving(drawn(trails, walker(tick, 9.4 + 0.1 * tick)))
    assert len(lines) == 2 * 10
    assert np.max(np.abs(lines[:, 1] - lines[:, 0])) < 0.11


def test_trails_are_forgotten_with_the_run_and_when_switched_off():
    trails = Trails(Lines())
    for tick in range(10):
        drawn(trails, walker(tick, 0.1 * tick))
    assert len(moving(drawn(trails, walker(10, 5.0, run=2)))) == 0
    drawn(trails, walker(11, 5.1, run=2))
    assert len(drawn(trails, walker(12, 5.2, run=2), DrawingStyle())) == 0
    assert len(moving(drawn(trails, walker(13, 5.3, run=2)))) == 0


def test_trails_survive_agents_that_come_and_go():
    trails = Trails(Lines())
    for tick in range(5):
        drawn(trails, walker(tick, 0.1 * tick))
    lines = drawn(trails, walker(5, 0.5, ids=(1, 7)))
    assert np.unique(moving(lines)[:, 0, 1]).tolist() == [3.0 - 5.0]


def test_identities_carry_their_positions():
    knot = np.arange(9.0).reshape(3, 3)
    found = match_rows(knot, np.array([4, 2, 9]), np.array([9, 5, 4]))
    assert found[0].tolist() == [6.0, 7.0, 8.0]
    assert np.isnan(found[1]).all()
    assert found[2].tolist() == [0.0, 1.0, 2.0]


def test_of_many_agents_the_leader_keeps_its_trail():
    informed = np.zeros(5_000, dtype=bool)
    informed[1_234] = True
    rows = trailed_rows(informed, 800)
    assert 1_234 in rows
    assert len(rows) <= 801
    assert trailed_rows(informed[:700], 800).tolist() == list(range(700))


def test_a_sample_of_links_is_fair_and_steady():
    pairs = np.random.default_rng(0).integers(0, 3_000, (50_000, 2))
    kept = sample(pairs, 10_000)
    assert len(kept) == pytest.approx(10_000, rel=0.05)
    again = sample(pairs[::-1, ::-1], 10_000)
    assert {tuple(sorted(p)) for p in kept.tolist()} == {tuple(sorted(p)) for p in again.tolist()}
    assert sample(pairs[:100], 10_000) is not None


def test_no_lines_hide_the_node():
    handle = Lines()
    changes = {name: value for _, name, value in segments(handle, np.empty((0, 2, 3)), (9, 9, 9))}
    assert changes["visible"] is False
    assert not changes["points"].any(), "what was there before flashes up when it is shown again"


def test_a_click_picks_the_agent_under_it_and_the_empty_floor_none():
    at = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.02, 0.0, -8.0]])
    radius = np.full(3, 0.2)
    down = np.array([0.0, 0.0, -1.0])
    assert pick_agent(np.array([1.05, 0.0, 9.0]), down, at, radius) == 1
    assert pick_agent(np.array([0.0, 0.0, 9.0]), down, at, radius) == 0
    assert pick_agent(np.array([4.0, 4.0, 9.0]), down, at, radius) is None
    assert pick_agent(np.array([0.0, 0.0, 9.0]), -down, at, radius) is None
    assert pick_agent(np.array([np.nan, 0.0, 9.0]), down, at, radius) is None
    assert pick_agent(np.zeros(3), down, np.empty((0, 3)), np.empty(0)) is None


@pytest.mark.parametrize("name", CAMERAS)
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("aspect", [0.6, 1.0, 1.8])
def test_the_whole_world_is_in_view(name, dim, aspect):
    half = np.array([5.0, 2.5, 0.0]) if dim == 2 else np.array([4.0, 3.0, 2.0])
    seen = view(name, dim, -half, half, aspect)
    forward = seen.target - seen.position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half
    away = corners - seen.position
    depth = away @ forward
    assert np.all(depth > 0.0)
    tangent = np.tan(0.5 * seen.fov)
    assert np.all(np.abs(away @ up) <= depth * tangent)
    assert np.all(np.abs(away @ right) <= depth * tangent * aspect)
    widest = max(
        np.max(np.abs(away @ up) / (depth * tangent)),
        np.max(np.abs(away @ right) / (depth * tangent * aspect)),
    )
    assert widest > 0.6


def test_an_unknown_camera_is_an_error():
    with pytest.raises(ValueError, match="camera = 'inside'"):
        view("inside", 2, -np.ones(3), np.ones(3), 1.0)


def test_a_pose_from_a_browser_is_checked():
    stage = Stage(2, (10.0, 10.0), (True, False))
    turn = np.array([np.cos(np.pi / 4), 0.0, 0.0, np.sin(np.pi / 4)])
    position, heading = check_pose(stage, np.array([6.0, 1.0, 3.0]), 3.0 * turn)
    assert position == pytest.approx([1.0, 6.0])
    assert heading == pytest.approx([0.0, 1.0])
    position, _ = check_pose(stage, np.array([0.0, 1e12, 0.0]), turn)
    assert position[1] == pytest.approx(45.0)
    assert check_pose(stage, np.array([np.nan, 0.0, 0.0]), turn) is None
    assert check_pose(stage, np.zeros(3), np.zeros(4)) is None


def test_the_floor_follows_a_flock_that_leaves_an_open_world():
    frame = walker(0, 5.0)
    assert not has_left_box(picture(frame, DrawingStyle(), Stage.of(frame)))
    away = replace(
        frame,
        world=replace(TORUS, edges=("open", "open")),
        position=frame.position + np.array([12.0, 0.0]),
    )
    shown = picture(away, DrawingStyle(), Stage.of(away))
    assert has_left_box(shown)
    assert floor_under(shown) == pytest.approx([12.5, -2.5, -0.05])


@pytest.mark.parametrize(
    ("place", "expected"),
    [
        ((5.0, 5.0), "bottom-center"),
        ((5.0, 9.9), "top-center"),
        ((9.9, 5.0), "bottom-right"),
        ((0.1, 9.9), "top-left"),
        ((30.0, 5.0), "bottom-center"),
    ],
)
def test_words_stay_within_the_picture(place, expected):
    frame = replace(walker(0, 0.0, ids=(0,)), position=np.array([place]))
    assert anchor(picture(frame, DrawingStyle(), Stage.of(frame)), 0) == expected


def test_static_files_are_found_in_a_checkout():
    assert (STATIC / "logo.svg").is_file()


@pytest.fixture
def server():
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    yield server
    server.stop()


def test_a_scene_stands_any_number_of_agents_and_a_change_of_world(server):
    scene = Scene(server)
    scene.show_leader_gizmo(True)
    look = DrawingStyle(trails="line", links=True, reach=True, labels=True)
    for run, (count, dim) in enumerate([(0, 2), (1, 2), (40, 3), (3, 3), (12_000, 2), (0, 3)]):
        rng = np.random.default_rng(run)
        heading = rng.standard_normal((count, dim))
        frame = Frame(
            run=run,
            tick=0,
            world=World("open", (4.0 + run,) * dim, ("open",) * dim),
            reach=1.0,
            speed_scale=0.0,
            position=rng.random((count, dim)) * 9.0,
            heading=heading / np.linalg.norm(heading, axis=1)[:, None],
            speed=np.zeros(count),
            informed=np.arange(count) < 2,
            ids=np.arange(count),
            links=rng.integers(0, max(count, 1), (2 * count, 2)),
        )
        for colour in COLOURINGS:
            frame = replace(frame, tick=frame.tick + 1)
            scene.show(frame, replace(look, colour=colour))
            assert legend(replace(look, colour=colour), frame) or not count
