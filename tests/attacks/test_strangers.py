"""Browsers that never introduce themselves by a camera, and files that never come."""

from __future__ import annotations

import pytest

from app.front import uploads
from app.front.uploads import AT_ONCE, accept_uploads
from tests.attacks.raw import Raw, said
from tests.live.stand_in import StandIn
from tests.viewer.waiting import until

LATE = 60.0


def test_a_stranger_moves_no_slider_that_others_see_and_that_does_not_act(server, count):
    slider = server.gui.add_slider("eta", 0.0, 6.28, 0.01, 0.5)
    acted: list[float] = []

    async def note(event) -> None:
        acted.append(event.target.value)

    slider.on_update(note)
    with StandIn(server.get_port()) as witness:
        until(lambda: witness.found("eta"))
        uuid = slider._impl.uuid
        with Raw(server.get_port(), camera=False) as stranger:
            for _ in range(50):
                stranger.say(said(type="GuiUpdateMessage", uuid=uuid, updates={"value": 3.0}))
            stranger.line.ping().wait(LATE)  # by then all before it has been read
        until(lambda: len(server._websock_server._live_connections) == 1, LATE)
        witness.set("eta", 2.0)  # the page goes on, and what it shows is what acts
        until(lambda: acted == [2.0], LATE)
        assert slider.value == 2.0
        assert not any(one.get("value") == 3.0 for one in witness.controls.values())
    count(messages=50, connections=1)


def test_what_a_browser_says_after_its_camera_is_heard_in_order(server):
    slider = server.gui.add_slider("eta", 0.0, 6.28, 0.01, 0.5)
    acted: list[float] = []

    async def note(event) -> None:
        acted.append(event.target.value)

    slider.on_update(note)
    with Raw(server.get_port()) as browser:
        for value in (1.0, 2.0, 3.0):
            uuid = slider._impl.uuid
            browser.say(said(type="GuiUpdateMessage", uuid=uuid, updates={"value": value}))
        until(lambda: acted == [1.0, 2.0, 3.0], LATE)


@pytest.fixture
def button(server):
    """An upload button, and the names of the files that came through it."""
    made = server.gui.add_upload_button("Open")
    came: list[str] = []

    async def note(event) -> None:
        came.append(event.target.value.name)

    made.on_upload(note)
    return made._impl.uuid, came


def taken_in(server, browser: Raw) -> None:
    """Wait until all that a browser has said so far has been dealt with."""
    mark = server.gui.add_checkbox("mark", False)
    browser.say(said(type="GuiUpdateMessage", uuid=mark._impl.uuid, updates={"value": True}))
    until(lambda: mark.value, LATE)


def announced(uuid: str, transfer: str, size: int = 1000) -> bytes:
    return said(
        type="FileTransferStartUpload",
        source_component_uuid=uuid,
        transfer_uuid=transfer,
        filename=f"{transfer}.toml",
        mime_type="",
        part_count=1,
        size_bytes=size,
    )


def brought(uuid: str, transfer: str, content: bytes) -> bytes:
    return said(
        type="FileTransferPart",
        source_component_uuid=uuid,
        transfer_uuid=transfer,
        part_index=0,
        content=content,
    )


@pytest.mark.parametrize("camera", [True, False])
def test_files_that_are_announced_and_never_come_take_nobodys_place(server, button, count, camera):
    accept_uploads(server, 10_000)
    uuid, came = button
    for k in range(AT_ONCE + 1):
        with Raw(server.get_port(), camera=camera) as stranger:
            stranger.say(announced(uuid, f"lost {k}"))
            stranger.line.ping().wait(LATE)
    until(lambda: not server._websock_server._live_connections, LATE)
    assert not server.gui._current_file_upload_states
    with Raw(server.get_port()) as browser:
        browser.say(announced(uuid, "plan", 3) + brought(uuid, "plan", b"abc"))
        until(lambda: came == ["plan.toml"], LATE)
    count(files=AT_ONCE + 1, connections=AT_ONCE + 1)


def test_files_that_stand_still_make_room(server, button):
    now = [0.0]
    accept_uploads(server, 10_000, clock=lambda: now[0])
    uuid, came = button
    under_way = server.gui._current_file_upload_states
    idlers = [Raw(server.get_port()) for _ in range(AT_ONCE)]
    for k, idler in enumerate(idlers):
        idler.say(announced(uuid, f"slow {k}"))
    until(lambda: len(under_way) == AT_ONCE, LATE)
    with Raw(server.get_port()) as browser:
        browser.say(announced(uuid, "early", 3))
        taken_in(server, browser)
        assert "early" not in under_way
        now[0] = uploads.STANDSTILL + 1.0
        browser.say(announced(uuid, "late", 3) + brought(uuid, "late", b"abc"))
        until(lambda: came == ["late.toml"], LATE)
        assert not under_way
    for idler in idlers:
        idler.line.close()


def test_nobody_takes_the_place_of_anothers_file(server, button):
    accept_uploads(server, 10_000)
    uuid, came = button
    under_way = server.gui._current_file_upload_states
    with Raw(server.get_port()) as browser, Raw(server.get_port()) as thief:
        browser.say(announced(uuid, "plan", 3))
        until(lambda: "plan" in under_way, LATE)
        thief.say(announced(uuid, "plan", 2))
        taken_in(server, thief)
        assert under_way["plan"]["total_bytes"] == 3
        browser.say(brought(uuid, "plan", b"abc"))
        until(lambda: came == ["plan.toml"], LATE)
