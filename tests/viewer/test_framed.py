"""A page with a secret in its address is nowhere else, and in nobody's frame but those named."""

from __future__ import annotations

import pytest

from app.front.origin import is_trusted, parse_allowed_host
from app.front.page_front import Front
from app.front.server import admit_browsers, close_server, open_server
from tests.viewer.http_client import ask, upgrade

SECRET = "s3cret_-x"
NOTEBOOK = "http://localhost:8888"
FRAME = {"Sec-Fetch-Site": "same-site", "Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "iframe"}


@pytest.fixture(scope="module")
def port():
    front = Front(secret=SECRET, framed_by=(NOTEBOOK, "http://127.0.0.1:8888"))
    server = open_server(port=0, front=front)
    admit_browsers(server)
    yield server.get_port()
    close_server(server)


@pytest.fixture(scope="module")
def plain():
    server = open_server(port=0)
    admit_browsers(server)
    yield server.get_port()
    close_server(server)


def framers(answer) -> str:
    policy = answer.header("Content-Security-Policy")
    return policy.partition("frame-ancestors ")[2].partition(";")[0]


@pytest.mark.parametrize(
    "path",
    ["/", "/alive", "/index.html", "//", f"/{SECRET}x/", f"/{SECRET[:-1]}/", f"/x/{SECRET}/",
     f"/?{SECRET}", f"//{SECRET}/", "/s3cret%5f-x/"],
)  # fmt: skip
def test_without_the_secret_there_is_nothing(port, path):
    answer = ask(port, path)
    assert (answer.status, answer.text) == (404, "there is nothing here\n")
    assert answer.header("X-Frame-Options") == "DENY"
    assert framers(answer) == "'none'"
    assert upgrade(port, f"http://localhost:{port}", path=path).status == 404


def test_with_it_there_is_all(port):
    assert ask(port, f"/{SECRET}/").status == ask(port, f"/{SECRET}").status == 200
    assert ask(port, f"/{SECRET}/index.html").status == 200
    assert ask(port, f"/{SECRET}/alive?x").status == 200
    assert ask(port, f"/{SECRET}/nothing").status == 404
    assert upgrade(port, f"http://localhost:{port}", path=f"/{SECRET}").status == 101


def test_its_page_is_framed_by_those_named_alone(port):
    answer = ask(port, f"/{SECRET}/", FRAME)
    assert answer.status == 200
    assert framers(answer) == f"{NOTEBOOK} http://127.0.0.1:8888"
    assert "x-frame-options" not in answer.headers
    other = ask(port, f"/{SECRET}/alive", FRAME)
    assert framers(other) == "'none'"
    assert other.header("X-Frame-Options") == "DENY"


@pytest.mark.parametrize("kind", ["object", "embed", "script", "image", "empty"])
def test_it_is_used_by_other_pages_in_no_other_way(port, kind):
    assert ask(port, f"/{SECRET}/", FRAME | {"Sec-Fetch-Dest": kind}).status == 403


def test_a_page_without_frames_stays_without(plain):
    assert ask(plain, "/", FRAME).status == 403
    assert framers(ask(plain)) == "'none'"


def test_another_page_opens_no_websocket_though_it_knows_the_secret(port):
    for origin in (NOTEBOOK, "http://example.org", "null", f"https://localhost:{port + 1}"):
        assert upgrade(port, origin, path=f"/{SECRET}").status == 403
    assert upgrade(port, f"http://example.org:{port}", path=f"/{SECRET}").status == 403


def test_who_knows_it_may_come_through_a_proxy_of_any_name(port, plain):
    host = {"Host": "hub.example.org"}
    assert ask(plain, "/", host).status == 403
    answer = ask(port, f"/{SECRET}/", host)
    assert answer.status == 200
    lines = answer.header("Content-Security-Policy").partition("connect-src ")[2].split(";")[0]
    assert "wss://hub.example.org" in lines.split()
    https = "https://hub.example.org"
    assert upgrade(port, https, host="hub.example.org", path=f"/{SECRET}").status == 101
    assert upgrade(port, https, host="hub.example.org:8000", path=f"/{SECRET}").status == 403


@pytest.mark.parametrize(
    ("host", "origin", "may"),
    [
        ("hub.example.org", None, True),
        ("hub.example.org", "https://hub.example.org", True),
        ("hub.example.org:8443", "https://hub.example.org:8443", True),
        ("hub.example.org", "http://hub.example.org", True),
        ("hub.example.org", "https://hub.example.org:8443", False),
        ("localhost:9000", "https://hub.example.org", False),
        ("localhost", "https://example.org", False),
        ("hub.example.org/x", None, False),
        ("", None, False),
        (None, None, False),
        ("hub.example.org", "null", False),
    ],
)
def test_an_invited_request_comes_by_one_name(host, origin, may):
    assert is_trusted(host, origin, invited=True) == may


def test_a_name_that_is_allowed_may_differ_from_the_inner_one():
    named = (parse_allowed_host("hub.example.org"),)
    assert is_trusted("localhost:9000", "https://hub.example.org", named, invited=True)
