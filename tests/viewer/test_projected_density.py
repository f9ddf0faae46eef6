"""Density of flocks in space as a camera sees it: who is in sight, where, and how far away."""

from __future__ import annotations

import io
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

from agents.flock import Flock
from agents.spec import Spec
from app.front.viser_internals import DEPTH_STEP
from app.viewer.lab.laboratory import Laboratory
from app.viewer.measuring import flock_readings
from app.viewer.panels.monitors import describe_flock
from app.viewer.pictures.picture_sheet import Sheet
from app.viewer.pictures.shot import look_of, shot
from app.viewer.run.run_preset import preset_spec
from app.viewer.scene.cameras import space_density
from app.viewer.scene.cameras.space_density import camera_lens, near_within, view_file
from app.viewer.scene.draw.drawn_frame import picture
from app.viewer.scene.draw.projected_density import (
    NEAREST,
    Lens,
    ProjectedDensity,
    count_by_depth,
    fill_rows_in_view,
    fill_view_sums,
    projected_density,
    view_shape,
)
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks.world_box import sky_rows
from app.viewer.scene.shown import drawing_style, palette
from app.viewer.scene.shown.drawing_style import DARTS, DrawingStyle, shows_density
from tests.live.stand_in import CAMERA, StandIn
from tests.viewer.test_ride import frame as frame_at
from tests.viewer.waiting import COMPILED, until

STAGE = Stage(3, (16.0, 16.0, 16.0), (True, True, True))
"""Two units of length are one of the display, and the middle is at (8, 8, 8)."""
MIDDLE = np.full(3, 8.0)
EAST, UP = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def lens_from(eye, target=(0.0, 0.0, 0.0), fov=0.8, aspect=1.5):
    return Lens.of(np.array(eye, float), np.array(target, float), UP, fov, aspect, STAGE)


AHEAD = lens_from((-10.0, 0.0, 0.0))
"""Looks along x at the middle of the world, which is 10 ahead."""


def raw_sums(position, heading, lens, rows, columns, near=NEAREST):
    """The sums of each cell of a view, and how far the nearest is."""
    sums = np.zeros((rows + 4, columns + 4, 3), np.float32)
    nearest = np.full((rows + 4, columns + 4), np.inf, np.float32)
    fill_view_sums(position, heading, lens.axes, near, sums, nearest)
    return sums[2:-2, 2:-2], nearest[2:-2, 2:-2]


# Against a naive projection.

coordinates = st.floats(-40.0, 40.0, width=32)
places = arrays(float, st.tuples(st.integers(0, 30), st.just(3)), elements=coordinates)
points = arrays(float, 3, elements=st.floats(-12.0, 12.0, width=16))


@settings(max_examples=60)
@given(places, points, points, st.floats(0.2, 2.0), st.floats(0.4, 2.5), st.integers(0, 9))
def test_sums_are_those_of_a_naive_projection(position, eye, target, fov, aspect, seed):
    back = eye - target
    if np.linalg.norm(np.cross(back, UP)) < 0.1:
        return  # straight above there is no upright picture
    rows, columns = 6, 9
    heading = np.random.default_rng(seed).normal(size=position.shape)
    # A turned frame, whose z axis points at the camera, and a pinhole 1 from its picture.
    z = back / np.linalg.norm(back)
    x = np.cross(UP, z) / np.linalg.norm(np.cross(UP, z))
    turned = ((position - MIDDLE) / 2.0 - eye) @ np.stack([x, np.cross(z, x), z]).T
    expected, depth = np.zeros((rows, columns, 3)), np.full((rows, columns), np.inf)
    for (right, over, behind), ahead in zip(turned, heading, strict=True):
        if -behind <= NEAREST:
            continue
        across = right / -behind / (np.tan(fov / 2) * aspect), over / -behind / np.tan(fov / 2)
        column, row = (across[0] + 1) / 2 * columns, (1 - across[1]) / 2 * rows
        if min(abs(column - round(column)), abs(row - round(row))) < 1e-6:
            return  # on the edge of a cell it may be rounded into either
        if 0 <= column < columns and 0 <= row < rows:
            expected[int(row), int(column)] += 1.0, ahead[0], ahead[1]
            depth[int(row), int(column)] = min(depth[int(row), int(column)], -behind)
    lens = Lens.of(eye, target, UP, fov, aspect, STAGE)
    sums, nearest = raw_sums(position, heading, lens, rows, columns)
    np.testing.assert_allclose(sums, expected, atol=1e-5)
    np.testing.assert_allclose(nearest, depth, rtol=1e-5)
    counts = np.zeros(1, np.int64)
    count_by_depth(position, lens.axes, NEAREST, np.inf, counts)
    assert counts[0] == expected[..., 0].sum()


@given(places, st.floats(0.5, 20.0), st.floats(0.3, 3.0))
def test_who_is_in_sight_is_counted_by_depth_and_found(position, far, step):
    counts = np.zeros(5, np.int64)
    count_by_depth(position, AHEAD.axes, NEAREST, step, counts)
    rows = np.full(len(position), -1)
    found = rows[: fill_rows_in_view(position, AHEAD.axes, NEAREST, np.inf, rows)].copy()
    depth = (position[found, 0] - 8.0) / 2.0 + 10.0
    assert (
        counts.tolist()
        == np.bincount(np.minimum(depth / step, 4).astype(int), minlength=5).tolist()
    )
    near = fill_rows_in_view(position, AHEAD.axes, NEAREST, far, rows)
    assert rows[:near].tolist() == found[depth <= far].tolist()


# Exact cases.


def test_who_is_in_the_middle_of_the_view_is_in_the_middle_cell():
    sums, nearest = raw_sums(MIDDLE[None], EAST[None], AHEAD, 5, 7)
    assert np.argwhere(sums[..., 0]).tolist() == [[2, 3]]
    assert sums[2, 3].tolist() == [1.0, 1.0, 0.0]
    assert nearest[2, 3] == pytest.approx(10.0)


@pytest.mark.parametrize(
    ("move", "row", "column"),
    [((0.0, -3.0, 0.0), 2, 4), ((0.0, 3.0, 0.0), 2, 2), ((0, 0, 3.0), 1, 3), ((0, 0, -3.0), 3, 3)],
)
def test_right_and_up_are_where_they_are_for_who_looks_along_x(move, row, column):
    sums, _ = raw_sums(MIDDLE[None] + np.array(move), EAST[None], AHEAD, 5, 7)
    assert np.argwhere(sums[..., 0]).tolist() == [[row, column]]


def test_behind_the_camera_and_nowhere_nobody_is_drawn():
    position = np.array([[-20.0, 8.0, 8.0], [np.nan, 8.0, 8.0], [8.0, np.inf, 8.0]])
    sums, nearest = raw_sums(position, np.tile(EAST, (3, 1)), AHEAD, 5, 7)
    assert not sums.any()
    assert np.isinf(nearest).all()
    made = projected_density([(position, np.tile(EAST, (3, 1)), AHEAD, NEAREST)], 1.5, 3)
    assert np.isinf(made.depth).all()


def test_who_is_nearer_than_drawing_begins_is_left_out():
    sums, _ = raw_sums(MIDDLE[None], EAST[None], AHEAD, 5, 7, near=10.5)
    assert not sums.any()


def test_a_picture_is_of_all_flocks_and_as_far_as_the_nearest():
    cloud = np.random.default_rng(1).normal(scale=0.5, size=(20_000, 3))
    heading = np.tile(EAST, (20_000, 1))
    left, right = np.array([8.0, 13.0, 8.0]), np.array([12.0, 3.0, 8.0])
    flocks = [
        (cloud + left, heading, AHEAD, NEAREST),
        (cloud + right, -heading, AHEAD, NEAREST),
    ]
    made = projected_density(flocks, 1.5, 40_000)
    half = made.depth.shape[1] // 2
    assert 8.5 < made.depth[:, :half].min() < 10.0
    assert 10.5 < made.depth[:, half:].min() < 12.0
    drawn = np.isfinite(made.depth)
    colours = [
        np.median(part[mask], axis=0)
        for part, mask in (
            (made.pixels[:, :half], drawn[:, :half]),
            (made.pixels[:, half:], drawn[:, half:]),
        )
    ]
    for colour, way in zip(colours, (EAST, -EAST), strict=True):
        wheel = palette.heading_colours(way[None, :2])[0]
        assert np.argmax(colour) == np.argmax(wheel)


def test_the_hue_stays_while_the_camera_goes_round_and_who_climbs_is_grey():
    position = np.random.default_rng(2).uniform(4.0, 12.0, (50_000, 3))
    seen = []
    for eye in ((-10.0, 0.0, 3.0), (0.0, 10.0, 3.0)):
        flock = (position, np.tile(EAST, (50_000, 1)), lens_from(eye), NEAREST)
        made = projected_density([flock], 1.5, 50_000)
        seen.append(np.median(made.pixels[np.isfinite(made.depth)].astype(int), axis=0))
    assert np.abs(seen[0] - seen[1]).max() <= 12
    flock = (position, np.tile(UP, (50_000, 1)), lens_from((-10.0, 0.0, 3.0)), NEAREST)
    made = projected_density([flock], 1.5, 50_000)
    grey = made.pixels[np.isfinite(made.depth)].astype(int)
    assert np.ptp(grey, axis=1).max() <= 12
    assert np.ptp(seen[0]) > 60


def test_cells_are_square_and_as_fine_as_there_are_agents_for():
    assert np.prod(view_shape(16 / 9, 10**7)) <= 512 * 288
    rows, columns = view_shape(2.0, 20_000)
    assert columns / rows == pytest.approx(2.0, rel=0.02)
    assert min(view_shape(0.1, 0)) > 1
    assert max(view_shape(10.0, 10**9)) <= 1024


# What a browser is sent.


def test_the_files_have_the_sky_and_nothing_near_where_nobody_is():
    pixels = np.full((40, 60, 3), 40, np.uint8)
    depth = np.full((40, 60), np.inf, np.float32)
    depth[10:30, 20:40] = 7.0
    file = view_file(ProjectedDensity(pixels, depth))
    colours = np.asarray(Image.open(io.BytesIO(file.colours)).convert("RGB"), int)
    far = np.asarray(Image.open(io.BytesIO(file.depth)), int)
    assert np.abs(colours[15:25, 25:35] - 40).max() < 12
    assert np.abs(colours[:, :10] - sky_rows(40)[:, None]).max() < 12
    assert set(far[10:30, 20:40].ravel()) == {int(7.0 / DEPTH_STEP)}
    assert set(far[:, :20].ravel()) == {255}


def camera(**changes):
    known = {
        "position": np.array([-10.0, 0.0, 0.0]), "look_at": np.zeros(3), "up_direction": UP,
        "fov": 0.8, "image_width": 900, "image_height": 600,
    }  # fmt: skip
    return SimpleNamespace(**known | changes)


def shown(count, **changes):
    position = np.random.default_rng(1).uniform(0.0, 20.0, (count, 3))
    frame = frame_at(3, position, np.tile(EAST, (count, 1)), **changes)
    return picture(frame, DrawingStyle(), Stage.of(frame))


@pytest.mark.parametrize(
    "junk",
    [
        {"position": np.array([np.nan, 0.0, 1.0])},
        {"position": np.zeros(3)},
        {"position": np.array([1e300, 0.0, 1e-300])},
        {"look_at": np.array([np.inf, 0.0, 0.0])},
        {"up_direction": np.zeros(3)},
        {"up_direction": EAST},
        {"fov": np.pi},
        {"fov": 0.0},
        {"fov": np.nan},
        {"fov": -1.0},
        {"image_height": 0},
        {"image_width": -5},
        {"image_width": 10**9},
    ],
)
def test_a_camera_that_is_none_sees_nobody_or_somebody(junk):
    made = shown(500)
    odd = camera(**junk)
    lens = camera_lens(odd, made, np.zeros(3))
    within = near_within(odd, made)
    assert NEAREST <= within <= made.stage.side
    frame = made.frame
    counts = np.zeros(4, np.int64)
    count_by_depth(frame.position, lens.axes, NEAREST, within, counts)
    assert 0 <= counts.sum() <= 500
    flock = (frame.position, frame.heading, lens, NEAREST)
    view_file(projected_density([flock], lens.aspect, int(counts.sum())))


def test_more_agents_than_the_limit_in_space_are_density(monkeypatch):
    monkeypatch.setattr(drawing_style, "DENSITY_BEYOND", 50)
    assert not shows_density(shown(50).frame)
    assert shows_density(shown(51).frame)
    rows = np.array([3, 17])
    assert shown(51).of_rows(rows).form == DARTS, "nobody follows how single birds bank"


class ViewBrowser(StandIn):
    """Keeps what is drawn behind everything."""

    def __init__(self, port):
        self.backgrounds = []
        super().__init__(port)

    def hear(self, message):
        super().hear(message)
        if message["type"] == "BackgroundImageMessage":
            self.backgrounds.append(message["depth_data"] is not None)

    @property
    def sees_density(self):
        return bool(self.backgrounds) and self.backgrounds[-1]

    def look_from(self, *place, target=(0.0, 0.0, 0.0)):
        self.say(
            **CAMERA | {"position": list(place), "look_at": list(target), "up_direction": [0, 0, 1]}
        )


@pytest.fixture
def laboratory(monkeypatch):
    monkeypatch.setattr(drawing_style, "DENSITY_BEYOND", 500)
    monkeypatch.setattr(drawing_style, "SINGLES_UP_TO", 100)
    monkeypatch.setattr(flock_readings, "MEASURED_ASIDE", 500)
    made = Laboratory(preset_spec("vem", agents=2_000, dim=3, seed=2), port=0, running=False)
    assert made.simulation.ready.wait(COMPILED)
    yield made
    made.close()


def sight(laboratory):
    """What the one browser has in sight."""
    for client in laboratory.server.get_clients().values():
        for flock in laboratory.scene.in_sight(client):
            return flock
    return None


def draws_singles(laboratory):
    """Whether agents are drawn one by one for the one browser."""
    flock = sight(laboratory)
    return flock.agents is not None and flock.agents._darts.visible


def test_a_browser_sees_density_and_from_near_single_agents(laboratory, monkeypatch):
    with ViewBrowser(laboratory.port) as browser:
        until(lambda: browser.sees_density, COMPILED)
        browser.look_from(0.0, -60.0, 5.0)
        until(lambda: sight(laboratory).count == 2_000)
        assert sight(laboratory).near == 0
        assert "Density of 2\u202f000 agents in sight. " in describe_flock(sight(laboratory))
        monkeypatch.setattr(space_density, "NEAR_UP_TO", 200)
        browser.look_from(0.0, -8.0, 0.0)
        until(lambda: 0 < sight(laboratory).near <= 200)
        until(lambda: draws_singles(laboratory))
        assert browser.sees_density, "those behind them are density"
        assert "the nearest" in describe_flock(sight(laboratory))
        browser.look_from(3.9, 3.9, 3.9, target=(9.0, 9.0, 9.0))
        until(lambda: sight(laboratory).as_singles and not browser.sees_density)
        assert "drawn one by one" in describe_flock(sight(laboratory))
        browser.look_from(0.0, -60.0, 5.0)
        until(lambda: browser.sees_density and not draws_singles(laboratory))


def test_another_camera_has_another_picture_though_the_flock_stands(laboratory):
    with ViewBrowser(laboratory.port) as browser:
        until(lambda: browser.sees_density, COMPILED)
        before = len(browser.backgrounds)
        browser.look_from(0.0, -30.0, 5.0)
        until(lambda: len(browser.backgrounds) > before)
        view = next(iter(laboratory.scene._density._views.values()))
        until(lambda: view.space[0].lens.axes[0, 1] < 0.0)


def test_a_flock_that_is_set_up_small_is_drawn_agent_by_agent_before_the_sky(laboratory):
    with ViewBrowser(laboratory.port) as browser:
        until(lambda: browser.sees_density, COMPILED)
        laboratory.simulation.setup(preset_spec("vem", agents=30, dim=3, seed=2))
        until(lambda: sight(laboratory) is None and not browser.sees_density)


def test_two_flocks_beside_each_other_are_one_picture(laboratory):
    with ViewBrowser(laboratory.port) as browser:
        until(lambda: browser.sees_density, COMPILED)
        spec = preset_spec("vem", agents=600, dim=3, seed=2)
        laboratory.simulation.setup(spec, Spec("couzin"))
        browser.look_from(5.0, -90.0, 5.0, target=(5.0, 0.0, 0.0))
        client = next(iter(laboratory.server.get_clients().values()))
        until(lambda: [one.count for one in laboratory.scene.in_sight(client)] == [600, 600])
        until(lambda: len(laboratory.scene._density._dense.files) == 1)


# Pictures and films.


@pytest.fixture
def high(monkeypatch):
    """A flock that is all in the upper half of its world, and goes east."""
    monkeypatch.setattr(drawing_style, "DENSITY_BEYOND", 50)
    flock = Flock("vem", agents=4_000, dim=3, rng=1)
    flock.position[:, 2] = 0.5 * (flock.position[:, 2] + flock.world.size[2])
    flock.heading[:] = EAST
    return flock


def coloured_shares(sheet):
    """The shares of vivid pixels in the upper and in the lower half of the scene of a sheet."""
    left, top, wide, tall = sheet.box
    part = sheet.pixels()[top : top + tall, left : left + wide].astype(int)
    vivid = np.ptp(part, axis=2) > 40
    return vivid[: tall // 2].mean(), vivid[tall // 2 :].mean()


def test_pictures_and_films_are_of_density_too(high):
    now = high.snapshot(signals=True)
    sheet = Sheet(shot(now, look_of(now, None)), (640, 480))
    assert not len(sheet.scene.faces.get_paths())
    words = [text.get_text() for text in sheet.figure.legends[0].get_texts()]
    assert "faint: sparse; grey: not aligned or steep" in words
    upper, lower = coloured_shares(sheet)
    assert upper > 0.25 > 0.05 > lower
    high.position[:, 2] -= 0.5 * high.world.size[2]
    later = high.snapshot(signals=True)
    sheet.show(shot(later, look_of(later, None)))
    upper, lower = coloured_shares(sheet)
    assert lower > 0.25 > upper
