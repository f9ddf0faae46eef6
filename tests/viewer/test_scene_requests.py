"""What the gallery asks for by HTTP, as strangers may ask for it too."""

from __future__ import annotations

import json
from io import BytesIO
from urllib.parse import quote

import pytest
from PIL import Image

from agents.catalogue import MODELS
from app.viewer.gallery.saved_scene import LARGEST, SavedScene, pack_scene, read_scene
from app.viewer.gallery.scene_collection import built_in_scene, cards
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.panels.setup import NOBODY
from app.viewer.run.run_preset import preset_spec
from tests.viewer.http_client import ask
from tests.viewer.waiting import until
from worlds.input_error import InputError
from worlds.world import World

OPENS = {"X-Flockscope": "scene"}


@pytest.fixture(scope="module")
def laboratory():
    made = Laboratory(preset_spec("vem", agents=20, seed=2), port=0, running=False)
    assert made.simulation.ready.wait(60)
    until(lambda: made.parameters.controls)
    yield made
    made.close()


def opened(laboratory, name: str, **more):
    return ask(laboratory.port, f"/open?scene={quote(name)}", OPENS | more)


def runs(laboratory, model: str) -> bool:
    state = laboratory.simulation.state
    return state.spec.model == model and not state.busy


def test_the_cards_and_their_pictures_are_there(laboratory):
    answer = ask(laboratory.port, "/gallery.json")
    found = json.loads(answer.text)
    assert [one["name"] for one in found] == [card.name for card in cards()]
    picture = ask(laboratory.port, f"/gallery/{found[0]['picture']}")
    assert picture.header("Content-Type") == "image/webp"
    assert Image.open(BytesIO(picture.body)).size == (360, 240)
    assert ask(laboratory.port, "/gallery/../../pyproject.toml").status == 404


def test_a_scene_opens_with_its_view_its_words_and_the_fields_of_setup(laboratory):
    simulation = laboratory.simulation
    answer = opened(laboratory, "beside")
    assert json.loads(answer.text) == {"title": built_in_scene("beside").title, "asks": False}
    until(lambda: runs(laboratory, "hwvem") and simulation.state.running)
    assert simulation.state.beside.model == "vem"
    assert simulation.state.speed == 2.0
    until(lambda: "Watch" in laboratory.run.story.content, 60)
    title = built_in_scene("beside").title
    assert f"<h2>{title}</h2>" in laboratory.run.story.content
    assert f'data-scene="{title}"' in laboratory.run.status.content
    assert laboratory.setup.agents.value == 300
    assert laboratory.setup.beside.value != NOBODY
    until(lambda: laboratory.plots.charts[0].choice.value == "polarisation", 60)

    assert opened(laboratory, "spread").status == 200
    until(lambda: simulation.state.spec.agents == 1000)
    assert laboratory.view.drawing_style().colour == "layer"
    assert laboratory.setup.beside.value == NOBODY
    now = laboratory.now("mine")
    assert now.title == "mine"
    assert now.watch == built_in_scene("spread").watch
    assert now.look == {"colour": "layer", "shadows": False}
    assert SavedScene.from_toml(now.to_toml(), "text").spec.parameters == now.spec.parameters
    assert opened(laboratory, "model:vem").status == 200
    until(lambda: runs(laboratory, "vem"))
    until(lambda: MODELS["vem"].to_try[0].see in laboratory.run.story.content, 60)
    assert laboratory.view.drawing_style().colour == "heading"


def test_a_run_that_is_shared_comes_back_as_it_is(laboratory):
    simulation = laboratory.simulation
    before = simulation.state.run
    opened(laboratory, "model:vem")
    until(lambda: simulation.state.run > before and runs(laboratory, "vem"))
    simulation.set("eta", 1.5).result(60)
    said = json.loads(ask(laboratory.port, "/scene.json", OPENS).text)
    assert said["command"].endswith("--speed 15")
    assert "--set eta=1.5" in said["command"]
    opened(laboratory, "model:ivem")
    until(lambda: runs(laboratory, "ivem"))
    scene = said["address"].removeprefix("?scene=")
    assert ask(laboratory.port, f"/open?scene={scene}", OPENS).status == 200
    until(lambda: runs(laboratory, "vem"))
    assert simulation.state.spec.parameters["eta"] == 1.5


@pytest.mark.parametrize(
    ("headers", "path", "status"),
    [
        ({}, "/open?scene=spread", 403),
        ({"X-Flockscope": "stop"}, "/open?scene=spread", 403),
        (OPENS | {"Origin": "https://example.org"}, "/open?scene=spread", 403),
        (OPENS | {"Sec-Fetch-Site": "cross-site"}, "/open?scene=spread", 403),
        (OPENS | {"Host": "example.org"}, "/open?scene=spread", 403),
        (OPENS, "/open", 400),
        (OPENS, "/open?scene=", 400),
        (OPENS, "/open?scene=/etc/passwd", 400),
        (OPENS, "/open?scene=world:../../x", 400),
        (OPENS, "/open?scene=z.AAAA", 400),
        (OPENS, "/open?scene=model:mine.py", 400),
        (OPENS, "/open?" + "&".join("a=1" for _ in range(200)), 400),
    ],
)
def test_what_may_not_be_opened_changes_nothing(laboratory, headers, path, status):
    before = laboratory.simulation.state.run
    answer = ask(laboratory.port, path, headers)
    assert answer.status == status
    assert answer.text.count("\n") == 1
    assert laboratory.simulation.state.run == before


def test_a_world_that_a_scene_brings_is_looked_at_before_it_is_built(laboratory):
    square = World("mine", (10.0, 10.0), ("wrap", "wrap"))
    kept = pack_scene(SavedScene("mine", preset_spec("vem", agents=10, world=square)))
    assert opened(laboratory, kept).status == 200
    until(lambda: runs(laboratory, "vem") and laboratory.simulation.state.spec.agents == 10)
    until(lambda: laboratory.simulation.frame.world.size == (10.0, 10.0))
    bad = 'title = "x"\n[run]\nmodel = "vem"\n[run.layout]\nsize = [1e300, 1.0]\n'
    with pytest.raises(InputError):
        read_scene("bad.toml", bad.encode())


def test_a_file_is_a_scene_or_a_spec_of_bounded_size():
    spec = preset_spec("vem", agents=30, seed=5)
    assert read_scene("spec.toml", spec.to_toml().encode()).spec == spec
    assert read_scene("scene.toml", built_in_scene("mill").to_toml().encode()) == built_in_scene(
        "mill"
    )
    for data, words in (
        (b"\xff\xfe", "not a text file"),
        (b"a = ", "is not TOML"),
        (b"#" * (LARGEST + 1), "at most"),
    ):
        with pytest.raises(InputError, match=words):
            read_scene("x.toml", data)


def test_a_flock_waits_for_the_first_browser_and_no_longer():
    made = Laboratory(port=0, opened=built_in_scene("spread"), waits=True)
    try:
        assert made.simulation.ready.wait(60)
        assert not made.simulation.state.running
        assert made.waits
        made.server._event_loop.call_soon_threadsafe(
            lambda: made.server._event_loop.create_task(made.welcome(None))
        )
        until(lambda: made.simulation.state.running)
        made.simulation.pause()
        until(lambda: not made.simulation.state.running)
        assert not made.waits
    finally:
        made.close()
