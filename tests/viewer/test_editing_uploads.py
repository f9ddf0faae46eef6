"""What browsers can send as a file, by a client that keeps to no rules."""

from __future__ import annotations

import contextlib
import threading

import msgspec
import pytest
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from app.front.server import admit_browsers, close_server, open_server
from app.front.uploads import accept_uploads
from tests.viewer.test_laboratory import CAMERA
from tests.viewer.waiting import until

LARGEST = 100


@pytest.fixture
def server():
    made = open_server(port=0)
    accept_uploads(made, LARGEST)
    admit_browsers(made)
    yield made
    close_server(made)


@pytest.fixture
def button(server):
    """An upload button, and what has come through it."""
    made = server.gui.add_upload_button("Open")
    came: list[tuple[str, bytes]] = []

    async def note(event) -> None:
        came.append((event.target.value.name, event.target.value.content))

    made.on_upload(note)
    return made, came


@pytest.fixture
def told(monkeypatch):
    """What browsers are told in notifications."""
    lines: list[str] = []
    monkeypatch.setattr(
        viser.ClientHandle, "add_notification", lambda _, _title, body, **__: lines.append(body)
    )
    return lines


class Client:
    """A browser."""

    def __init__(self, server: viser.ViserServer):
        self.socket = connect(
            f"ws://127.0.0.1:{server.get_port()}",
            subprotocols=[f"viser-v{viser.__version__}"],
            max_size=None,
        )
        threading.Thread(target=self.read, daemon=True).start()
        self.socket.send(msgspec.msgpack.encode(CAMERA))

    def read(self) -> None:
        with contextlib.suppress(ConnectionClosed):
            for _ in self.socket:
                pass

    def start(self, uuid, size, parts, transfer="t", name="a.toml") -> None:
        self.say(
            "FileTransferStartUpload",
            source_component_uuid=uuid,
            transfer_uuid=transfer,
            filename=name,
            mime_type="",
            part_count=parts,
            size_bytes=size,
        )

    def part(self, uuid, index, content, transfer="t") -> None:
        self.say(
            "FileTransferPart",
            source_component_uuid=uuid,
            transfer_uuid=transfer,
            part_index=index,
            content=content,
        )

    def say(self, kind: str, **fields) -> None:
        self.socket.send(msgspec.msgpack.encode({"type": kind, **fields}))


@pytest.fixture
def client(server):
    made = Client(server)
    until(lambda: server.get_clients())
    yield made
    made.socket.close()


def test_a_small_file_comes_through_in_parts(button, client):
    uuid, came = button[0]._impl.uuid, button[1]
    client.start(uuid, 6, 2)
    client.part(uuid, 1, b"def")
    client.part(uuid, 0, b"abc")
    assert until(lambda: came) == [("a.toml", b"abcdef")]


def test_a_large_file_is_never_kept_and_the_browser_is_told(server, button, client, told):
    uuid, came = button[0]._impl.uuid, button[1]
    client.start(uuid, LARGEST + 1, 1)
    client.part(uuid, 0, b"x" * (LARGEST + 1))
    assert until(lambda: told) == ["a.toml was not read: it has 101 bytes, at most 100 are taken"]
    assert not came
    assert not server.gui._current_file_upload_states


def test_a_file_that_grows_beyond_what_was_said_is_dropped(server, button, client):
    uuid, came = button[0]._impl.uuid, button[1]
    client.start(uuid, 5, 3)
    client.part(uuid, 0, b"abc")
    client.part(uuid, 1, b"def")
    until(lambda: not server.gui._current_file_upload_states)
    client.part(uuid, 2, b"g")
    client.start(uuid, 1, 1, "next", "b.toml")
    client.part(uuid, 0, b"h", "next")
    assert until(lambda: came) == [("b.toml", b"h")]


def test_only_upload_buttons_take_files_and_only_one_from_each_browser(
    server, button, client, told
):
    plain = server.gui.add_button("Go")
    slider = server.gui.add_slider("s", 0.0, 1.0, 0.1, 0.5)
    uuid = button[0]._impl.uuid
    for other in (plain._impl.uuid, slider._impl.uuid, "nobody"):
        client.start(other, 3, 1, f"to {other}")
    for wrong in (-1, 10**9):
        client.start(uuid, 3, wrong, f"parts {wrong}")
    client.start(uuid, 3, 1, "first")
    client.start(uuid, 3, 1, "second")
    assert until(lambda: told) == ["a.toml was not read: another file is on its way"]
    assert set(server.gui._current_file_upload_states) == {"first"}


def test_nobody_adds_to_the_file_of_another(server, button, client):
    uuid, came = button[0]._impl.uuid, button[1]
    client.start(uuid, 6, 2)
    until(lambda: server.gui._current_file_upload_states)
    other = Client(server)
    until(lambda: len(server.get_clients()) == 2)
    other.part(uuid, 0, b"xyz")
    other.start(uuid, 2, 1, "mine", "c.toml")
    other.part(uuid, 0, b"ok", "mine")
    until(lambda: came)
    client.part(uuid, 0, b"abc")
    client.part(uuid, 1, b"def")
    until(lambda: len(came) == 2)
    assert came == [("c.toml", b"ok"), ("a.toml", b"abcdef")]
    other.socket.close()


def test_a_browser_that_leaves_takes_its_file_with_it(server, button):
    client = Client(server)
    until(lambda: server.get_clients())
    client.start(button[0]._impl.uuid, 6, 2)
    until(lambda: server.gui._current_file_upload_states)
    client.socket.close()
    until(lambda: not server.gui._current_file_upload_states)
