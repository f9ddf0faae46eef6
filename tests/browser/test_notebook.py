"""A laboratory in a cell of a real JupyterLab, and in nobody else's frame."""

from __future__ import annotations

import io
import urllib.request

import numpy as np
import pytest
from PIL import Image

from app.viewer.notebook_view import NotebookAccess, NotebookView
from flockscope import Flock
from tests.browser.attacker import Attacker
from tests.browser.conftest import POLICY, absent
from tests.browser.jupyter import BASE, Jupyter
from tests.viewer.waiting import COMPILED, until
from worlds.input_error import InputError

SLOW = 1000 * COMPILED
"""Milliseconds for a laboratory to be there, on a busy machine."""
TRIES = 6
FLOCK = "flock = Flock('vem', agents=40, rng=1, eta=0.3)"
CELLS = (
    f"from flockscope import Flock\n{FLOCK}\nflock.run(50)\nview = flock.show()",
    "flock.picture((640, 400))",
    f"{FLOCK}\nflock.show(through='proxy')",
    "print('taken at', view.flock.tick, 'from', flock.tick)",
)
INK = """canvas => {
  const small = document.createElement("canvas");
  small.width = 200; small.height = 150;
  const pen = small.getContext("2d", { willReadFrequently: true });
  return new Promise(told => requestAnimationFrame(() => {
    pen.drawImage(canvas, 0, 0, 200, 150);
    const dots = pen.getImageData(0, 0, 200, 150).data;
    let vivid = 0;
    for (let k = 0; k < dots.length; k += 4) {
      const most = Math.max(dots[k], dots[k + 1], dots[k + 2]);
      if (most - Math.min(dots[k], dots[k + 1], dots[k + 2]) > 90) vivid++;
    }
    told(vivid);
  }));
}"""
"""How many of 30 000 dots of a canvas are of a vivid colour."""


@pytest.fixture(scope="module")
def page(chromium, tmp_path_factory):
    """A notebook that is open, none of its cells run; what it is told goes into `said`."""
    try:
        import jupyter_server_proxy  # noqa: F401
        import jupyterlab  # noqa: F401
    except ImportError:
        absent("JupyterLab with jupyter-server-proxy")
    page = chromium.new_page(viewport={"width": 1440, "height": 1100})
    from playwright.sync_api import TimeoutError as TooLate

    page.said, page.lines, page.too_late = [], [], TooLate
    page.on("console", lambda said: page.said.append(said.text))
    page.on("websocket", lambda line: page.lines.append(line.url))
    with Jupyter(tmp_path_factory.mktemp("jupyter")) as jupyter:
        page.goto(jupyter.notebook(*CELLS))
        page.locator(".jp-CodeCell").nth(len(CELLS) - 1).wait_for(timeout=SLOW)
        page.get_by_text("(ipykernel) | Idle").wait_for(timeout=SLOW)
        page.jupyter = jupyter
        yield page
        page.close()


def run(page, number: int):
    """Run a cell; what it has put below itself."""
    cell = page.locator(".jp-CodeCell").nth(number)
    begun = cell.locator(".jp-InputPrompt").filter(has_not_text="[ ]:")
    for _ in range(TRIES):  # a page that is busy may not have heard the keys
        cell.locator(".cm-content").click()
        page.keyboard.press("Control+Enter")
        try:
            begun.wait_for(timeout=5000)
            break
        except page.too_late:
            continue
    return cell.locator(".jp-OutputArea-output")


def inside(output):
    """The laboratory in the frame of an output, once its agents are drawn."""
    output.locator("iframe").wait_for(timeout=SLOW)
    output.locator("iframe").scroll_into_view_if_needed()
    frame = output.frame_locator("iframe")
    monitors = frame.locator(".fs-strip").get_by_role("button", name="Monitors", exact=True)
    monitors.click(timeout=SLOW)  # the frame is a small window: the picture is first
    frame.locator(".fs-card").first.wait_for(timeout=SLOW)
    canvas = frame.locator("canvas[data-engine]")
    until(lambda: canvas.evaluate(INK) > 20, COMPILED, "agents")
    return frame


def tick(frame) -> str:
    return frame.locator(".fs-card", has_text="tick").first.locator("b").inner_text()


def goes(frame, first: int) -> None:
    """Go and Pause work, from a tick on."""
    until(lambda: tick(frame) == str(first), COMPILED, f"tick {first}")
    frame.get_by_role("button", name="Go", exact=True).click()
    until(lambda: int(tick(frame)) > first + 3, COMPILED, "a flock that runs")
    frame.get_by_role("button", name="Pause", exact=True).click()
    frame.get_by_role("button", name="Go", exact=True).wait_for(timeout=SLOW)


def test_a_notebook_shows_a_laboratory_and_takes_its_flock_back(page):
    output = run(page, 0)
    goes(inside(output), 50)
    assert "viser" not in " ".join(output.all_inner_texts())
    told = run(page, 3)
    until(lambda: "taken at" in told.first.inner_text(), 60)
    words = told.first.inner_text().split()
    assert int(words[2]) > 53
    assert words[-1] == "50"
    assert page.lines[-1].startswith("ws://localhost:")
    assert not [said for said in page.said if POLICY in said]


def test_a_picture_is_an_image(page):
    image = run(page, 1).locator("img")
    image.wait_for(timeout=SLOW)
    assert image.get_attribute("src").startswith("data:image/png")
    assert image.evaluate("one => [one.naturalWidth, one.naturalHeight]") == [640, 400]


def test_the_same_through_the_notebooks_own_server(page):
    page.lines.clear()
    output = run(page, 2)
    goes(inside(output), 0)
    assert output.locator("iframe").count() == 1
    outer = f"ws://localhost:{page.jupyter.port}{BASE}proxy/"
    assert [line for line in page.lines if line.startswith(outer)]
    assert not [said for said in page.said if POLICY in said]


@pytest.mark.parametrize("named", [True, False], ids=["its own", "another port's"])
def test_a_page_frames_it_only_if_it_is_the_notebooks(chromium, monkeypatch, named):
    """Also if that page knows the whole address."""
    monkeypatch.setattr("webbrowser.open", lambda _: True)
    page = chromium.new_page(viewport={"width": 1000, "height": 640})
    lines: list[str] = []
    page.on("websocket", lambda line: lines.append(line.url))
    with Attacker() as other:
        own = f"http://127.0.0.1:{other.port}" if named else f"http://127.0.0.1:{other.port + 1}"
        view = NotebookView(Flock("vem", agents=20, rng=1), NotebookAccess((own,)), 500, False)
        try:
            with urllib.request.urlopen(view.address) as answer:
                assert own in answer.headers["Content-Security-Policy"]
            other.page = f'<iframe src="{view.address}" width="900" height="600"></iframe>'
            if named:
                page.goto(other.address)
                page.frames[1].locator(".fs-strip button").first.wait_for(timeout=SLOW)
                assert len(lines) == 1
            else:
                with page.expect_console_message(lambda said: POLICY in said.text) as refusal:
                    page.goto(other.address)
                assert "frame-ancestors" in refusal.value.text
                assert lines == []
        finally:
            view.end()
            page.close()


def test_a_picture_by_the_browser_shows_what_the_plain_one_cannot(chromium, tmp_path):
    assert chromium.is_connected()
    still = Flock("vem", agents=40, rng=1).picture((640, 400), camera="side", renderer="browser")
    pixels = np.asarray(Image.open(io.BytesIO(still.png)).convert("RGB"), int)
    assert pixels.shape == (400, 640, 3)
    assert np.mean(pixels.max(axis=2) - pixels.min(axis=2) > 90) > 0.001
    with pytest.raises(InputError, match=r"a browser draws no \.svg"):
        still.save(tmp_path / "flock.svg")
