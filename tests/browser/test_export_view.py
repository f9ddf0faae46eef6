"""The picture of a flock's page: who is picked, trails, colours, keys, and how it stands."""

from __future__ import annotations

import gzip
import re

import numpy as np
import pytest

from agents.flock import Flock
from agents.observables.neighbours import links, nearest_of, separation
from app.viewer.lab.flock_page import PageWords, flock_page
from app.viewer.scene.shown import palette
from tests.browser.accessibility import find_violations_in_both_themes
from tests.viewer.waiting import until

FLY = "async (ticks) => { for (let k = 0; k < ticks; k++) await page.ask({ ticks: 1 }); }"
NO_WEBGL = """
const before = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
  return kind === "webgl2" ? null : before.call(this, kind, ...rest);
};
"""
SEGMENTS = """() => {
  const { gl, trail } = page.view, found = new Float32Array(6 * trail.lines * 60);
  gl.bindBuffer(gl.ARRAY_BUFFER, trail.places);
  gl.getBufferSubData(gl.ARRAY_BUFFER, 0, found);
  return [...found];
}"""
DRAWN = """() => {
  page.view.changed();
  const { gl, canvas } = page.view, bytes = new Uint8Array(4 * canvas.width * canvas.height);
  gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  return bytes.filter((one, k) => k % 4 === 3 && one).length;
}"""
INKS = """() => {
  const { view } = page, before = view.drawLit;
  let found;
  view.drawLit = (headings, inks) => { found = [...inks]; };
  view.changed();
  view.drawLit = before;
  return found;
}"""


def pixel_of(page, agent: int) -> tuple[float, float]:
    """Where an agent is drawn in the window."""
    return tuple(
        page.evaluate(
            """(id) => {
              const { view } = page, box = view.canvas.getBoundingClientRect();
              const [x, y] = view.project(...view.placeOf(view.ids.indexOf(BigInt(id))));
              return [box.x + x / view.scale, box.y + y / view.scale];
            }""",
            agent,
        )
    )


def words(page) -> str:
    """What is said of the picked agent."""
    return page.locator("#picked").text_content()


def fly(page, ticks: int) -> None:
    """Draw every tick of so many."""
    page.evaluate(FLY, ticks)


def expected_words(flock: Flock, agent: int) -> str:
    """What a page should say of an agent in the plane."""
    row = flock.ids.tolist().index(agent)
    ux, uy = flock.heading[row]
    heading = round(np.degrees(np.arctan2(uy, ux)) % 360.0) % 360
    pairs = links(flock.position, flock.reach, flock.world.size, flock.world.images)
    count = int(np.count_nonzero(pairs == row))
    noun = "neighbour" if count == 1 else "neighbours"
    return f"Agent {agent}: heading {heading}°, speed {flock.speed[row]:.3g}, {count} {noun}"


def test_a_click_picks_an_agent_that_stays_picked_while_it_flies(opened):
    flock = Flock("vem", agents=30, rng=3, eta=0.5)
    with opened(Flock("vem", agents=30, rng=3, eta=0.5)) as page:
        page.mouse.click(*pixel_of(page, 17))
        assert words(page) == expected_words(flock, 17)
        assert page.locator("#picked").get_attribute("role") == "status"
        flock.run(40)
        fly(page, 40)
        assert words(page) == expected_words(flock, 17)
        assert page.locator("#picked").get_attribute("aria-live") == "off"
        page.keyboard.press("Escape")
        assert words(page) == ""


def test_a_click_on_nothing_ends_it_and_a_drag_does_not(opened):
    with opened(Flock("vem", agents=1, rng=3)) as page:
        x, y = pixel_of(page, 1)
        page.mouse.click(x, y)
        assert words(page).startswith("Agent 1:")
        page.mouse.down()
        page.mouse.move(x + 60, y + 30, steps=3)
        page.mouse.up()
        assert words(page).startswith("Agent 1:")
        assert pixel_of(page, 1) == pytest.approx((x + 60, y + 30), abs=8)
        page.mouse.click(x + 60, y - 60)
        assert words(page) == ""


def test_a_finger_picks_too(opened):
    with opened(Flock("couzin", agents=20, rng=3), has_touch=True) as page:
        page.touchscreen.tap(*pixel_of(page, 7))
        until(lambda: words(page), 60, "the words")
        pattern = r"Agent \d+: heading \d+°, climb −?\d+°, speed 3, \d+ neighbours?"
        assert re.fullmatch(pattern, words(page))


@pytest.mark.parametrize("case", ["within reach", "the nearest", "among obstacles"])
def test_neighbours_are_those_of_the_rule(opened, case):
    model, options = {
        "within reach": ("vem", {"agents": 40}),
        "the nearest": ("vem", {"agents": 40, "neighbours": "nearest"}),
        "among obstacles": ("hwvem-nav", {}),
    }[case]
    flock = Flock(model, rng=3, **options)
    offset = [
        separation(place, flock.position, flock.world.size, flock.world.images)
        for place in flock.position
    ]
    if flock.nearest:
        counts = [len(nearest_of(one, flock.nearest)) for one in offset]
    else:
        far = np.linalg.norm(offset, axis=-1)
        counts = np.count_nonzero((far > 0.0) & (far <= flock.reach), axis=1).tolist()
    with opened(flock) as page:
        said = page.evaluate(
            """(ids) => ids.map((id) => {
              page.view.picked = BigInt(id);
              page.view.changed();
              return document.getElementById("picked").textContent;
            })""",
            flock.ids.tolist(),
        )
    assert [int(re.search(r"(\d+) neighbour", one)[1]) for one in said] == counts


def test_trails_are_drawn_broken_at_the_edge_and_cleared(opened):
    with opened(Flock("vem", agents=60, rng=3)) as page:
        fly(page, 30)
        before = page.evaluate(DRAWN)
        page.click("#trails")
        fly(page, 80)
        assert page.evaluate(DRAWN) > 1.3 * before
        ends = np.array(page.evaluate(SEGMENTS)).reshape(-1, 2, 3)
        lengths = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
        assert lengths.max() == pytest.approx(0.03, abs=1e-4)
        crossed = np.count_nonzero(lengths == 0.0)
        assert 0 < crossed < len(lengths) / 4
        page.click("#reset")
        until(lambda: page.evaluate("page.state.tick") == 0, 60, "the start")
        ends = np.array(page.evaluate(SEGMENTS)).reshape(-1, 2, 3)
        assert np.array_equal(ends[:, 0], ends[:, 1])
        page.click("#trails")
        assert page.evaluate("page.view.trail") is None


def test_many_agents_have_trails_only_in_part_and_the_page_says_so(opened):
    with opened(Flock("vem", agents=2001, rng=3)) as page:
        page.click("#trails")
        assert page.evaluate("page.view.trail.lines") == 2000
        assert page.locator("#trailed").inner_text() == "Of the first 2\u2009000 agents."


@pytest.mark.parametrize("model", ["vem", "couzin", "hwvem-nav"])
def test_colours_are_those_of_the_laboratory(opened, model):
    flock = Flock(model, rng=3)
    flock.run(20)
    with opened(Flock(model, rng=3)) as page:
        page.evaluate("page.ask({ ticks: 20 })")
        order = [int(one) for one in page.evaluate("[...page.state.ids].map(String)")]
        rows = [flock.ids.tolist().index(one) for one in order]
        offered = page.locator("#colour option").all_inner_texts()
        expected = {
            "heading": palette.heading_colours(flock.heading),
            "speed": palette.number_colours(flock.speed),
            "group": palette.group_colours(flock.group_labels()),
            "layer": palette.layer_colours(flock.layers()),
            "role": np.where(flock.informed[:, None], palette.LEADER, palette.PLAIN),
        }
        led = ["layer", "role"] if flock.informed.any() else []
        assert offered == ["heading", "speed", "group", *led]
        for colour in offered:
            page.select_option("#colour", colour)
            page.evaluate("page.ask({})")
            inks = np.array(page.evaluate(INKS)).reshape(-1, 4)[:, :3]
            # A page has every tenth hue of the laboratory's, and blends what lies between.
            worn = np.where(flock.informed[:, None], palette.LEADER, expected[colour])
            apart = np.abs(inks - 255.0 * worn[rows])
            assert apart.max() < 16.0
            assert apart.mean() < 2.0
            label = page.locator("#picture").get_attribute("aria-label")
            tick = page.evaluate("page.state.tick")
            assert label == f"{len(order)} agents, coloured by {colour}, tick {tick}"


def test_the_legend_says_what_colours_mean(opened):
    with opened(Flock("hwvem-nav", rng=3)) as page:
        assert page.locator("#legend .wheel").count() == 1
        assert find_violations_in_both_themes(page) == []
        page.select_option("#colour", "role")
        assert page.locator("#legend").inner_text().split("\n") == ["other", "information agent"]
        page.evaluate("page.ask({ ticks: 20 })")
        page.select_option("#colour", "speed")
        speed = page.evaluate("[...page.state.speed]")
        assert page.locator("#legend .ramp").count() == 1
        *ends, leader = page.locator("#legend").inner_text().split("\n")
        assert leader == "information agent"
        ends = [float(one) for one in ends]
        assert ends == pytest.approx([min(speed), max(speed)], rel=5e-3)
        page.evaluate("page.state.crashed[5] = 1; page.view.changed()")
        assert page.locator("#legend").inner_text().split()[-1] == "crashed"


@pytest.mark.parametrize(("asked", "shown"), [("layer", "layer"), ("saving", "heading")])
def test_a_page_begins_with_the_colours_of_its_scene(chromium, tmp_path, asked, shown):
    """Where it has them."""
    file = tmp_path / "flock.html"
    words = PageWords(colour=asked)
    file.write_text(flock_page(Flock("hwvem", agents=30, rng=3), words), encoding="utf-8")
    page = chromium.new_page()
    try:
        page.goto(file.as_uri())
        until(lambda: page.evaluate("'page' in globalThis"), 60, "the flock to be there")
        assert page.evaluate("document.getElementById('colour').value") == shown
        assert (page.evaluate("page.state.labels") is None) == (shown == "heading")
    finally:
        page.close()


def test_letters_of_a_symbol_stand_above_and_below(opened):
    with opened(Flock("hwvem-nav", rng=3)) as page:
        assert "align" in page.locator(".slider sup").all_inner_texts()
        assert "avoid" in page.locator(".slider sub").all_inner_texts()


def test_groups_are_coloured_while_the_flock_goes_on(opened):
    """The labels come with the answers, only where they are shown."""
    flock = Flock("vem", rng=3, eta=0.5)
    with opened(Flock("vem", rng=3, eta=0.5)) as page:
        assert page.evaluate("page.state.labels") is None
        page.select_option("#colour", "group")
        until(lambda: page.evaluate("page.state.colour") == "group", 60, "the groups")
        ends = page.locator("#legend").inner_text().split("\n")
        assert ends == ["largest", "small groups"]
        page.evaluate("page.ask({ ticks: 30, budget: 1e6 })")
        page.evaluate("page.ask({})")
        flock.run(30)
        assert page.evaluate("[...page.state.labels]") == flock.group_labels().tolist()
        page.select_option("#colour", "heading")
        page.evaluate("page.ask({})")
        assert page.evaluate("page.state.labels") is None


def test_agents_are_coloured_by_any_other_number(opened):
    with opened(Flock("vem", agents=30, rng=3)) as page:
        page.evaluate(
            """() => {
              const { view } = page, draw = view.draw.bind(view);
              const number = (id) => (id === 30n ? NaN : Number(id));
              view.draw = (frame, dark) =>
                draw({ ...frame, values: Float64Array.from(frame.ids, number) }, dark);
              view.look.offer("id", "identity");
            }"""
        )
        page.select_option("#colour", "id")
        assert page.locator("#legend").inner_text().split() == ["1", "29"]
        row = page.evaluate("[...page.state.ids].indexOf(30n)")
        unknown = 255.0 * palette.UNKNOWN
        assert page.evaluate(INKS)[4 * row : 4 * row + 3] == pytest.approx(unknown, abs=1.0)


def test_keys_move_the_picture(opened):
    state = "[page.view.centre[0], page.view.centre[1], page.view.zoom]"
    with opened(Flock("vem", agents=30, rng=3)) as page:
        home = page.evaluate(state)
        page.focus("#picture")
        for key in ("ArrowRight", "ArrowUp", "+"):
            page.keyboard.press(key)
        right, up, zoom = page.evaluate(state)
        assert right > home[0]
        assert up > home[1]
        assert zoom > 1.0
        page.keyboard.press("-")
        page.keyboard.press("-")
        assert page.evaluate(state)[2] < 1.0
        page.keyboard.press("0")
        assert page.evaluate(state) == home
        page.keyboard.press("Enter")
        assert words(page).startswith("Agent ")
        page.focus("#colour")
        page.keyboard.press("s")
        assert page.evaluate("page.state.tick") == 0


def test_keys_turn_space(opened):
    with opened(Flock("couzin", agents=20, rng=3)) as page:
        before = page.evaluate("[page.view.yaw, page.view.pitch]")
        page.focus("#picture")
        page.keyboard.press("ArrowLeft")
        page.keyboard.press("ArrowUp")
        yaw, pitch = page.evaluate("[page.view.yaw, page.view.pitch]")
        assert yaw > before[0]
        assert pitch > before[1]


def test_size_and_theme_stand_in_the_address(opened):
    ground = "getComputedStyle(document.body).backgroundColor"
    letters = "getComputedStyle(document.body).fontSize"
    with opened(Flock("vem", agents=5, rng=3)) as page:
        assert page.evaluate(f"[{ground}, {letters}]") == ["rgb(244, 246, 250)", "15px"]
        page.evaluate("location.hash = 'size=L&theme=dark'")
        until(lambda: page.evaluate(ground) == "rgb(17, 21, 28)", 60, "the dark theme")
        assert page.evaluate(letters) == "18px"
        page.evaluate("location.hash = 'size=XL&theme=%3Cb%3E'")
        page.reload()
        until(lambda: page.evaluate("'page' in globalThis"), 60, "the flock to be there")
        assert page.evaluate(f"[{ground}, {letters}]") == ["rgb(244, 246, 250)", "15px"]
        page.click("summary")
        page.select_option("#theme", "dark")
        page.select_option("#size", "S")
        assert page.evaluate("location.hash") == "#size=S&theme=dark"
        assert page.evaluate(f"[{ground}, {letters}]") == ["rgb(17, 21, 28)", "13px"]


def test_auto_follows_the_browser_and_light_does_not(opened):
    ground = "getComputedStyle(document.body).backgroundColor"
    with opened(Flock("vem", agents=5, rng=3), color_scheme="dark") as page:
        assert page.evaluate(f"[{ground}, isDark()]") == ["rgb(17, 21, 28)", True]
        page.click("summary")
        page.select_option("#theme", "light")
        assert page.evaluate(f"[{ground}, isDark()]") == ["rgb(244, 246, 250)", False]


@pytest.mark.parametrize("model", ["couzin", "hwvem-nav"])
def test_without_webgl_it_draws_darts_and_obstacles(opened, model):
    painted = """([x, y]) => {
      const { canvas, flat, scale } = page.view, box = canvas.getBoundingClientRect();
      return flat.getImageData((x - box.x) * scale, (y - box.y) * scale, 1, 1).data[3];
    }"""
    with opened(Flock(model, rng=3), NO_WEBGL) as page:
        assert page.locator("#trails").is_disabled()
        assert "WebGL2" in page.locator("#trailed").inner_text()
        place = pixel_of(page, 5)
        assert page.evaluate(painted, place) > 127, "one that flies away is narrow"
        page.mouse.click(*place)
        assert words(page).startswith("Agent ")
        triangles = page.evaluate("page.manifest.triangles.slice(0, 3)")
        if triangles:
            middle = np.mean(triangles, axis=0).tolist()
            place = page.evaluate(
                """(middle) => {
                  const { view } = page, box = view.canvas.getBoundingClientRect();
                  const [x, y] = view.project(...middle);
                  return [box.x + x / view.scale, box.y + y / view.scale];
                }""",
                middle,
            )
            assert page.evaluate(painted, place) == 255


@pytest.mark.parametrize(("width", "height"), [(320, 640), (390, 844), (844, 390), (1440, 900)])
def test_all_is_in_reach_and_nothing_scrolls_sideways(opened, width, height):
    small = width < 500
    options = {"viewport": {"width": width, "height": height}, "has_touch": small}
    with opened(Flock("couzin", agents=20, rng=3), is_mobile=small, **options) as page:
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        picture, go = page.locator("#stage").bounding_box(), page.locator("#go").bounding_box()
        assert (picture["y"] < go["y"]) == small
        if small:
            assert picture["width"] == pytest.approx(picture["height"], abs=2)
            for name in ("#go", "#colour", "#sliders input >> nth=0", "#save"):
                assert page.locator(name).bounding_box()["height"] >= 44
        page.locator("summary").scroll_into_view_if_needed()
        box = page.locator("#go").bounding_box()
        assert 0 <= box["y"] <= height - box["height"]


def test_cars_are_true_to_scale(opened):
    # The page of a flock of cars compiles for long: here one of darts is told that they are cars.
    with opened(Flock("vem", agents=30, rng=3)) as page:
        drawn = page.evaluate(
            "() => { page.view.draw({ ...page.state, car: [0.5, 0.25] }, false);"
            " return [page.view.length, page.view.slim]; }"
        )
        assert drawn == [0.5, 0.5]
        page.evaluate("page.show()")
        assert page.evaluate("page.view.slim") == 0


def test_a_page_is_small():
    page = flock_page(Flock("vem", rng=3)).encode()
    assert len(page) < 120_000
    assert len(gzip.compress(page)) <= 55_000


PLACES = """() => {
  const { view } = page, { width, height } = view.canvas;
  return [...view.ids.keys()].flatMap((row) => {
    const [x, y] = view.project(...view.placeOf(row));
    return [x / width, y / height];
  });
}"""


@pytest.mark.parametrize("dim", [2, 3])
def test_a_flock_that_flies_out_of_its_world_stays_in_the_picture(opened, dim):
    flock = Flock("vem", agents=20, rng=1, world="open", size=3.0, dim=dim, eta=0.0, v0=0.5, r=5.0)
    with opened(flock) as page:
        home = page.evaluate("[page.view.centre, page.view.zoom]")
        for _ in range(6):
            page.evaluate("page.ask({ ticks: 15 })")
            places = page.evaluate(PLACES)
            assert 0.0 <= min(places) < max(places) <= 1.0
        far = page.evaluate("page.view.centre")
        assert np.linalg.norm(np.subtract(far, home[0])) > 4.0 * 3.0
        page.evaluate("page.view.magnify(2.0)")
        assert page.evaluate("page.view.closer") == 2.0
        page.click("#reset")
        until(lambda: page.evaluate("page.state.tick") == 0, 30, "the start")
        assert page.evaluate("page.view.centre") == pytest.approx(home[0])
        if dim == 2:  # who has shifted the picture looks where he likes
            page.evaluate("page.view.shift(10, 0)")
            before = page.evaluate("page.view.centre")
            page.evaluate("page.ask({ ticks: 90 })")
            assert page.evaluate("page.view.centre") == before
            page.evaluate("page.view.canvas.dispatchEvent(new MouseEvent('dblclick'))")
            assert min(page.evaluate(PLACES)) >= 0.0


def test_a_page_of_a_world_that_closes_has_no_script_that_follows():
    assert "follow(frame)" not in flock_page(Flock("vem", agents=20, rng=1))
