"""The server keeps its port, its visitors and its values in hand."""

from __future__ import annotations

import math
import socket
from typing import Any

import msgspec
import pytest
import viser
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from app.front.http_server import listen
from app.front.server import UNWANTED, admit_browsers, close_server, open_server
from tests.live.stand_in import CAMERA
from tests.viewer.waiting import until
from worlds.input_error import InputError


@pytest.fixture(scope="module")
def server():
    opened = open_server(port=0)
    admit_browsers(opened)
    yield opened
    close_server(opened)


def address(server: viser.ViserServer) -> str:
    return f"ws://localhost:{server.get_port()}"


def join(server: viser.ViserServer, origin: str | None = None):
    """A browser without a screen, which introduces itself."""
    client = connect(address(server), origin=origin, subprotocols=[f"viser-v{viser.__version__}"])
    say(client, **CAMERA)
    return client


def say(client: Any, **message: Any) -> None:
    client.send(msgspec.msgpack.encode(message))


def test_a_busy_port_is_refused_in_one_line_and_not_changed():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"port {port} on 127.0.0.1 cannot be used") as refused:
            open_server(port=port)
    assert "\n" not in str(refused.value)


def test_a_port_can_be_used_again_at_once():
    first = open_server(port=0)
    port = first.get_port()
    close_server(first)
    second = open_server(port=port)
    assert second.get_port() == port
    close_server(second)


@pytest.mark.parametrize("host", ["192.0.2.1", "no-such-host.invalid"])
def test_a_host_that_is_not_this_machine_is_refused(host):
    with pytest.raises(InputError, match=host) as refused:
        listen(host, 0)
    assert "Unknown error" not in str(refused.value)


def test_nothing_is_printed(capfd):
    close_server(open_server(port=0))
    assert capfd.readouterr() == ("", "")


def test_it_listens_on_this_machine_alone():
    sock = listen("127.0.0.1", 0)
    assert sock.getsockname()[0] == "127.0.0.1"
    sock.close()


def test_programs_and_own_pages_get_in(server):
    for origin in (None, f"http://127.0.0.1:{server.get_port()}"):
        with join(server, origin) as client:
            assert client.recv(timeout=60)


@pytest.mark.parametrize("origin", ["https://example.org", "null", "http://localhost:1"])
def test_foreign_pages_do_not(server, origin):
    with pytest.raises(InvalidStatus) as refused:
        join(server, origin)
    assert refused.value.response.status_code == 403


def test_nobody_can_open_a_tunnel_or_upload(server):
    for kind in UNWANTED:
        assert kind not in server._websock_server._incoming_handlers


@pytest.mark.parametrize(
    ("sent", "got"),
    [
        (3.5, 3.5),
        (7, 6.28),
        (-1e300, 0.0),
        (math.inf, 6.28),
        (math.nan, 1.0),
        ("3", 1.0),
        (True, 1.0),
        (None, 1.0),
        ([1, 2], 1.0),
        ({"__class__": 1}, 1.0),
    ],
)
def test_a_slider_takes_only_what_is_in_its_range(server, sent, got):
    slider: Any = server.gui.add_slider("eta", 0.0, 6.28, 0.01, 1.0)
    mark: Any = server.gui.add_checkbox("mark", False)
    with join(server) as client:
        say(client, type="GuiUpdateMessage", uuid=slider._impl.uuid, updates={"value": sent})
        say(client, type="GuiUpdateMessage", uuid=mark._impl.uuid, updates={"value": True})
        until(lambda: mark.value)
        assert slider.value == got
        assert type(slider.value) is float


@pytest.mark.parametrize(
    "updates",
    [{"update_cb": []}, {"removed": True}, {"value": 2.0, "props": None}, {}, {"nonsense": 1}],
)
def test_nothing_but_a_value_can_be_changed(server, updates):
    slider: Any = server.gui.add_slider("eta", 0.0, 6.28, 0.01, 1.0)
    mark: Any = server.gui.add_checkbox("mark", False)
    before = dict(vars(slider._impl))
    with join(server) as client:
        say(client, type="GuiUpdateMessage", uuid=slider._impl.uuid, updates=updates)
        say(client, type="GuiUpdateMessage", uuid=mark._impl.uuid, updates={"value": True})
        until(lambda: mark.value)
    assert vars(slider._impl) == before


def test_a_choice_that_is_not_offered_is_not_taken(server):
    choice: Any = server.gui.add_dropdown("colour", ("heading", "layer"))
    with join(server) as client:
        for value in ("__import__('os')", 1, None, "layer"):
            say(client, type="GuiUpdateMessage", uuid=choice._impl.uuid, updates={"value": value})
        until(lambda: choice.value == "layer")


def test_a_clamped_value_is_told_to_the_browser_that_sent_it(server):
    slider: Any = server.gui.add_slider("eta", 0.0, 6.28, 0.01, 1.0)
    with join(server) as client:
        while True:
            try:
                client.recv(timeout=0.5)
            except TimeoutError:
                break
        say(client, type="GuiUpdateMessage", uuid=slider._impl.uuid, updates={"value": 99.0})
        until(lambda: slider.value == 6.28)
        assert client.recv(timeout=60)
