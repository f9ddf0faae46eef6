"""What one takes along: a film that a browser drew, a page that plays, and what the page gives."""

import json

import numpy as np
import pytest
from cli.calling import call
from imageio_ffmpeg import count_frames_and_secs
from PIL import Image

from tests.browser.conftest import absent
from tests.viewer.waiting import until

SEEN = (640, 480)


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
    until(lambda: clock.count() and float(clock.input_value()) > 0.5, 30)
    page.keyboard.press("Space")
    stands = clock.input_value()
    page.wait_for_timeout(600)
    assert clock.input_value() == stands
    assert "seed 2 · ticks 0 to 60, 10 a second" in page.inner_text(".told")
    page.locator(".mantine-Notification-root").evaluate_all("all => all.map((one) => one.remove())")
    page.screenshot(path=tmp_path / "seen.png")
    with Image.open(tmp_path / "seen.png") as seen:
        scene = np.asarray(seen.convert("RGB"), int)[60:400, 120:520]
    assert (np.ptp(scene, axis=2) > 90).sum() > 300, "agents have colours"
    assert [url for url in asked if not url.startswith(("file:", "blob:", "data:"))] == []
    page.close()
