"""What answers by HTTP: headers on every answer, nothing for other pages, no foreign messages."""

from __future__ import annotations

import base64
import hashlib
import os
import re
import socket
import subprocess
import sys

import pytest
import viser

from app.front.client_page import (
    ALPHABET,
    SCRIPTS,
    Scripts,
    client_page,
    from_base88,
    unpack_client,
    viser_page,
)
from app.front.http_server import text_response
from app.front.origin import parse_allowed_host
from app.front.page_front import MOST, Front, foreign_source
from app.front.server import admit_browsers, close_server, open_server
from tests.viewer.http_client import ask, tell, upgrade
from worlds.input_error import InputError


@pytest.fixture(scope="module")
def front():
    made = Front(scripts=("stop-key.js",))
    made.route("/tick", lambda request: text_response(200, f"7 {request.raw_path}"))
    made.route("/broken", lambda _: 1 // 0)
    return made


@pytest.fixture(scope="module")
def port(front):
    server = open_server(port=0, front=front)
    admit_browsers(server)
    yield server.get_port()
    close_server(server)


def directives(answer) -> dict[str, list[str]]:
    rules = (rule.split() for rule in answer.header("Content-Security-Policy").split(";"))
    return {name: values for name, *values in rules}


ANSWERS = [
    ("/", {}, 200),
    ("/index.html", {"Accept-Encoding": "gzip, deflate, br"}, 200),
    ("/?token=1", {}, 200),
    ("/tick?a=1", {}, 200),
    ("/broken", {}, 500),
    ("/nothing", {}, 404),
    ("/../../etc/passwd", {}, 404),
    ("/%2e%2e/%2e%2e/etc/passwd", {}, 404),
    ("//example.org/", {}, 404),
    ("/?websocket=ws://example.org", {}, 400),
    ("/nothing?playbackPath=x", {}, 400),
    ("/", {"Host": "example.org"}, 403),
    ("/", {"Host": "localhost:8080/; script-src *"}, 403),
    ("/", {"Host": "localhost@example.org"}, 403),
    ("/", {"Host": ""}, 403),
    ("/", {"Origin": "https://example.org"}, 403),
    ("/tick", {"Origin": "null"}, 403),
    ("/", {"Sec-Fetch-Site": "cross-site", "Sec-Fetch-Mode": "navigate"}, 403),
    ("/", {"Upgrade": "websocket"}, 400),
    ("/", {"Upgrade": "websocket", "Connection": "Upgrade"}, 400),
    ("/", {"Accept-Encoding": "gzip\r\nAccept-Encoding: br"}, 200),
    ("/", {"Host": "localhost\r\nHost: example.org"}, 400),
    ("/", {"Origin": "http://localhost\r\nOrigin: http://localhost"}, 400),
    ("/", {"Upgrade": "websocket\r\nUpgrade: h2c"}, 400),
]


@pytest.mark.parametrize(("path", "headers", "status"), ANSWERS)
def test_every_answer_has_the_headers(port, path, headers, status):
    answer = ask(port, path, headers)
    assert answer.status == status
    assert answer.header("X-Frame-Options") == "DENY"
    assert answer.header("X-Content-Type-Options") == "nosniff"
    assert answer.header("Referrer-Policy") == "no-referrer"
    assert answer.header("Cross-Origin-Opener-Policy") == "same-origin"
    assert answer.header("Cross-Origin-Resource-Policy") == "same-origin"
    rules = directives(answer)
    assert rules["default-src"] == rules["frame-ancestors"] == rules["base-uri"] == ["'none'"]
    assert rules["form-action"] == ["'none'"]
    if status in (400, 403) and "Upgrade" not in headers:
        assert answer.body.count(b"\n") == 1


def test_a_websocket_has_them_too_and_only_our_own_pages_get_one(port):
    own = upgrade(port, f"http://localhost:{port}")
    assert own.status == 101
    assert own.header("X-Frame-Options") == "DENY"
    for origin in ("https://example.org", "null", f"http://localhost:{port + 1}"):
        assert upgrade(port, origin).status == 403
    assert upgrade(port, f"http://localhost:{port}", path="/?websocket=ws://x").status == 400


def test_what_is_no_http_is_told_so_without_a_word_of_it(port):
    small = f"get / HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n".encode()
    unknown = small.replace(b"get", b"GETS")
    for request in (small, unknown, b"nonsense\r\n\r\n"):
        answer = tell(port, request)
        assert (answer.status, answer.text) == (400, "this is no request\n")
        assert answer.header("X-Frame-Options") == "DENY"


@pytest.mark.parametrize("version", ["1.0", "1.1"])
@pytest.mark.parametrize("path", ["/", "/?a=b", "/index.html", "/alive", "/logo.svg", "/nothing"])
@pytest.mark.parametrize("extra", [{}, {"Accept-Encoding": "gzip"}, {"Origin": "http://b.org"}])
def test_head_gets_the_headers_of_get_and_no_body(port, path, version, extra):
    lines = "".join(f"{name}: {value}\r\n" for name, value in extra.items())
    rest = f" {path} HTTP/{version}\r\nHost: localhost:{port}\r\n{lines}Connection: close\r\n\r\n"
    rest = rest.encode()
    got, head = tell(port, b"GET" + rest), tell(port, b"HEAD" + rest)
    for one in (got, head):
        one.headers.pop("date", None)
    assert (head.status, head.headers) == (got.status, got.headers)
    assert int(head.header("Content-Length")) == len(got.body)
    assert head.body == b""


@pytest.mark.parametrize("method", ["OPTIONS", "DELETE", "PUT", "PATCH", "TRACE", "PROPFIND"])
def test_other_methods_are_told_which_are_answered(port, method):
    answer = ask(port, "/alive", method=method)
    assert answer.status == 405
    assert answer.header("Allow").startswith("GET, HEAD")
    assert "GET and HEAD" in answer.text


def test_no_websocket_is_opened_by_head(port):
    wanted = {"Upgrade": "websocket", "Connection": "Upgrade"}
    answer = ask(port, headers=wanted, method="HEAD")
    assert answer.status == 405
    assert answer.header("Allow") == "GET"


def test_a_request_may_come_byte_by_byte(port):
    whole = f"HEAD /alive HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n".encode()
    with socket.create_connection(("127.0.0.1", port), timeout=60) as line:
        line.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for at in range(len(whole)):
            line.sendall(whole[at : at + 1])
        assert line.makefile("rb").readline() == b"HTTP/1.1 200 OK\r\n"


@pytest.mark.parametrize(("method", "status"), [("POST", 404), ("PUT", 405)])
def test_a_page_without_cars_has_nothing_to_stop(port, method, status):
    answer = tell(port, f"{method} / HTTP/1.1\r\nHost: localhost:{port}\r\n\r\n".encode())
    assert answer.status == status
    assert answer.header("X-Frame-Options") == "DENY"


def test_a_page_opens_websockets_to_its_own_server_alone(port):
    assert directives(ask(port))["connect-src"] == ["'self'", "data:", f"ws://localhost:{port}"]
    by_number = ask(port, headers={"Host": f"127.0.0.1:{port}"})
    assert directives(by_number)["connect-src"][2:] == [f"ws://127.0.0.1:{port}"]
    assert directives(ask(port, headers={"Host": "[::1]:80"}))["connect-src"] == ["'self'", "data:"]


def test_scripts_run_by_their_hash_and_nothing_else_does(port):
    answer = ask(port)
    allowed = directives(answer)["script-src"]
    assert allowed[-1] == "'wasm-unsafe-eval'"
    texts = [text for _, text in Scripts.of(answer.text)]
    own, stop_key = texts[0], texts[-2]
    client = unpack_client(Scripts.of(viser_page())[0][0])
    assert allowed[:-1] == [
        f"'sha256-{base64.b64encode(hashlib.sha256(text).digest()).decode()}'"
        for text in (*map(str.encode, texts), client)
    ]
    assert "replaceState" in own
    assert "flockscopeStopKey" in stop_key
    assert b"RunJavascriptMessage" in client
    assert not re.search(r"<script[^>]+\bsrc=", answer.text)


def test_the_page_brings_its_face(port):
    """No font is taken from elsewhere: what it is written in stands in the page itself."""
    answer = ask(port)
    found = re.search(r"url\(data:font/woff2;base64,([^)]+)\)", answer.text)
    assert base64.b64decode(found[1])[:4] == b"wOF2"
    assert directives(answer)["font-src"] == ["data:"]
    assert len(found[1]) < 120_000


def test_a_server_says_that_it_is_there_and_which_it_is(port):
    other = open_server(port=0)
    try:
        here, again, there = (ask(one, "/alive") for one in (port, port, other.get_port()))
    finally:
        close_server(other)
    assert here.status == 200
    assert here.text == again.text != there.text


def test_a_page_without_scripts_of_its_own_has_those_of_every_page():
    assert len(client_page(()).hashes) == len(SCRIPTS) + 2
    assert client_page(()) is client_page(())


def test_what_other_pages_ask_for_is_refused_but_for_a_link_that_somebody_follows(port):
    def status(site, mode, target, path="/"):
        names = ("Sec-Fetch-Site", "Sec-Fetch-Mode", "Sec-Fetch-Dest")
        return ask(port, path, dict(zip(names, (site, mode, target), strict=True))).status

    assert status("cross-site", "navigate", "document") == 200
    assert status("none", "navigate", "document") == 200
    assert status("same-origin", "no-cors", "empty", "/tick") == 200
    for site in ("cross-site", "same-site"):
        assert status(site, "navigate", "iframe") == 403
        assert status(site, "no-cors", "script") == 403
        assert status(site, "no-cors", "image", "/tick") == 403
        assert status(site, "cors", "empty", "/tick") == 403


@pytest.mark.parametrize(
    ("query", "named"),
    [
        ("websocket=ws://x", "websocket"),
        ("a=1&websocket", "websocket"),
        ("websocket=ws://localhost:8080", "websocket"),
        ("a=1&a=2&WEBSOCKET=ws://x&websocket=", "websocket"),
        ("%77%65bsocket=ws://x", "websocket"),
        ("web+socket=1", "websocket"),
        ("?websocket=x", "websocket"),
        ("%EF%BB%BFwebsocket=x", "websocket"),
        ("playbackPath=http://x/y.viser", "playbackpath"),
        ("%70laybackpath=x", "playbackpath"),
        ("playback%50ath", "playbackpath"),
        ("&".join("a=1" for _ in range(MOST + 1)), f"more than {MOST} parameters"),
        ("darkMode&showStats=1", ""),
        ("next=websocket", ""),
        ("", ""),
        ("&&=&%", ""),
        ("\udcff=1&%ff=1", ""),
    ],
)
def test_queries_that_name_another_source_of_messages(query, named):
    assert foreign_source(query) == named


def test_viser_reads_its_address_in_the_places_that_are_known_here():
    """A new place is to be looked at: what it reads may lead elsewhere, see `query.py`."""
    client = unpack_client(Scripts.of(viser_page())[0][0]).decode()
    assert client.count("URLSearchParams(window.location.search)") == 7
    assert "=`websocket`;" in client
    assert "get(`playbackPath`)" in client
    assert client.count("addEventListener(`message`") == 0


def test_base_88_is_that_of_the_loader():
    loader = Scripts.of(viser_page())[0][1]
    assert ALPHABET.replace("\\", "\\\\") in loader
    for text, value in (("", b""), ("!!!!!", bytes(4)), ("!!!!#", b"\0\0\0\1"), ("#$", b"\x5a")):
        assert from_base88(text) == value
    with pytest.raises(ValueError, match="base 88"):
        from_base88("<")


@pytest.mark.parametrize(
    "page",
    [
        "<html></html>",
        "<head></head>",
        "<head><script>1</script></head>",
        "<head><script data-p='!!!!!' data-ss='1' data-cs='1'>1</script></head>",
        "<head><script data-p='' data-ss='x' data-cs='1'>1</script></head>",
        "<head><script src='a.js'></script><script>2</script></head>",
    ],
)
def test_a_page_that_viser_builds_otherwise_is_refused_in_one_line(monkeypatch, page):
    monkeypatch.setattr("app.front.client_page.viser_page", lambda: page)
    with pytest.raises(InputError, match=f"the page of viser {viser.__version__}") as refused:
        client_page.__wrapped__(())
    assert "\n" not in str(refused.value)


def test_an_allowed_name_reaches_the_page_and_its_websocket():
    front = Front(allow=(parse_allowed_host("hub.example.org"), parse_allowed_host("[::1]:7")))
    server = open_server(port=0, front=front)
    admit_browsers(server)
    try:
        port, inner = server.get_port(), f"localhost:{server.get_port()}"
        for host in ("hub.example.org", f"hub.example.org:{port}", inner):
            page = ask(port, headers={"Host": host})
            assert page.status == 200
            named = ("ws://hub.example.org", "wss://hub.example.org")
            lines = ["'self'", "data:", *dict.fromkeys((f"ws://{host}", *named))]
            assert directives(page)["connect-src"] == lines
            assert upgrade(port, "https://hub.example.org", host).status == 101
            assert upgrade(port, "https://example.org", host).status == 403
        assert ask(port, headers={"Host": "example.org"}).status == 403
    finally:
        close_server(server)


def test_pages_are_read_as_utf_8_whatever_the_machine_is_set_to():
    makes = (
        "from app.viewer.panels.shell import CSS; "
        "from app.classroom.front.entrance import own_page; "
        "from app.front.client_page import client_page; "
        "from app.viewer.lab.scene_requests import SCRIPTS; "
        "own_page('class.html', ('classroom/student.js',)); client_page(SCRIPTS)"
    )
    ascii_ = {"LC_ALL": "C", "PYTHONCOERCECLOCALE": "0", "PYTHONUTF8": "0"}
    subprocess.run([sys.executable, "-c", makes], check=True, env=os.environ | ascii_)
