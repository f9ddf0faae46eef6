"""A flock as a page of its own: it runs from a file and gives what it gives here."""

from __future__ import annotations

import base64
import functools
import http.server
import math
import struct
import threading
from types import SimpleNamespace

import numpy as np
import pytest

from agents.flock import Flock
from agents.web.web_program import web_program
from app.viewer.lab.flock_page import FOLDER, PageWords, flock_page, page_files
from tests.viewer.waiting import until
from tests.worlds.test_web_assembly import Running
from worlds.web_assembly import SLOT


def positions(page, ticks: int, shape: tuple[int, int]) -> np.ndarray:
    """Where agents are after so many ticks more."""
    code = f"page.ask({{ticks: {ticks}}}).then((answer) => [...answer.position])"
    return np.array(page.evaluate(code)).reshape(shape)


def moved(page, name: str, value: float) -> None:
    """Move a slider."""
    page.evaluate(
        "([name, value]) => page.set(page.manifest.parameters.find((one) => one.name === name), "
        "value)",
        [name, value],
    )


CASES = {
    "pairs": ("vem", {"agents": 60, "eta": 0.5}, ("eta", 2.0), ("r", 1.5)),
    "of the nearest": ("topological", {"agents": 60, "eta": 0.5}, ("eta", 2.0), ("v0", 0.1)),
    "pairs in space": ("couzin", {"agents": 40}, ("dr_o", 4.0), ("dr_a", 12.0)),
    "among obstacles": ("hwvem-nav", {}, ("eta", 0.3), ("p2", 3.0)),
    "in turn": ("hwvem", {"agents": 40, "activation": "sequential"}, ("eta", 0.3), ("r", 1.2)),
    "late": ("hwvem", {"agents": 40, "delay": 3.0}, ("eta", 0.3), ("p1", 0.5)),
    "in random order": (
        "hwvem",
        {"agents": 40, "activation": "random"},
        ("eta", 0.3),
        ("r", 1.2),
    ),
    "in gusts and a pulse": (
        "boundary-points",
        {"agents": 12, "wind": 0.5, "gusts": 0.4, "pulse": 1.0, "pulse_at": 0.5, "delay": 0.2},
        ("r", 5.0),
        ("c1a", 2.0),
    ),
    "in wind, in space": (
        "couzin",
        {"agents": 12, "wind": 0.5, "wind_up": -0.2, "gusts": 0.3, "wind_heading": 40.0},
        ("dr_o", 4.0),
        ("dr_a", 12.0),
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_a_page_flies_as_here_also_when_sliders_are_moved(opened, case):
    model, words, *changes = CASES[case]
    flock = Flock(model, rng=3, **words)
    with opened(Flock(model, rng=3, **words)) as page:
        for name, value in changes:
            flock.run(20)
            there = positions(page, 20, flock.position.shape)
            assert there == pytest.approx(flock.position, abs=1e-9)
            flock.set(**{name: value})
            moved(page, name, value)
        flock.run(20)
        assert positions(page, 20, flock.position.shape) == pytest.approx(flock.position, abs=1e-9)
        agents = flock.options.agents + 3
        spec = flock.spec.but(agents=agents, seed=11, world=flock.world, size=None, layout=None)
        anew = Flock(spec.but(parameters=flock.parameters.model_dump()))
        page.evaluate("(agents) => page.beginAnew(String(agents), '11')", agents)
        for ticks in (0, 20):
            anew.run(ticks)
            there = positions(page, ticks, anew.position.shape)
            assert there == pytest.approx(anew.position, abs=1e-9)


def test_it_begins_again_with_the_sliders_as_they_are(opened):
    with opened(Flock("vem", agents=30, rng=3)) as page:
        start = positions(page, 0, (30, 2))
        moved(page, "eta", 3.0)
        page.click("#step")
        until(lambda: page.locator("#tick").inner_text() == "1", 60, "a tick")
        page.click("#reset")
        until(lambda: page.locator("#tick").inner_text() == "0", 60, "the start")
        assert positions(page, 0, (30, 2)) == pytest.approx(start)
        flock = Flock("vem", agents=30, rng=3, eta=3.0)
        flock.run(20)
        assert positions(page, 20, (30, 2)) == pytest.approx(flock.position, abs=1e-9)


def test_it_goes_and_pauses_and_shows_what_it_measures(opened):
    with opened(Flock("vem", agents=30, rng=3)) as page:
        page.click("#go")
        until(lambda: page.evaluate("page.state.tick > 5"), 60, "five ticks")
        page.click("#go")
        tick = page.evaluate("page.ask({}).then((answer) => answer.tick)")
        flock = Flock("vem", agents=30, rng=3)
        flock.run(tick)
        shown = float(page.locator(".chart output").first.inner_text())
        assert shown == pytest.approx(flock.observe("polarisation"), abs=6e-4)
        page.keyboard.press("s")
        until(lambda: page.evaluate("page.state.tick") == tick + 1, 60, "a tick more")


def test_another_engine_gives_the_same_bits(chromium):
    """Of a rule that takes cosines, lengths and powers: its page brings its own."""
    program = web_program(Flock("reynolds", rng=3))
    manifest, ticks = program.manifest, 50
    running = Running(program.module, SimpleNamespace(content=program.memory))
    slot, _, _, _ = manifest["arguments"]["ticks"]
    place = manifest["block"] + SLOT * slot
    running.memory.write(running.store, struct.pack("<q", ticks), place)
    assert running.exports["advance"](running.store, manifest["block"]) == 0
    assert running.read(manifest["answer"], "<q") == (ticks,)
    _, _, address, shape = manifest["arguments"]["flock.position"]
    here = running.memory.read(running.store, address, address + 8 * math.prod(shape))
    page = chromium.new_page()
    try:
        page.add_script_tag(content=(FOLDER / "kernel.js").read_text("utf-8"))
        found = page.evaluate(
            """async ({ module, manifest, image, ticks }) => {
              const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
              const compiled = await WebAssembly.compile(bytes(module));
              const kernel = new Kernel(compiled, manifest, bytes(image));
              kernel.run(ticks);
              return [...kernel.view("flock.position")];
            }""",
            {
                "module": base64.b64encode(program.module).decode(),
                "manifest": manifest,
                "image": base64.b64encode(program.memory).decode(),
                "ticks": ticks,
            },
        )
    finally:
        page.close()
    assert np.array(found).tobytes() == bytes(here)


MEASURED = {
    "vem": {"agents": 40},
    "hwvem-nav": {"agents": 20},
    "couzin": {"agents": 30},
    "thesis": {"agents": 30},
}


@pytest.mark.parametrize("model", MEASURED)
def test_it_measures_what_the_observables_of_the_same_names_give(opened, model):
    flock = Flock(model, rng=3, **MEASURED[model])
    with opened(Flock(model, rng=3, **MEASURED[model])) as page:
        names = page.evaluate("page.manifest.measures.map((one) => one.name)")
        assert {"polarisation", "nearest-neighbour", "groups"} <= set(names)
        for name in names:
            page.locator(".chart select").first.select_option(name)
            flock.run(2)
            answer = page.evaluate("page.ask({ticks: 2})")
            row = answer["rows"][-1]
            assert row[0] == flock.tick
            assert row[1] == pytest.approx(flock.observe(name), rel=1e-7, abs=1e-7), name


def test_a_chart_that_is_changed_meanwhile_has_no_values_of_the_one_before(opened):
    with opened(Flock("vem", agents=30, rng=3)) as page:
        page.evaluate("page.ask({ticks: 3})")
        found = page.evaluate(
            """async () => {
              const [chart] = page.charts, running = page.ask({ ticks: 5 });
              chart.show(page.manifest.measures.find((one) => one.name === "mean-neighbours"));
              await running;
              return chart.points.length;
            }"""
        )
        assert found == 0


def test_what_is_asked_for_before_a_reset_is_not_in_the_new_curve(opened):
    with opened(Flock("vem", agents=30, rng=3)) as page:
        ticks = page.evaluate(
            """async () => {
              const running = page.ask({ ticks: 5 }), again = page.reset();
              await running;
              await again;
              return page.charts[0].points.map(([tick]) => tick);
            }"""
        )
        assert ticks == [0]


def test_gone_on_at_once_after_a_pause_it_keeps_its_pace(opened):
    """One loop of pictures goes on, not that of before as well: one asks for ticks at a time."""
    with opened(Flock("vem", agents=30, rng=3)) as page:
        page.evaluate(
            """() => {
              globalThis.most = 0;
              const ask = page.ask.bind(page);
              page.ask = (request) => {
                most = Math.max(most, page.busy + 1);
                return ask(request);
              };
              page.speed = () => 1000;
              for (const going of [true, false, true]) page.go(going);
            }"""
        )
        until(lambda: page.evaluate("page.state.tick > 20"), 60, "some ticks")
        assert page.evaluate("most") == 1


def test_a_slider_that_is_moved_while_something_is_asked_for_counts_at_once(opened):
    with opened(Flock("vem", agents=30, rng=3)) as page:
        page.evaluate("page.ask({})")
        moved(page, "eta", 1.0)
        moved(page, "eta", 2.0)
        until(lambda: page.evaluate("Object.keys(page.pending).length === 0"), 60, "the slider")


def test_its_curves_as_a_table_have_a_row_for_each_tick(opened):
    with opened(Flock("vem", agents=30, rng=3)) as page:
        for _ in range(3):
            page.evaluate("page.ask({ticks: 4})")
        with page.expect_download() as saved:
            page.click("#save")
        head, *rows = saved.value.path().read_text().splitlines()
        assert head == "tick,polarisation,mean-neighbours"
        assert [row.split(",")[0] for row in rows] == [str(tick) for tick in range(13)]


def test_without_a_worker_it_runs_as_well(opened):
    flock = Flock("vem", agents=30, rng=3)
    flock.run(5)
    with opened(Flock("vem", agents=30, rng=3), without="Worker") as page:
        assert page.evaluate("page.requests.worker") is None
        assert positions(page, 5, (30, 2)) == pytest.approx(flock.position, abs=1e-9)


def test_a_slider_that_a_page_cannot_fly_is_shown_and_cannot_be_moved(opened):
    """How many nearest agents are neighbours is more than a number of the rule."""
    with opened(Flock("vem", agents=30, rng=3, neighbours="nearest")) as page:
        rows = page.locator(".slider").filter(has_text="nearest")
        assert rows.count() == 1
        assert rows.locator("input").is_disabled()
    with opened(Flock("vem", agents=30, rng=3)) as page:
        assert page.locator(".slider").filter(has_text="nearest").count() == 0


def test_zones_keep_their_order(opened):
    with opened(Flock("safe", agents=20, rng=1)) as page:
        zones = page.evaluate("page.manifest.zones")
        inner = zones[0][0][0]
        before = page.evaluate(f"page.values[{inner!r}]")
        moved(page, inner, 1e6)
        assert page.evaluate(f"page.values[{inner!r}]") == before
        assert "zones keep their order" in page.locator("#say").inner_text()


def test_it_runs_in_a_frame_that_may_nothing_but_scripts(chromium, tmp_path):
    file = tmp_path / "inner.html"
    file.write_text(flock_page(Flock("vem", agents=30, rng=3)), encoding="utf-8")
    outer = tmp_path / "outer.html"
    outer.write_text(
        f'<iframe sandbox="allow-scripts" width="480" height="360" src="{file.as_uri()}"></iframe>',
        encoding="utf-8",
    )
    page = chromium.new_page()
    try:
        page.goto(outer.as_uri())
        frame = page.frames[1]
        until(lambda: frame.evaluate("'page' in globalThis"), 60, "the flock to be there")
        frame.click("#step")
        until(lambda: frame.evaluate("page.state.tick") == 1, 60, "a tick")
        assert frame.locator("#go").is_visible()
        assert not frame.locator("header").is_visible()
    finally:
        page.close()


def test_words_of_a_world_are_text():
    title = "<script>globalThis.owned = 1</script>"
    page_text = flock_page(Flock("vem", agents=5, rng=1), PageWords(title))
    assert title not in page_text


def test_a_page_of_a_folder_runs_from_a_web_server(chromium, tmp_path):
    for name, content in page_files(Flock("vem", agents=30, rng=3), "vem").items():
        (tmp_path / name).write_bytes(content)
    flock = Flock("vem", agents=30, rng=3)
    flock.run(20)
    handler = functools.partial(QuietHandler, directory=str(tmp_path))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        page = chromium.new_page()
        try:
            page.goto(f"http://127.0.0.1:{server.server_port}/vem.html")
            until(lambda: page.evaluate("'page' in globalThis"), 60, "the flock to be there")
            there = positions(page, 20, flock.position.shape)
        finally:
            page.close()
            server.shutdown()
    assert there == pytest.approx(flock.position, abs=1e-9)


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    """Serves files without a word."""

    def log_message(self, *_: object) -> None:
        pass
