"""What one takes along: a film that a browser drew, a page that plays, and what the page gives."""

import json
import os
import signal
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from cli.calling import call, start, wait_until
from imageio_ffmpeg import count_frames_and_secs, read_frames
from PIL import Image

from agents.spec import Spec
from tests.browser.accessibility import find_violations_in_both_themes
from tests.browser.conftest import START, absent
from tests.browser.window import is_compiled
from tests.viewer.waiting import COMPILED, until

SEEN = (640, 480)
WANTED = (800, 600)


@pytest.fixture
def drawing(chromium, monkeypatch):
    """The browser of these tests is the one that draws."""
    from tests.browser.conftest import CHROMIUM

    if CHROMIUM is None:
        absent("chromium")
    monkeypatch.setenv("FLOCKSCOPE_CHROMIUM", CHROMIUM)
    return chromium


@pytest.mark.usefixtures("drawing")
def test_a_browser_films_a_run(tmp_path):
    out = tmp_path / "flock.gif"
    result = call("film", "couzin", "--dim", 3, "--agents", 30, "--seed", 2, "--to", 6, "--every",
                  2, "--camera", "round", "--pixels", "480x360", "--renderer", "browser", "--out",
                  out, "--json")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout)["renderer"] == "browser"
    assert count_frames_and_secs(str(out))[0] == 4
    with Image.open(out) as film:
        first = np.asarray(film.convert("RGB"), int)
        film.seek(1)
        second = np.asarray(film.convert("RGB"), int)
    scene = (slice(80, 280), slice(40, 300))
    assert first[scene].std() > 5.0
    assert abs(first[scene] - second[scene]).mean() > 3.0, "it goes round"


def runs_in(folder):
    """Whether a program runs that was told of a folder."""
    told = (path for path in Path("/proc").glob("[0-9]*/cmdline"))
    return any(str(folder).encode() in words(path) for path in told)


def words(path):
    """The words of a program that runs, b"" if it has just ended."""
    with suppress(OSError):
        return path.read_bytes()
    return b""


@pytest.mark.usefixtures("drawing")
def test_ctrl_c_ends_the_browser_too(tmp_path):
    run = ("film", "vem", "--agents", 20, "--to", 10**5, "--pixels", "320x320", "--out")
    process = start(*run, tmp_path / "a.mp4", "--renderer", "browser",
                    env={**os.environ, "TMPDIR": str(tmp_path)})  # fmt: skip
    wait_until(lambda: list(tmp_path.glob("flockscope-film-*/film.mp4")), process)
    assert runs_in(tmp_path / "flockscope-browser-")
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=60)
    assert (process.returncode, stdout) == (130, "")
    assert stderr.splitlines()[-1] == "flockscope: stopped; no film was written"
    assert [one for one in tmp_path.iterdir() if "flockscope" in one.name] == []
    assert not (tmp_path / "a.mp4").exists()
    assert not runs_in(tmp_path / "flockscope-browser-")


def test_a_page_plays_without_a_server_or_a_network(drawing, tmp_path):
    out = tmp_path / "run.html"
    result = call("film", "vem", "--agents", 40, "--seed", 2, "--to", 60, "--speed", 10, "--out",
                  out, "--quiet")  # fmt: skip
    assert result.exit_code == 0, result.stderr
    page = drawing.new_page(viewport={"width": SEEN[0], "height": SEEN[1]})
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.on("websocket", lambda socket: asked.append(socket.url))
    page.goto(out.as_uri())
    clock = page.locator("input").first
    until(lambda: clock.count() and float(clock.input_value()) > 0.5, 60)
    page.keyboard.press("Space")
    stands = clock.input_value()
    page.wait_for_timeout(600)
    assert clock.input_value() == stands
    assert "seed 2 · ticks 0 to 60, 10 a second" in page.inner_text(".told")
    page.get_by_role("main").get_by_role("img", name="Picture: ").wait_for()
    assert find_violations_in_both_themes(page) == []
    page.locator(".mantine-Notification-root").evaluate_all("all => all.map((one) => one.remove())")
    page.screenshot(path=tmp_path / "seen.png")
    with Image.open(tmp_path / "seen.png") as seen:
        scene = np.asarray(seen.convert("RGB"), int)[60:400, 120:520]
    assert (np.ptp(scene, axis=2) > 90).sum() > 300, "agents have colours"
    assert [url for url in asked if not url.startswith(("file:", "blob:", "data:"))] == []
    page.close()


def test_the_page_gives_a_picture_of_what_it_shows(window, tmp_path):
    """Of the size asked for, with the scene's own colours, and a legend beside it."""
    page = window.page
    page.click(".fs-open >> text=Take")
    page.locator(".fs-take select").nth(1).wait_for()
    page.evaluate(
        "([select, size]) => { const one = document.querySelectorAll('.fs-take select')[select];"
        " one.append(new Option(size, size)); one.value = size; }",
        [1, f"{WANTED[0]}x{WANTED[1]}"],
    )
    with page.expect_download(timeout=60_000) as found:
        page.click("text=Save picture")
    assert found.value.suggested_filename.endswith("-seed3-tick0.png")
    found.value.save_as(tmp_path / "seen.png")
    with Image.open(tmp_path / "seen.png") as picture:
        assert picture.size == WANTED
        seen = np.asarray(picture.convert("RGB"), int)
    coloured = np.ptp(seen, axis=2) > 90
    assert coloured[:, :400].sum() > 200, "agents"
    assert coloured[60:320, 500:].sum() > 500, "the wheel of headings"


def test_the_page_gives_its_flock_as_a_page_that_runs(window, chromium, tmp_path):
    page = window.page
    page.click(".fs-open >> text=Take")
    with page.expect_download(timeout=300_000) as found:
        page.click("text=Save page")
        page.locator(".fs-recording").wait_for()
    assert found.value.suggested_filename.endswith("-seed3-tick0.html")
    found.value.save_as(tmp_path / "flock.html")
    alone = chromium.new_page()
    try:
        alone.goto((tmp_path / "flock.html").as_uri())
        alone.click("#step", timeout=60_000)  # as soon as it is enabled
        until(lambda: alone.evaluate("page.state.tick === 1"), 60)
    finally:
        alone.close()


def test_the_page_gives_two_flocks_as_one_page_that_goes_on(window, laboratory, chromium, tmp_path):
    """From the tick at which they are; both are stepped and put back to it."""
    simulation = laboratory.simulation
    simulation.setup(START, Spec("vem"))
    until(lambda: simulation.state.models[1] == "vem", 60)
    until(lambda: is_compiled(simulation), COMPILED)
    simulation.step(5).result(60)
    places = [flock.position for flock in simulation.flocks().result(60)]
    page = window.page
    page.click(".fs-open >> text=Take")
    page.get_by_text("Both flocks from where they are now").wait_for()
    with page.expect_download(timeout=300_000) as found:
        page.click("text=Save page")
        page.locator(".fs-recording").wait_for()
    simulation.setup(START)
    assert found.value.suggested_filename == "hwvem-beside-vem-seed3-tick5.html"
    found.value.save_as(tmp_path / "both.html")
    alone = chromium.new_page()
    try:
        alone.goto((tmp_path / "both.html").as_uri())
        assert find_violations_in_both_themes(alone) == []
        frames = [frame for frame in alone.frames if frame != alone.main_frame]
        for frame, place in zip(frames, places, strict=True):
            frame.wait_for_selector("#step:not([disabled])", timeout=60_000)
            shown = frame.evaluate("[...page.state.position]")
            assert np.reshape(shown, place.shape) == pytest.approx(place, abs=1e-12)
        for button, tick in (("#step", 6), ("#reset", 5)):
            alone.click(button)
            until(
                lambda tick=tick: [one.evaluate("page.state.tick") for one in frames] == [tick] * 2
            )
    finally:
        alone.close()


def test_the_page_films_what_it_shows(window, laboratory, tmp_path):
    """From Record to Stop; it goes on by itself meanwhile."""
    page = window.page
    page.click(".fs-open >> text=Take")
    page.select_option(".fs-take >> nth=1 >> select >> nth=1", "640x360")
    page.get_by_role("button", name="Record", exact=True).click()
    page.wait_for_selector(".fs-recording >> text=/Recording 0:0[1-9]/", timeout=60_000)
    laboratory.simulation.step(5)
    with page.expect_download(timeout=60_000) as found:
        page.click(".fs-recording >> text=Stop")
    assert found.value.suggested_filename.endswith(".mp4")
    found.value.save_as(tmp_path / "seen.mp4")
    assert next(read_frames(str(tmp_path / "seen.mp4")))["size"] == (640, 360)
    assert count_frames_and_secs(str(tmp_path / "seen.mp4"))[0] >= 20
    page.wait_for_selector(".fs-recording", state="detached", timeout=30_000)
