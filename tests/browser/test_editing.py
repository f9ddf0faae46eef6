"""Building the world in a browser while the flock flies."""

from __future__ import annotations

import tomllib

import ezdxf
import numpy as np
import pytest
from ezdxf import units

from app.viewer.run.run_preset import preset_spec
from tests.browser.window import Window
from tests.viewer.waiting import until
from worlds.layout import world_from_layout

START = preset_spec("hwvem-nav", world="obstacles")


class Builder:
    """A person at the World tab."""

    def __init__(self, window: Window, laboratory):
        self.window, self.page = window, window.page
        self.laboratory, self.simulation = laboratory, laboratory.simulation

    @property
    def obstacles(self) -> list:
        return list(self.simulation.edits.editor.world.obstacles)

    def choose(self, label: str, option: str) -> None:
        """Choose from a list."""
        self.page.get_by_label(label, exact=True).click()
        self.page.get_by_role("option", name=option, exact=True).click()
        until(lambda: self.page.get_by_role("option").count() == 0)

    def at(self, x: float, y: float, height: float = 0.0) -> tuple[float, float]:
        """Where on the page a place in the world is, seen from above."""
        until(lambda: self.camera() is not None, 20, "the browser to tell the size of its picture")
        camera = self.camera()
        stage = self.laboratory.scene._sights[0].picture.stage
        place = stage.place_on_display(np.array([x, y, height]))
        ahead = camera.look_at - camera.position
        away = place - camera.position - ahead * (place[2] - camera.position[2]) / ahead[2]
        half = np.tan(0.5 * camera.fov) * (camera.position[2] - place[2])
        left, top, width, tall = self.box
        pixels = 0.5 * tall / half
        return left + 0.5 * width + pixels * away[0], top + 0.5 * tall - pixels * away[1]

    def camera(self):
        """The camera of this page; None until the server has heard of its latest size."""
        clients = list(self.laboratory.server.get_clients().values())
        width = self.box[2]
        return next((c.camera for c in clients if abs(c.camera.image_width - width) < 3), None)

    @property
    def box(self) -> list[float]:
        """Left, top, width and height of the picture on the page."""
        return self.page.evaluate(
            """() => { const boxes = [...document.querySelectorAll('canvas')].map(
                canvas => canvas.getBoundingClientRect());
            const box = boxes.reduce((a, b) => b.width * b.height > a.width * a.height ? b : a);
            return [box.left, box.top, box.width, box.height]; }"""
        )

    def click(self, x: float, y: float) -> None:
        """Click on the floor."""
        self.page.mouse.click(*self.at(x, y))

    def drag(self, start: tuple[float, float], by: tuple[float, float]) -> None:
        """Drag with the mouse, pixels, no faster than the page draws."""
        mouse = self.page.mouse
        mouse.move(*start)
        self.drawn(2)
        mouse.down()
        for step in np.linspace(0.0, 1.0, 12)[1:]:
            mouse.move(start[0] + step * by[0], start[1] + step * by[1])
            self.drawn()
        mouse.up()

    def drawn(self, times: int = 1) -> None:
        """Wait until the page has drawn its picture some times more."""
        self.page.evaluate(
            """times => new Promise(done => {
                const next = () => times-- > 0 ? requestAnimationFrame(next) : done();
                next(); })""",
            times,
        )


@pytest.fixture
def builder(window, laboratory):
    """A running flock among obstacles, seen from above, and the World tab."""
    simulation = laboratory.simulation
    before = simulation.state.run
    simulation.setup(START)
    until(lambda: simulation.state.run > before, 60)
    until(lambda: laboratory.scene._sights[0].picture.frame.world.name == "obstacles", 60)
    simulation.go().result(60)
    until(lambda: simulation.frame.tick > 2, 120, "a first tick")
    window.tab("World")
    window.page.wait_for_timeout(800)
    window.close_notices()
    yield Builder(window, laboratory)
    laboratory.world.drop_tool()
    laboratory.world.select(0)
    window.tab("Rule")


def test_a_disc_is_placed_dragged_deleted_and_all_of_it_undone(builder):
    before = builder.obstacles
    run = builder.simulation.state.run
    builder.choose("A click to", "place a disc")
    builder.click(44.0, 20.0)
    until(lambda: len(builder.obstacles) == len(before) + 1)
    disc = builder.obstacles[-1]
    assert disc.centre == pytest.approx((44.0, 20.0), abs=0.2)
    until(lambda: builder.simulation.frame.world.obstacles[-1] == disc)

    builder.choose("A click to", "select")
    builder.click(44.5, 19.0)
    until(lambda: builder.laboratory.world.obstacle == disc)
    builder.page.get_by_text("Drag it by its handles").wait_for()
    builder.page.wait_for_timeout(600)
    builder.drawn(10)
    x, y = builder.at(44.0, 20.0)
    builder.drag((x + 20, y - 20), (60.0, -40.0))
    until(lambda: builder.obstacles[-1] != disc)
    builder.page.wait_for_timeout(500)
    moved = np.subtract(builder.obstacles[-1].centre, disc.centre)
    assert moved[0] > 2.0
    assert moved[1] > 1.0
    assert len(builder.simulation.edits.editor.past) == 2

    builder.window.press("Delete")
    until(lambda: builder.obstacles == before)
    builder.window.press("Undo")
    until(lambda: len(builder.obstacles) == len(before) + 1)
    builder.window.press("Undo")
    until(lambda: builder.obstacles[-1] == disc)
    builder.page.keyboard.press("z")
    until(lambda: builder.obstacles == before)
    builder.window.press("Redo")
    until(lambda: builder.obstacles[-1] == disc)
    tick = builder.simulation.frame.tick
    until(lambda: builder.simulation.frame.tick > tick)
    assert builder.simulation.state.run == run
    assert not builder.simulation.state.error


def test_a_polygon_is_drawn_corner_by_corner_and_one_that_crosses_itself_is_refused(builder):
    before = builder.obstacles
    builder.choose("A click to", "draw a polygon")
    corners = [(17.0, 2.0), (22.0, 2.0), (22.0, 4.5)]
    for number, corner in enumerate(corners, 1):
        builder.click(*corner)
        until(lambda number=number: len(builder.laboratory.world.corners) == number)
    builder.click(*corners[-1])
    until(lambda: len(builder.obstacles) == len(before) + 1)
    np.testing.assert_allclose(builder.obstacles[-1].points, corners, atol=0.2)

    for corner in [(3.0, 12.0), (6.0, 15.0), (6.0, 12.0), (3.0, 15.0)]:
        count = len(builder.laboratory.world.corners)
        builder.click(*corner)
        until(lambda count=count: len(builder.laboratory.world.corners) == count + 1)
    builder.window.press("Close")
    builder.page.get_by_text("crosses itself").first.wait_for()
    assert len(builder.obstacles) == len(before) + 1


def test_a_layout_is_saved_and_opened_in_two_browsers(builder, chromium, tmp_path):
    other = Window(chromium.new_page(viewport={"width": 1100, "height": 600}), builder.laboratory)
    other.tab("World")
    builder.choose("A click to", "place a box")
    builder.click(44.0, 20.0)
    until(lambda: builder.obstacles[-1].shape == "box")
    other.page.get_by_text("13 obstacles · 1 change").wait_for()
    world = builder.simulation.edits.editor.world
    with builder.page.expect_download() as download:
        builder.window.press("Save layout (TOML)")
    file = tmp_path / "mine.toml"
    download.value.save_as(file)
    assert world_from_layout(tomllib.loads(file.read_text()), world.name) == world

    other.press("Undo")
    until(lambda: len(builder.obstacles) == 12)
    with builder.page.expect_file_chooser() as chooser:
        builder.window.press("Open layout ...")
    run = builder.simulation.state.run
    chooser.value.set_files(file)
    until(lambda: builder.simulation.state.run > run, 60)
    assert builder.simulation.run.flock.world.obstacles == world.obstacles
    assert builder.simulation.run.flock.world.name == "mine"

    broken = tmp_path / "broken.wkt"
    broken.write_text("POLYGON ((0 0, 1")
    run = builder.simulation.state.run
    with other.page.expect_file_chooser() as chooser:
        other.press("Open layout ...")
    chooser.value.set_files(broken)
    builder.page.get_by_text("broken.wkt").first.wait_for()
    assert builder.simulation.state.run == run
    other.page.close()


def opened_plan(window, path) -> None:
    """Choose a file after Open layout, and wait for what the page asks about it."""
    with window.page.expect_file_chooser() as chooser:
        window.press("Open layout ...")
    chooser.value.set_files(path)
    window.page.get_by_text("What does this drawing mean?").wait_for()


def test_a_drawing_that_may_mean_two_things_is_asked_about(builder, chromium, tmp_path):
    plan = tmp_path / "plan.dxf"
    document = ezdxf.new(units=units.M)
    corners = [(1, 1), (21, 1), (21, 11), (1, 11)]
    document.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": "WALLS"})
    document.saveas(plan)
    other = Window(chromium.new_page(viewport={"width": 1100, "height": 600}), builder.laboratory)
    run = builder.simulation.state.run
    opened_plan(builder.window, plan)
    assert other.page.get_by_text("What does this drawing mean?").count() == 0
    builder.page.get_by_text("would be a solid block of 20 x 10 m").wait_for()
    builder.window.press("Cancel")
    builder.page.get_by_text("What does this drawing mean?").wait_for(state="detached")
    assert builder.simulation.state.run == run
    opened_plan(builder.window, plan)
    builder.page.get_by_label("Thickness of walls, m").fill("0.5")
    builder.window.press("Walls")
    until(lambda: builder.simulation.state.run > run, 60)
    walls = builder.simulation.run.flock.world.obstacles
    area = sum(one.footprint().area for one in walls)
    assert area == pytest.approx(0.5 * 60.0, rel=0.05), "walls of 0.5 m along 60 m"
    other.page.close()
