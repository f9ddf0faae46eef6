"""Pictures and films that a page asks for, without a browser: one that answers as it is told."""

from __future__ import annotations

import asyncio
import io
import json
import re
from concurrent.futures import Future
from types import SimpleNamespace
from urllib.parse import urlencode

import numpy as np
import pytest
from imageio_ffmpeg import count_frames_and_secs
from PIL import Image

from agents.spec import Spec
from app.front.server import renders_of
from app.viewer.lab import picture_exporter
from app.viewer.lab.laboratory import Laboratory
from app.viewer.pictures.browser import darkened
from app.viewer.run.run_preset import preset_spec
from tests.viewer.http_client import ask
from tests.viewer.waiting import until
from worlds.input_error import InputError

SCENE = (40, 120, 200)
"""The one colour of all that the browser draws."""


class Page:
    """A browser that looks straight down and keeps what it is sent."""

    def __init__(self, number: int):
        self.client_id, self.files, self.content = number, [], ""
        self.camera = SimpleNamespace(
            position=np.array([0.0, 0.0, 40.0]), wxyz=np.array([0.0, 1.0, 0.0, 0.0]), fov=0.3,
            image_width=800, image_height=800,
        )  # fmt: skip
        self.gui = SimpleNamespace(add_html=self.hear)

    def hear(self, content: str, visible: bool) -> None:
        self.content = content
        assert not visible

    @property
    def me(self) -> str:
        return self.content.split('"')[1]

    def send_file_download(self, name: str, made: bytes, save_immediately: bool) -> None:
        assert save_immediately
        self.files.append((name, made))


@pytest.fixture(scope="module")
def laboratory():
    made = Laboratory(preset_spec("vem", agents=20, seed=2, parameters={"eta": 0.25}), port=0,
                      running=False)  # fmt: skip
    until(lambda: made.drawing.drawn is not None, 60)
    yield made
    made.close()


@pytest.fixture
def page(laboratory, monkeypatch):
    """One that is connected; what it is asked to draw is one colour."""

    def draw(_client, size, eye=None, exact=False, timeout=0.0):  # noqa: ARG001 - as it is called
        return np.broadcast_to(np.array(SCENE, np.uint8), (size[1], size[0], 3))

    monkeypatch.setattr(renders_of(laboratory.server), "ask", draw)
    made = Page(next(NUMBERS))
    asyncio.run(laboratory.taking.welcome(made))
    yield made
    asyncio.run(laboratory.taking.farewell(made))


NUMBERS = iter(range(1000, 2000))


def wanted(laboratory, page, **more):
    """What is answered to a page that asks so."""
    asked = urlencode({"me": page.me, "theme": "light", "dots": "1", **more})
    return ask(laboratory.port, f"/take.json?{asked}", {"X-Flockscope": "scene"})


def taken(laboratory, page, **more):
    """The file that comes of it."""
    assert wanted(laboratory, page, **more).status == 200
    until(lambda: page.files, 60)
    return page.files.pop()


def colours(made):
    """How often each colour is in a picture."""
    with Image.open(io.BytesIO(made)) as found:
        return found.size, {one: count for count, one in found.convert("RGB").getcolors(10**6)}


def test_a_picture_has_its_size_the_scene_and_what_it_means(laboratory, page):
    name, made = taken(laboratory, page, do="picture", kind="png", size="900x700")
    assert name == "vem-seed2-tick0.png"
    size, found = colours(made)
    assert size == (900, 700)
    assert found[SCENE] > 0.25 * 900 * 700
    assert len([one for one in found if np.ptp(one) > 60]) > 50, "the wheel of headings"


def test_the_dark_theme_comes_out_as_the_page_shows_it(laboratory, page):
    _, made = taken(laboratory, page, do="picture", kind="png", size="900x700", theme="dark")
    _, found = colours(made)
    dark = tuple(darkened(np.array([[SCENE]], np.uint8))[0, 0].tolist())
    assert found[dark] > 0.25 * 900 * 700
    assert max(found, key=found.get) in (dark, (20, 20, 20))
    assert SCENE not in found


def test_a_plan_is_drawn_as_vectors(laboratory, page):
    name, made = taken(laboratory, page, do="picture", kind="svg", size="900x700")
    assert name.endswith(".svg")
    assert b"<svg" in made[:600]
    _, made = taken(laboratory, page, do="picture", kind="pdf", size="900x700")
    assert made.startswith(b"%PDF-")


def test_a_film_lasts_as_long_as_it_was_watched(laboratory, page, tmp_path):
    assert wanted(laboratory, page, do="film", kind="mp4", size="400x320").status == 200
    (visit,) = laboratory.taking.visits.values()
    until(lambda: visit.filming.seconds > 1.0 and visit.filming.seconds < 30.0, 60)
    state = json.loads(wanted(laboratory, page).text)
    assert state["filming"]
    again = wanted(laboratory, page, do="film", kind="mp4", size="400x320")
    assert (again.status, again.text) == (400, "one thing at a time: it is being made\n")
    seconds = visit.filming.seconds
    wanted(laboratory, page, do="stop")
    until(lambda: page.files, 60)
    until(lambda: not json.loads(wanted(laboratory, page).text)["filming"])
    name, made = page.files.pop()
    (tmp_path / name).write_bytes(made)
    frames, _ = count_frames_and_secs(str(tmp_path / name))
    assert frames == pytest.approx(picture_exporter.FPS * seconds, abs=15)


def test_a_page_that_plays_holds_the_frames(laboratory, page):
    wanted(laboratory, page, do="film", kind="html", size="1280x720")
    (visit,) = laboratory.taking.visits.values()
    until(lambda: visit.filming.seconds > 0.5, 60)
    laboratory.simulation.step(3)
    until(lambda: laboratory.drawing.drawn[0].tick == 3, 60)
    wanted(laboratory, page, do="stop")
    until(lambda: page.files, 60)
    name, made = page.files.pop()
    assert name.endswith(".html")
    assert b"eta = 0.25 rad \xc2\xb7 ticks " in made


def test_who_goes_leaves_nothing(laboratory, page):
    wanted(laboratory, page, do="film", kind="gif", size="400x320")
    (visit,) = laboratory.taking.visits.values()
    made = visit.filming
    asyncio.run(laboratory.taking.farewell(page))
    made.join(60)
    assert not made.is_alive()
    assert page.files == []
    answer = wanted(laboratory, page)
    assert (answer.status, answer.text) == (403, "this page is not connected\n")


def test_two_browsers_film_at_once_each_its_own(laboratory, page):
    other = Page(next(NUMBERS))
    asyncio.run(laboratory.taking.welcome(other))
    try:
        for one, size in ((page, "400x320"), (other, "640x360")):
            assert wanted(laboratory, one, do="film", kind="gif", size=size).status == 200
        visits = list(laboratory.taking.visits.values())
        until(lambda: all(one.filming.seconds > 0.5 for one in visits), 60)
        wanted(laboratory, page, do="stop")
        until(lambda: page.files, 60)
        assert colours(page.files.pop()[1])[0] == (400, 320)
        assert json.loads(wanted(laboratory, other).text)["filming"]
        wanted(laboratory, other, do="stop")
        until(lambda: other.files, 60)
        assert colours(other.files.pop()[1])[0] == (640, 360)
    finally:
        asyncio.run(laboratory.taking.farewell(other))


def test_films_want_an_extra_and_say_so(laboratory, page, monkeypatch):
    """A page that plays is made without it."""

    def absent(purpose):
        raise InputError(f"{purpose} needs the package")

    monkeypatch.setattr(picture_exporter, "demand_film", absent)
    assert json.loads(wanted(laboratory, page).text)["missing"] == "a film needs the package"
    answer = wanted(laboratory, page, do="film", kind="mp4", size="400x320")
    assert (answer.status, answer.text) == (400, "a film needs the package\n")
    assert wanted(laboratory, page, do="film", kind="html", size="400x320").status == 200


def test_discarded_is_discarded(laboratory, page):
    wanted(laboratory, page, do="film", kind="gif", size="400x320")
    wanted(laboratory, page, do="discard")
    until(lambda: not json.loads(wanted(laboratory, page).text)["filming"], 60)
    assert page.files == []


def test_a_film_ends_by_itself(laboratory, page, monkeypatch):
    monkeypatch.setattr(picture_exporter, "LONGEST", 0.4)
    wanted(laboratory, page, do="film", kind="gif", size="400x320")
    until(lambda: page.files, 60)
    told = told_cut(laboratory, page)
    assert re.fullmatch(r"The film ends after \d+ s: none is longer than 0\.4 s\.", told), told
    assert json.loads(wanted(laboratory, page).text)["cut"] == "", "it is told once"


def test_a_page_of_frames_says_how_long_it_can_be_and_that_it_was_cut(
    laboratory, page, monkeypatch
):
    agents = len(laboratory.drawing.drawn[0].ids)
    monkeypatch.setattr(picture_exporter, "LIGHT", 2 * agents)
    assert json.loads(wanted(laboratory, page).text)["html_seconds"] == 2 / picture_exporter.FPS
    laboratory.simulation.go()
    wanted(laboratory, page, do="film", kind="html", size="400x320")
    until(lambda: page.files, 60)
    laboratory.simulation.pause()
    assert f"as HTML 2 pictures of {agents} agents fit" in told_cut(laboratory, page)


def told_cut(laboratory, page) -> str:
    """Why the film is shorter than was asked for, as the page is told once."""
    told = []
    until(lambda: told.append(json.loads(wanted(laboratory, page).text)["cut"]) or told[-1], 60)
    return told[-1]


def test_a_browser_that_draws_nothing_is_told(laboratory, page, monkeypatch):
    def nothing(*_args, **_more):
        raise InputError("the browser has drawn nothing in 15 s")

    monkeypatch.setattr(renders_of(laboratory.server), "ask", nothing)
    for what, kind in (("picture", "png"), ("film", "webm")):
        wanted(laboratory, page, do=what, kind=kind, size="400x320")
        said = []
        until(lambda said=said: said.append(json.loads(wanted(laboratory, page).text))
              or said[-1]["said"], 20)  # fmt: skip
        assert "drawn nothing" in said[-1]["said"]
    assert page.files == []


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"do": "erase"}, "do = 'erase' is not one of"),
        ({"do": "picture", "kind": "mp4", "size": "400x320"}, "kind = 'mp4' is not one of png"),
        ({"do": "film", "kind": "png", "size": "400x320"}, "kind = 'png' is not one of mp4"),
        ({"do": "picture", "kind": "png", "size": "40x320"}, "size = '40x320' is not allowed"),
        ({"do": "picture", "kind": "png", "size": "99999x99999"}, "is not allowed"),
        (
            {"do": "picture", "kind": "png", "size": "3840x3840"},
            "8\u202f294\u202f400 in all",
        ),
        (
            {"do": "film", "kind": "mp4", "size": "3840x2160"},
            "2\u202f304\u202f000 in all",
        ),
        ({"do": "picture", "kind": "png", "size": "-1x1e9"}, "is not allowed"),
        ({"do": "picture", "kind": "png"}, "is not allowed"),
    ],
)
def test_what_cannot_be_made_is_refused(laboratory, page, asked, said):
    answer = wanted(laboratory, page, **asked)
    assert answer.status == 400
    assert said in answer.text


def test_only_this_page_asks_and_not_too_often(laboratory, page):
    path = f"/take.json?me={page.me}&do=picture&kind=png&size=400x320"
    assert ask(laboratory.port, path).status == 403
    assert ask(laboratory.port, "/take.json?me=guess", {"X-Flockscope": "scene"}).status == 403
    answers = []
    for _ in range(8):
        answers.append(wanted(laboratory, page, do="picture", kind="png", size="320x320").text)
        until(lambda: not json.loads(wanted(laboratory, page).text)["busy"], 60)
    assert any("try again in a few seconds" in one for one in answers)


def test_two_flocks_are_refused_in_a_line_where_a_page_cannot_run_one(
    laboratory, page, monkeypatch
):
    simulation = laboratory.simulation
    before = simulation.state.spec
    simulation.setup(before, Spec("reynolds"))
    until(lambda: simulation.state.models[1] == "reynolds", 60)
    asked = []

    class Child:
        """Refuses what it is asked for."""

        def __init__(self, *_words, **_more):
            pass

        def __enter__(self):
            return self

        def __exit__(self, *_):
            pass

        def ask(self, name, *flocks, timeout):
            asked.append((name, [flock.model.name for flock in flocks], timeout > 0.0))
            refused = Future()
            refused.set_exception(InputError("model 'reynolds' has checks of its own"))
            return refused

    monkeypatch.setattr(picture_exporter, "ChildProcess", Child)
    said = []

    def hears():
        said.append(json.loads(wanted(laboratory, page).text)["said"])
        return said[-1]

    assert json.loads(wanted(laboratory, page).text)["pair"]
    until(lambda: simulation.state.compiling is None, 180)
    assert wanted(laboratory, page, do="page").status == 200
    until(hears, 60)
    assert asked == [("write_pair", ["vem", "reynolds"], True)]
    assert said[-1] == "model 'reynolds' has checks of its own"
    assert page.files == []
    simulation.setup(before)
    until(lambda: simulation.state.models[1] is None, 60)


@pytest.mark.usefixtures("page")
def test_a_coarse_browser_is_asked_for_more(laboratory, monkeypatch):
    """viser draws coarsely where drawing is slow: what comes is fine all the same."""
    asked = []

    def draw(_client, size, eye=None, exact=False):  # noqa: ARG001 - as it is called
        asked.append(size)
        return np.broadcast_to(np.array(SCENE, np.uint8), (size[1], size[0], 3))

    for dots in ("1", "0.5", "nan", "1e9", "x"):
        monkeypatch.setattr(renders_of(laboratory.server), "ask", draw)
        (visit,) = laboratory.taking.visits.values()
        visit.dots = picture_exporter.coarseness(dots)
        assert picture_exporter.BrowserCapture(laboratory, visit).render((400, 300)).shape == (
            300,
            400,
            3,
        )
    assert asked == [(400, 300), (800, 600), (400, 300), (400, 300), (400, 300)]
