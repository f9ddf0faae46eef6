"""Pictures of density: how many agents there are, where they head, and who is drawn one by one."""

from __future__ import annotations

import gc
import io
import weakref
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from PIL import Image

from agents.flock import Flock
from agents.spec import Spec
from app.viewer.lab.laboratory import Laboratory
from app.viewer.measuring import flock_readings
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.panels.monitors import describe_sight
from app.viewer.pictures.film_writer import seen_picture
from app.viewer.pictures.picture_camera import Camera
from app.viewer.pictures.picture_sheet import Sheet
from app.viewer.pictures.player import Player, demand_playable, one_of, thinned_frame
from app.viewer.pictures.shot import look_of, shot
from app.viewer.run.run_preset import preset_spec
from app.viewer.scene.cameras.density_views import region_in_sight
from app.viewer.scene.cameras.flock_in_sight import KEEPS
from app.viewer.scene.draw.density import (
    CELLS,
    PlaneRegion,
    count_within,
    density_picture,
    fill_pixels,
    fill_rows_within,
    flock_region,
    grid_shape,
    smoothed_sums,
)
from app.viewer.scene.draw.drawn_frame import POINTS_BEYOND, picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.drawing import Drawing, Rates, load
from app.viewer.scene.marks.agents import Agents, FlockMotion
from app.viewer.scene.shown import drawing_style, palette
from app.viewer.scene.shown.drawing_style import DENSITY_PERIOD, DrawingStyle, shows_density
from tests.live.stand_in import CAMERA, StandIn
from tests.viewer.stub_flock import StubFlock
from tests.viewer.test_ride import frame as frame_at
from tests.viewer.waiting import COMPILED, until
from worlds.input_error import InputError
from worlds.world import World

BOX = PlaneRegion((0.0, 0.0), (8.0, 4.0))
BINOMIAL = np.array([1.0, 4.0, 6.0, 4.0, 1.0]) / 16.0
EAST, NORTH = np.array([1.0, 0.0]), np.array([0.0, 1.0])


def many(count: int, side: float = 20.0, dim: int = 2, **changes):
    """A frame of agents all over a box, which all go east."""
    position = np.random.default_rng(1).uniform(0.0, side, (count, dim))
    return frame_at(dim, position, np.tile(np.eye(dim)[0], (count, 1)), **changes)


# How many, and where they head.


def naive_sums(position, heading, region, rows, columns):
    """The sums about each cell, agent by agent: written apart."""
    wide, deep = region.sides[0] / columns, region.sides[1] / rows
    sums = np.zeros((rows, columns, 3))
    for (x, y), (u, v) in zip(position, heading, strict=True):
        column = int(np.floor((x - region.low[0] + 2 * wide) / wide)) - 2
        row = int(np.floor((y - region.low[1] + 2 * deep) / deep)) - 2
        for i in range(-2, 3):
            for j in range(-2, 3):
                if 0 <= row + i < rows and 0 <= column + j < columns:
                    weight = BINOMIAL[i + 2] * BINOMIAL[j + 2]
                    sums[row + i, column + j] += weight * np.array([1.0, u, v])
    return sums


places = arrays(
    float, st.tuples(st.integers(0, 40), st.just(2)), elements=st.floats(-3.0, 11.0, width=32)
)


@settings(max_examples=30)
@given(places, st.integers(1, 9), st.integers(1, 9), st.integers(0, 9))
def test_sums_are_those_of_the_naive_oracle(position, rows, columns, seed):
    angle = np.random.default_rng(seed).uniform(-np.pi, np.pi, len(position))
    heading = np.column_stack([np.cos(angle), np.sin(angle)])
    region = PlaneRegion((-0.5, 0.25), (7.5, 4.25))
    made = smoothed_sums(position, heading, region, rows, columns)
    expected = naive_sums(position, heading, region, rows, columns)
    # An agent on the edge of a cell may be rounded into the other.
    wide, deep = region.sides[0] / columns, region.sides[1] / rows
    edge = np.abs((position - region.low) / [wide, deep] % 1.0 - 0.5) > 0.5 - 1e-9
    if not edge.any():
        np.testing.assert_allclose(made, expected, atol=1e-5)
    else:
        assert made.shape == expected.shape


@given(places)
def test_who_is_in_a_region_is_counted_and_found(position):
    inside = np.all((position >= BOX.low) & (position < BOX.high), axis=1)
    assert count_within(position, *BOX.low, *BOX.high) == inside.sum()
    rows = np.full(inside.sum(), -1)
    assert fill_rows_within(position, *BOX.low, *BOX.high, rows) == inside.sum()
    assert rows.tolist() == np.flatnonzero(inside).tolist()


def test_who_is_nowhere_counts_nowhere():
    position = np.array([[np.nan, 1.0], [np.inf, 1.0], [1.0, 1.0]])
    heading = np.tile(EAST, (3, 1))
    assert count_within(position, *BOX.low, *BOX.high) == 1
    sums = smoothed_sums(position, heading, BOX, 20, 40)
    assert sums[..., 0].sum() == pytest.approx(1.0)


def test_cells_are_as_fine_as_there_are_agents_for():
    assert grid_shape(BOX, 10**9) == (round(CELLS / 2**0.5), round(CELLS * 2**0.5))
    rows, columns = grid_shape(BOX, 20_000)
    assert 20_000 / (rows * columns) == pytest.approx(2.0, rel=0.2)
    assert grid_shape(BOX, 1)[0] > 1
    assert grid_shape(PlaneRegion((0.0, 0.0), (1e6, 1e-3)), 10**6) == (1, 2 * CELLS)


# The colours.


def crowd(*headings):
    """The pixels of agents evenly all over the box, that head so in turn."""
    x, y = np.meshgrid(np.arange(0.01, 8.0, 0.02), np.arange(0.01, 4.0, 0.02))
    position = np.column_stack([x.ravel(), y.ravel()])
    heading = np.resize(headings, (len(position), 2))
    return density_picture(position, heading, BOX, len(position)).pixels[20:-20, 20:-20]


def distance(colour, other):
    return np.abs(np.asarray(colour, int) - np.asarray(other, int)).max()


def test_nobody_is_the_floor():
    pixels = density_picture(np.empty((0, 2)), np.empty((0, 2)), BOX, 0).pixels
    assert np.unique(pixels.reshape(-1, 3), axis=0).tolist() == [
        (255.0 * palette.FLOOR + 0.5).astype(int).tolist()
    ]


def pixel(number, x, y, typical=50.0):
    """The colour of a cell with so many agents, whose headings add up to (x, y)."""
    pixels = np.zeros((1, 1, 3), np.uint8)
    sums = np.array([[[number, x, y]]], np.float32)
    fill_pixels(sums, typical, palette.density_table(), pixels)
    return pixels[0, 0].tolist()


@pytest.mark.parametrize("hue", range(0, 90, 7))
def test_a_cell_has_the_colour_of_the_table(hue):
    table = palette.density_table()
    strengths, orders, hues, _ = table.shape
    angle = 2.0 * np.pi * hue / hues
    way = 50.0 * np.array([np.cos(angle), np.sin(angle)])
    half, last = int(0.5 * (strengths - 1) + 0.5), orders - 1
    assert pixel(50.0, *way) == table[half, last, hue].tolist()
    assert (
        pixel(150.0, *(3.0 * way)) == table[int(0.75 * (strengths - 1) + 0.5), last, hue].tolist()
    )
    assert pixel(1e9, *(2e7 * way)) == table[-1, last, hue].tolist()
    assert pixel(50.0, 0.0, 0.0) == table[half, 0, 0].tolist()
    assert pixel(0.0, 0.0, 0.0) == (255.0 * palette.FLOOR + 0.5).astype(int).tolist()


@pytest.mark.parametrize("turn", range(0, 360, 45))
def test_the_hue_is_that_of_the_wheel_of_headings(turn):
    way = np.array([np.cos(np.deg2rad(turn)), np.sin(np.deg2rad(turn))])
    made, wheel = pixel(50.0, *(50.0 * way)), palette.heading_colours(way[None])[0]
    assert np.argmax(made) == np.argmax(wheel)
    assert np.argmin(made) == np.argmin(wheel)
    assert distance(np.median(crowd(way).reshape(-1, 3), axis=0), made) <= 12


def test_who_go_against_each_other_are_grey():
    pixels = crowd(EAST, -EAST).reshape(-1, 3).astype(int)
    assert np.ptp(pixels, axis=1).max() <= 8
    assert pixels.mean() < 220  # and not the floor


def test_random_headings_are_grey_though_the_mean_of_few_is_long():
    rng = np.random.default_rng(2)
    angle, position = (
        rng.uniform(-np.pi, np.pi, 50_000),
        rng.uniform(BOX.low, BOX.high, (50_000, 2)),
    )
    heading = np.column_stack([np.cos(angle), np.sin(angle)])
    pixels = density_picture(position, heading, BOX, 50_000).pixels.reshape(-1, 3).astype(int)
    alike = density_picture(position, np.tile(EAST, (50_000, 1)), BOX, 50_000).pixels
    spread = np.ptp(alike.reshape(-1, 3).astype(int), axis=1)
    assert np.ptp(pixels, axis=1).mean() < 0.25 * spread.mean()


def test_denser_is_darker_and_the_typical_density_is_half_way():
    rng = np.random.default_rng(3)
    left = rng.uniform((0.0, 0.0), (4.0, 4.0), (40_000, 2))
    right = rng.uniform((4.0, 0.0), (8.0, 4.0), (10_000, 2))
    position = np.concatenate([left, right])
    made = density_picture(position, np.tile(EAST, (50_000, 1)), BOX, 50_000)
    half = made.pixels.shape[1] // 2
    assert made.pixels[:, : half - 5].mean() < made.pixels[:, half + 5 :].mean() < 250
    # On average an agent has around it (40^2 + 10^2) / 50 thousand agents to each 16 of area.
    assert made.typical == pytest.approx(34_000 / 16.0, rel=0.1)


def test_the_first_row_is_the_lowest_and_the_first_column_the_leftmost():
    position = np.random.default_rng(4).uniform((0.0, 0.0), (2.0, 1.0), (5_000, 2))
    pixels = density_picture(position, np.tile(NORTH, (5_000, 1)), BOX, 5_000).pixels
    tall, wide, _ = pixels.shape
    corners = pixels[: tall // 6, : wide // 6], pixels[-(tall // 6) :, : wide // 6]
    assert corners[0].mean() < 200 < corners[1].mean()


# Which flocks are drawn so, and from where.


def test_more_agents_than_the_limit_are_density(monkeypatch):
    monkeypatch.setattr(drawing_style, "DENSITY_BEYOND", 50)
    assert not shows_density(many(50))
    assert shows_density(many(51))


class NodeScene:
    """Stands for a scene: its nodes take what they are given."""

    def __getattr__(self, name):
        return lambda *_, **known: SimpleNamespace(**known)


def test_of_density_no_points_are_drawn_but_the_agents_that_matter(monkeypatch):
    count = POINTS_BEYOND + 1
    informed = np.zeros(count, bool)
    informed[7] = True
    made = shown(many(count, informed=informed))
    agents = Agents(NodeScene(), "", FlockMotion())
    assert visible(agents, made) == {"_points": True, "_darts": True}
    monkeypatch.setattr(drawing_style, "DENSITY_BEYOND", count - 1)
    dense = shown(made.frame)
    assert visible(agents, dense) == {"_points": False, "_darts": True}
    assert {"at", "colour", "wxyz"}.isdisjoint(vars(shown(replace(made.frame, informed=~informed))))


def shown(frame, look=None):
    return picture(frame, look or DrawingStyle(), Stage.of(frame))


def visible(agents, made):
    for handle, name, value in agents.draw(made):
        setattr(handle, name, value)
    return {name: getattr(agents, name).visible for name in ("_points", "_darts")}


@pytest.mark.parametrize(
    "look", [DrawingStyle(), DrawingStyle(colour="measured", measured="x"), DrawingStyle("group")]
)
def test_some_agents_alone_look_as_they_do_among_all(look):
    rng = np.random.default_rng(5)
    frame = many(40, measured=rng.normal(size=40), group=rng.integers(0, 5, 40))
    rows = np.array([3, 17, 39])
    whole = shown(frame, look)
    some = whole.of_rows(rows)
    assert some.length == whole.length
    assert some.at.tolist() == whole.at[rows].tolist()
    assert some.colour.tolist() == whole.colour[rows].tolist()
    assert some.frame.ids.tolist() == frame.ids[rows].tolist()


def test_a_picture_of_density_takes_no_more_of_a_line_for_more_agents(monkeypatch):
    monkeypatch.setattr(drawing_style, "DENSITY_BEYOND", 50)
    few, more = (load(many(count), DrawingStyle()) for count in (51, 5_000))
    assert few == more
    drawing = Drawing(None, None, lambda: 1, None, None, rates=Rates(fastest=1 / 40))
    drawing.drawn = many(51), DrawingStyle()
    assert drawing.period() == DENSITY_PERIOD


def camera(position, target, up=(0.0, 1.0, 0.0), fov=0.6, wide=800, tall=400):
    return SimpleNamespace(
        position=np.array(position), look_at=np.array(target), fov=fov, image_width=wide,
        image_height=tall, up_direction=np.array(up),
    )  # fmt: skip


def test_from_straight_above_what_is_in_sight_is_exact():
    made = shown(many(5))
    seen = region_in_sight(camera((1.0, 2.0, 10.0), (1.0, 2.0, 0.0)), made, np.zeros(3))
    half = 10.0 * np.tan(0.3) / made.stage.scale
    middle = made.stage.world(np.array([1.0, 2.0, 0.0]))
    assert seen.low == pytest.approx(middle - half * np.array([2.0, 1.0]))
    assert seen.high == pytest.approx(middle + half * np.array([2.0, 1.0]))
    aside = np.array([7.0, 0.0, 0.0])
    beside = region_in_sight(camera((8.0, 2.0, 10.0), (8.0, 2.0, 0.0)), made, aside)
    assert beside.low == pytest.approx(seen.low)


def test_towards_the_horizon_all_that_lies_ahead_is_in_sight():
    made = shown(many(5))
    seen = region_in_sight(
        camera((0.0, -90.0, 0.3), (0.0, 0.0, 0.3), up=(0.0, 0.0, 1.0)), made, np.zeros(3)
    )
    assert seen.contains(flock_region(made.frame))


def test_who_has_flown_out_of_the_box_is_in_the_region_of_the_flock():
    world = World("open", (20.0, 20.0), ("open", "open"))
    made = many(5, world=world)
    made.position[2] = -7.0, 31.0
    region = flock_region(made)
    assert region.low == (-7.0, 0.0)
    assert region.high == pytest.approx((20.0, 31.0))
    assert count_within(made.position, *region.low, *region.high) == 5


@pytest.mark.parametrize(
    "junk",
    [
        {"position": (np.nan, 0.0, 1.0)},
        {"position": (0.0, 0.0, 0.0)},
        {"position": (1e300, 0.0, 1e-300)},
        {"target": (np.inf, 0.0, 0.0)},
        {"up": (0.0, 0.0, 0.0)},
        {"fov": np.pi},
        {"fov": np.nan},
        {"tall": 0},
    ],
)
def test_a_camera_that_is_none_has_nothing_or_something_in_sight(junk):
    made = shown(many(5))
    known = {"position": (0.0, 0.0, 10.0), "target": (0.0, 0.0, 0.0)}
    seen = region_in_sight(camera(**(known | junk)), made, np.zeros(3))
    inside = seen.intersection(flock_region(made.frame))
    assert inside is None or 0.0 < inside.area <= 400.0


def test_a_player_shows_all_of_a_flock_in_the_plane_as_density(monkeypatch):
    monkeypatch.setattr(drawing_style, "DENSITY_BEYOND", 50)
    there = many(400)
    with Player(400) as player:
        player.add(there, DrawingStyle(), 0.0)
        player.add(replace(there, tick=1, heading=-there.heading), DrawingStyle(), 0.1)
        recorded = [message for _, message in player.recorded._messages]
    about = [message for message in recorded if message.get("name") == "/sight0/density"]
    assert [message["type"] for message in about].count("ImageMessage") == 1
    assert sum("_data" in message.get("updates", ()) for message in about) == 1, "the second frame"
    points = [message for message in recorded if message.get("name") == "/flock/points"]
    assert not any(message.get("updates", {}).get("visible") for message in points)


def test_of_very_many_agents_in_space_a_player_shows_some_and_always_the_same(monkeypatch):
    monkeypatch.setattr(drawing_style, "DENSITY_BEYOND", 50)
    monkeypatch.setattr(drawing_style, "SINGLES_UP_TO", 20)
    informed = np.zeros(60, bool)
    informed[7] = True
    there = many(60, dim=3, informed=informed)
    assert one_of(60, 3) == 3
    made = thinned_frame(replace(there, beside=there))
    assert made.ids.tolist() == [1, 4, 7, 8, *range(10, 60, 3)]
    assert made.beside.ids.tolist() == made.ids.tolist()
    assert thinned_frame(many(60)).ids.tolist() == list(range(1, 61))


def test_an_html_file_takes_more_pictures_of_density_than_of_points():
    demand_playable(1_000_000, 2, 400)
    with pytest.raises(InputError, match=r"401 pictures of 1000000 .* 400: .* --every 2,"):
        demand_playable(1_000_000, 2, 401)
    with pytest.raises(InputError, match="which takes 13:"):
        demand_playable(150_000, 2, 14)


@pytest.fixture
def quarter(monkeypatch):
    """A flock that is all in the lower left quarter of its world, and goes north."""
    monkeypatch.setattr(drawing_style, "DENSITY_BEYOND", 50)
    flock = Flock("vem", agents=400, rng=1)
    flock.position[:] %= 0.5 * np.array(flock.world.size)
    flock.heading[:] = NORTH
    return flock


def coloured_share(sheet, x, y):
    """The share of vivid pixels in a quarter of the scene of a sheet, (0, 0) the lower left."""
    box = sheet.scene.axes.get_window_extent()
    left, lower = box.x0 + 0.5 * x * box.width, box.y0 + 0.5 * y * box.height
    rows = slice(int(sheet.size[1] - lower - 0.5 * box.height), int(sheet.size[1] - lower))
    part = sheet.pixels()[rows, int(left) : int(left + 0.5 * box.width)].astype(int)
    return float(np.mean(np.ptp(part, axis=2) > 40))


def test_pictures_and_films_are_of_density_too(quarter):
    now = quarter.snapshot(signals=True)
    sheet = Sheet(shot(now, look_of(now, None)), (640, 480))
    assert not len(sheet.scene.bodies.get_paths())
    assert "faint: sparse; grey: not aligned" in [
        text.get_text() for text in sheet.figure.legends[0].get_texts()
    ]
    assert coloured_share(sheet, 0, 0) > 0.6
    assert coloured_share(sheet, 1, 1) < 0.05
    quarter.position[:] += 0.5 * np.array(quarter.world.size)
    later = quarter.snapshot(signals=True)
    sheet.show(shot(later, look_of(later, None)))
    assert coloured_share(sheet, 0, 0) < 0.05
    assert coloured_share(sheet, 1, 1) > 0.6


def test_a_browser_that_draws_pictures_refuses_density(quarter):
    now = quarter.snapshot(signals=True)
    one = shot(now, look_of(now, None))
    with pytest.raises(InputError, match="400 agents are drawn as a picture"):
        seen_picture(one, None, (640, 480), Camera.of(one))


# A large flock is measured aside.


def test_a_large_flock_is_measured_aside_also_while_it_stands(monkeypatch):
    monkeypatch.setattr(flock_readings, "MEASURED_ASIDE", 4)
    flock = StubFlock(preset_spec(agents=5))
    readings = FlockReadings(flock)
    readings.read(at_once=True)
    assert "polarisation" not in readings.values
    until(lambda: readings.is_found)
    readings.read(at_once=True)
    assert readings.values["polarisation"] == 1.0
    assert readings.aside.idle, "what was measured at this tick is not measured again"
    assert readings.series("polarisation").arrays()[1].tolist() == [1.0]


# Browsers, without a screen.


class DensityBrowser(StandIn):
    """Keeps the files of the images that it is sent, and what is drawn one by one."""

    def __init__(self, port):
        self.image, self.singles = None, None
        super().__init__(port)

    def hear(self, message):
        super().hear(message)
        name, changes = (
            message.get("name", ""),
            message.get("updates") or message.get("props") or {},
        )
        if name == "/sight0/density" and "_data" in changes:
            self.image = changes["_data"]
        if name == "/sight0/flock/darts":
            self.singles = changes.get("visible", self.singles)

    def look_at(self, x, y, height):
        self.say(**CAMERA | {"position": [x, y, height], "look_at": [x, y, 0.0]})


@pytest.fixture
def laboratory(monkeypatch):
    monkeypatch.setattr(drawing_style, "DENSITY_BEYOND", 500)
    monkeypatch.setattr(drawing_style, "SINGLES_UP_TO", 100)
    monkeypatch.setattr(flock_readings, "MEASURED_ASIDE", 500)
    made = Laboratory(preset_spec("vem", agents=2_000, seed=2), port=0, running=False)
    assert made.simulation.ready.wait(COMPILED)
    yield made
    made.close()


def sight(laboratory):
    """What the one browser has in sight."""
    for client in laboratory.server.get_clients().values():
        for flock in laboratory.scene.in_sight(client):
            return flock
    return None


def test_a_browser_sees_density_and_from_near_single_agents_and_leaves_nothing(laboratory):
    gone = look_from_far_and_near(laboratory)
    until(lambda: not laboratory.server.get_clients())
    until(lambda: not laboratory.scene._density._views and not laboratory.sight_lines.lines)
    until(lambda: gc.collect() >= 0 and gone() is None, 60, "the browser's flock to be forgotten")


def look_from_far_and_near(laboratory):
    """Have a browser do so; a reference to what it saw."""
    with DensityBrowser(laboratory.port) as browser:
        until(lambda: browser.image is not None, COMPILED)
        assert browser.nodes["/sight0/density"] == "ImageMessage"
        until(lambda: sight(laboratory).count == 2_000)

        def words() -> str:
            shown = [one for one in tuple(browser.controls.values()) if one.get("visible")]
            return " ".join(str(one.get("content")) for one in shown)

        until(lambda: "Density of 2\u202f000 agents in sight" in words())
        until(lambda: "polarisation" in laboratory.simulation.readings.values)

        browser.look_at(1.0, 1.0, 3.0)
        until(lambda: sight(laboratory).as_singles)
        flock = sight(laboratory)
        until(lambda: flock.agents is not None and flock.agents._darts.visible)
        drawn = len(flock.agents._darts.batched_positions)
        assert 0 < flock.count <= 100
        assert flock.count <= drawn <= 2 * flock.count, "only those in sight are sent"
        until(lambda: not flock.image.visible)
        until(lambda: f"{flock.count} agents in sight, drawn one by one" in words())

        browser.look_at(0.0, 0.0, 40.0)
        until(lambda: not sight(laboratory).as_singles and sight(laboratory).image.visible)
        until(lambda: not flock.agents._darts.visible)
        return weakref.ref(flock)


def test_single_agents_stay_until_clearly_too_many_are_in_sight(laboratory):
    with DensityBrowser(laboratory.port) as browser:
        until(lambda: browser.image is not None, COMPILED)
        browser.look_at(0.0, 0.0, 3.0)
        until(lambda: sight(laboratory).as_singles)
        count = sight(laboratory).count
        drawing_style.SINGLES_UP_TO = int(count / KEEPS) + 1
        browser.look_at(0.0, 0.0, 3.0)
        laboratory.simulation.step()
        until(lambda: laboratory.drawing.drawn[0].tick == 1)
        assert sight(laboratory).as_singles
        drawing_style.SINGLES_UP_TO = count // 2
        laboratory.simulation.step()
        until(lambda: not sight(laboratory).as_singles)


def test_browsers_that_look_from_where_they_were_put_share_a_file(laboratory):
    with DensityBrowser(laboratory.port) as first, DensityBrowser(laboratory.port) as second:
        until(lambda: first.image is not None and second.image is not None, COMPILED)
        laboratory.simulation.step()
        until(lambda: laboratory.drawing.drawn[0].tick == 1)
        until(lambda: len(laboratory.scene._density._dense.plane[0].files) == 1)
        views = laboratory.scene._density._views.values()
        files = [flock.image._data for view in views for flock in view.flocks]
        until(lambda: len(files) == 2 and files[0] is files[1])


def test_a_flock_that_is_set_up_small_is_drawn_agent_by_agent_again(laboratory):
    with DensityBrowser(laboratory.port) as browser:
        until(lambda: browser.image is not None, COMPILED)
        laboratory.simulation.setup(preset_spec("vem", agents=30, seed=2))
        until(lambda: sight(laboratory) is None)
        client = next(iter(laboratory.server.get_clients().values()))
        assert describe_sight(laboratory.scene.in_sight(client)) == ""
        until(lambda: laboratory.drawing.drawn[0].ids.size == 30)


def test_two_flocks_beside_each_other_are_two_pictures(laboratory):
    with DensityBrowser(laboratory.port) as browser:
        until(lambda: browser.image is not None, COMPILED)
        spec = preset_spec("vem", agents=600, seed=2)
        laboratory.simulation.setup(spec, Spec("hwvem"))
        until(lambda: "/sight1/density" in browser.nodes)
        client = next(iter(laboratory.server.get_clients().values()))
        until(lambda: [one.count for one in laboratory.scene.in_sight(client)] == [600, 600])
        first, second = laboratory.scene.in_sight(client)
        assert first.node.position.tolist() == [0.0, 0.0, 0.0]
        assert second.node.position.tolist() == laboratory.scene._sights[1].aside.tolist()
        laboratory.simulation.setup(spec)
        until(lambda: len(laboratory.scene.in_sight(client)) == 1)


def test_an_image_is_a_jpeg_of_the_region(laboratory):
    with DensityBrowser(laboratory.port):
        until(lambda: sight(laboratory) and sight(laboratory).image)
        flock = sight(laboratory)
        image = Image.open(io.BytesIO(flock.image._data))
        assert image.format == "JPEG"
        wide, deep = flock.region.sides
        assert image.width / image.height == pytest.approx(wide / deep, rel=0.05)
        assert flock.image.scale[:2] == pytest.approx((10.0, 10.0), rel=0.01)
