"""What one student of a class may have: enforced, told in words, and without harm to the rest."""

from __future__ import annotations

import contextlib
import json
import math
import queue
import threading
import time
from dataclasses import replace
from types import SimpleNamespace
from urllib.parse import quote

import msgspec
import pytest
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from agents.spec import Spec
from app.front.server import renders_of
from app.viewer.editing.editor import disc
from app.viewer.gallery.saved_scene import SavedScene, pack_scene
from app.viewer.lab.laboratory import Laboratory
from app.viewer.panels.sending import ExportPermit
from app.viewer.run.allowance import Allowance
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_limits import LONGEST, Share
from tests.live.stand_in import CAMERA
from tests.viewer.http_client import ask
from tests.viewer.waiting import until
from worlds.input_error import InputError

SMALL = Allowance(agents=200, obstacles=3, unseen=0.8, files=0.01)
OPENS = {"X-Flockscope": "scene"}


@pytest.fixture(scope="module")
def laboratory():
    made = Laboratory(preset_spec("vem", agents=50), port=0, speed=60.0, allowance=SMALL)
    assert made.simulation.ready.wait(60)
    yield made
    made.close()


@pytest.fixture
def browser(laboratory):
    """A client that counts the pictures that it is sent."""
    client = connect(
        laboratory.address.replace("http", "ws"),
        subprotocols=[f"viser-v{viser.__version__}"],
        max_size=None,
    )
    pictures: list[float] = []

    def read() -> None:
        with contextlib.suppress(ConnectionClosed):
            pictures.extend(time.monotonic() for message in client if len(message) > 12 * 50)

    threading.Thread(target=read, daemon=True).start()
    client.send(msgspec.msgpack.encode(CAMERA))
    until(lambda: laboratory.browsers() == 1)
    yield pictures
    client.close()
    until(lambda: laboratory.browsers() == 0)


@pytest.fixture
def simulation():
    made = Simulation(preset_spec("vem", agents=50), speed=5.0, allowance=SMALL)
    assert made.ready.wait(60)
    yield made
    made.close()


def told(simulation: Simulation) -> list[str]:
    """What there is to tell by now."""
    found = []
    while True:
        try:
            found.append(simulation.notices.get_nowait())
        except queue.Empty:
            return found


def run_of(simulation: Simulation) -> int:
    return len(simulation.run.flock.ids)


def test_too_many_agents_are_refused_in_words_and_the_flock_goes_on(simulation):
    before = run_of(simulation)
    simulation.setup(preset_spec("vem", agents=100_000)).result(60)
    words = until(lambda: told(simulation), 60)
    space = "\N{NARROW NO-BREAK SPACE}"
    assert words == [f"a class allows 200 agents a student: 100{space}000 asked for"]
    assert (run_of(simulation), simulation.state.running) == (before, True)


@pytest.mark.parametrize(
    ("agents", "informed", "beside", "allowed"),
    [
        (200, None, None, True),
        (201, None, None, False),
        (100, None, Spec("vem"), True),
        (101, None, Spec("vem"), False),
        (10, 201, None, False),
    ],
)
def test_agents_of_all_flocks_count(agents, informed, beside, allowed):
    spec = preset_spec("hwvem", agents=agents, informed=informed)
    if allowed:
        SMALL.demand(spec, beside, None)
    else:
        with pytest.raises(InputError, match="a class allows 200 agents"):
            SMALL.demand(spec, beside, None)


def test_a_scene_in_an_address_is_held_to_the_same(laboratory):
    scene = quote(pack_scene(SavedScene("many", preset_spec("vem", agents=5000))))
    answer = ask(laboratory.port, f"/open?scene={scene}&sure=1", OPENS)
    assert answer.status == 400
    assert "a class allows 200 agents" in answer.text
    assert laboratory.simulation.state.spec.agents == 50


def test_obstacles_are_counted_whether_built_or_brought(simulation):
    for k in range(4):
        simulation.edits.change(lambda editor, k=k: editor.add(disc((1.0 + k, 1.0), 0.2)))
    simulation.watch(()).result(60)
    assert len(simulation.run.flock.world.obstacles) == 3
    assert told(simulation) == ["a class allows 3 obstacles a student: 4 asked for"]
    simulation.setup(preset_spec("vem", agents=20, world="obstacles")).result(60)
    assert until(lambda: told(simulation), 20) == [
        "a class allows 3 obstacles a student: 12 asked for"
    ]


def test_changes_of_the_world_are_bounded_a_second(simulation):
    began = time.monotonic()
    for k in range(60):
        simulation.edits.change(
            lambda editor, k=k: editor.add(disc((1.0, 1.0), 0.2)) if k % 2 == 0 else editor.undo()
        ).exception(60)
    most = 10.0 + SMALL.edits * (time.monotonic() - began)
    words = told(simulation)
    refused = words.count("a class allows 4 changes of the world a second: go slower")
    assert 60 - most - 1 <= refused < 60


@pytest.mark.parametrize("speed", [math.inf, 1e6])
def test_a_flock_that_runs_as_fast_as_it_goes_takes_no_more_than_its_share(speed):
    allowance = replace(SMALL, share=0.1, agents=2000)
    simulation = Simulation(preset_spec("hwvem", agents=2000), speed=speed, allowance=allowance)
    try:
        assert simulation.ready.wait(120)
        clock = time.pthread_getcpuclockid(simulation.thread.ident)
        time.sleep(2.5)  # what it owes for its set-up is over
        until(lambda: simulation.keeping.wait > 0.0, 60)  # so is what it had to spend at once
        began, worked = time.monotonic(), time.clock_gettime(clock)
        tick = simulation.frame.tick
        time.sleep(3.0)
        took = (time.clock_gettime(clock) - worked) / (time.monotonic() - began)
        assert took < 0.13
        assert simulation.frame.tick > tick

        def answers_between_two_ticks() -> bool:
            ticks = simulation.frame.tick
            for k in range(5):
                simulation.set("eta", 1.0 + 0.1 * k).result(60)
            return simulation.frame.tick == ticks

        until(answers_between_two_ticks, 60)
    finally:
        simulation.close()


def test_while_nobody_looks_it_goes_on_with_few_frames(simulation):
    simulation.run_at(20.0).result(60)
    simulation.set_watched(False)
    until(lambda: simulation.pace.timeout > 0.0, 60)
    frames, began, tick = [], time.monotonic(), simulation.frame.tick

    def has_gone_on() -> bool:
        if not frames or simulation.frame is not frames[-1]:
            frames.append(simulation.frame)
        return simulation.frame.tick - tick > 60

    until(has_gone_on, 60)
    assert 2 <= len(frames) <= (time.monotonic() - began) / SMALL.unseen + 2
    simulation.set_watched(True)
    last = simulation.frame
    until(lambda: simulation.frame is not last)
    assert simulation.pace.timeout == 0.0


@pytest.mark.usefixtures("browser")
def test_whoever_comes_is_shown_what_is_at_once(laboratory):
    assert laboratory.simulation.keeping.seen or until(lambda: laboratory.simulation.keeping.seen)
    until(lambda: laboratory.drawing.drawn[0].tick >= laboratory.simulation.frame.tick - 20, 60)


def test_pictures_come_no_more_often_than_is_allowed(browser):
    time.sleep(1.5)
    browser.clear()
    began = time.monotonic()
    time.sleep(3.0)
    until(lambda: len(browser) > 6)
    assert len(browser) / (time.monotonic() - began) < SMALL.pictures * 1.15


def test_there_is_no_tab_for_sweeps_and_its_routes_say_why(laboratory):
    assert laboratory.sweep is None
    for path in ("/sweep/over?name=eta", "/sweep/run?sweep=a&cell=1"):
        answer = ask(laboratory.port, path, OPENS)
        assert answer.status == 403
        assert answer.text.startswith("a class makes no sweeps")


def test_films_are_refused_and_pictures_and_files_are_rationed(laboratory, monkeypatch):
    me = "somebody"
    client = SimpleNamespace(client_id=99, camera=None, send_file_download=lambda *_, **__: None)
    from app.viewer.lab.picture_exporter import ExportClient

    monkeypatch.setitem(laboratory.taking.visits, me, ExportClient(client))
    monkeypatch.setattr(renders_of(laboratory.server), "ask", lambda *_, **__: None)
    until(lambda: laboratory.drawing.drawn is not None)

    def wanted(**more: str):
        asked = "&".join(f"{name}={value}" for name, value in more.items())
        return ask(laboratory.port, f"/take.json?me={me}&{asked}", OPENS)

    film = wanted(do="film", kind="mp4", size="400x320")
    assert (film.status, film.text.split(":")[0]) == (400, "a class makes no films")
    answers = []
    for _ in range(3):
        answers.append(wanted(do="picture", kind="svg", size="400x320"))
        until(lambda: not json.loads(wanted().text)["busy"], 60)
    assert [one.status for one in answers] == [200, 200, 400]
    assert answers[2].text.startswith("a class makes a picture or a file of a plot every 100 s")


def test_files_are_made_one_after_the_other_of_all_pages():
    busy, most = [0], [0]

    def make(making: ExportPermit) -> None:
        with making.take_turn():
            busy[0] += 1
            most[0] = max(most[0], busy[0])
            time.sleep(0.02)
            busy[0] -= 1

    threads = [threading.Thread(target=make, args=(ExportPermit(SMALL),)) for _ in range(5)]
    for one in threads:
        one.start()
    for one in threads:
        one.join()
    assert most == [1]


def test_no_recording_is_opened_and_files_are_small(laboratory, monkeypatch):
    with pytest.raises(InputError, match="opens no saved states and recordings"):
        SMALL.demand_recordings("mine.parquet")
    words = []
    monkeypatch.setattr(laboratory.saving, "tell", words.append)
    button = next(
        one
        for one in laboratory.server.gui._gui_input_handle_from_uuid.values()
        if isinstance(one, viser.GuiUploadButtonHandle) and one.label == "Open a file ..."
    )
    file = SimpleNamespace(name="mine.parquet", content=b"PAR1" + bytes(100))
    for callback in button._impl.update_cb:
        callback(SimpleNamespace(target=SimpleNamespace(value=file)))
    assert words == [
        "a class opens no saved states and recordings, as mine.parquet: `flockscope lab` on your "
        "own machine does"
    ]


def test_without_an_allowance_everything_is_as_it_was():
    simulation = Simulation(preset_spec("vem", agents=300), running=False)
    try:
        assert simulation.ready.wait(60)
        simulation.set_watched(False)
        simulation.setup(preset_spec("vem", agents=1000)).result(60)
        until(lambda: run_of(simulation) >= 1000, 60)
        assert simulation.pace.timeout == 0.0
        assert simulation.keeping.wait == 0.0
    finally:
        simulation.close()


def test_what_was_not_taken_while_somebody_looked_is_not_for_when_nobody_does():
    now, worked = [0.0], [0.0]
    share = Share(0.1, lambda: now[0], lambda: worked[0])
    now[0] = 100.0
    share.set_share(0.003)
    worked[0] = 0.012
    share.note()
    assert share.wait() == pytest.approx(LONGEST)
    now[0] += LONGEST
    assert share.wait() == 0.0
