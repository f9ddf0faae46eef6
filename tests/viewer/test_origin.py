"""Who may talk to the laboratory."""

from __future__ import annotations

import socket

import pytest

from app.front.origin import authority, is_trusted, parse_allowed_host
from worlds.input_error import InputError

NAME = socket.gethostname()


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("localhost:8080", "http://localhost:8080"),
        ("127.0.0.1:8080", "http://127.0.0.1:8080"),
        ("localhost:8080", "http://127.0.0.1:8080"),
        ("[::1]:8080", "http://localhost:8080"),
        ("192.168.1.7:8080", "http://192.168.1.7:8080"),
        (f"{NAME}:8080", f"http://{NAME}:8080"),
        ("localhost", "http://localhost"),
        ("LOCALHOST:8080", "http://localhost:8080"),
        ("localhost:8080", None),
    ],
)
def test_own_pages_and_programs_may(host, origin):
    assert is_trusted(host, origin)


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("localhost:8080", "https://example.org"),
        ("localhost:8080", "http://example.org:8080"),
        ("localhost:8080", "http://localhost:9999"),
        ("localhost:8080", "null"),
        ("localhost:8080", ""),
        ("localhost:8080", "http://localhost.example.org:8080"),
        ("localhost:8080", "http://127.0.0.1.example.org:8080"),
        ("localhost:8080", "file://localhost:8080"),
        ("localhost:8080", "http://localhost:port"),
        ("localhost:8080", "http://[::1"),
        ("evil.example:8080", "http://evil.example:8080"),
        ("evil.example:8080", None),
        ("192.168.1.7:8080", "http://192.168.1.8:8080"),
        ("localhost:8080/", None),
        ("localhost:8080/; script-src *", None),
        ("ada@localhost:8080", None),
        ("localhost:", None),
        ("localhost:eighty", None),
        ("localhost 8080", None),
        (None, None),
        ("", ""),
    ],
)
def test_foreign_pages_and_foreign_names_may_not(host, origin):
    assert not is_trusted(host, origin)


HUB = "hub.example.org"


@pytest.mark.parametrize(
    ("name", "host", "origin"),
    [
        # a proxy that passes the name on, or says the inner one
        (HUB, HUB, f"https://{HUB}"),
        (HUB, "localhost:8080", f"https://{HUB}"),
        (HUB, "127.0.0.1:8080", f"http://{HUB}"),
        (f"{HUB}:8443", f"{HUB}:8443", f"https://{HUB}:8443"),
        (f"{HUB}:8443", HUB, f"https://{HUB}:8443"),
        (f"{HUB}:443", "localhost:8080", f"https://{HUB}"),
        # a full name of this machine, without a proxy
        (HUB, f"{HUB}:8080", f"http://{HUB}:8080"),
        (HUB.upper(), f"{HUB}:8080", f"http://{HUB}:8080"),
        (HUB, f"{HUB}:8080", None),
        ("bücher.example", "xn--bcher-kva.example:8080", "http://xn--bcher-kva.example:8080"),
        # what is always let in still is
        (HUB, "localhost:8080", "http://localhost:8080"),
    ],
)
def test_an_allowed_name_may(name, host, origin):
    assert is_trusted(
        host, origin, (parse_allowed_host("other.example.org"), parse_allowed_host(name))
    )
    if HUB in host or (origin and HUB in origin):
        assert not is_trusted(host, origin)


@pytest.mark.parametrize(
    ("name", "host", "origin"),
    [
        (HUB, HUB, "https://example.org"),
        (HUB, f"sub.{HUB}", f"https://sub.{HUB}"),
        (HUB, "localhost:8080", f"https://{HUB}:9999"),
        (HUB, "localhost:8080", f"https://{HUB}.example.org"),
        (HUB, "localhost:8080", "https://ub.example.org"),
        (HUB, "localhost:8080", "null"),
        (HUB, "example.org", f"https://{HUB}"),
        (HUB, f"{HUB}/; script-src *", None),
        (f"{HUB}:8443", "localhost:8080", f"https://{HUB}"),
        (f"{HUB}:8443", HUB, f"https://{HUB}:9999"),
        (HUB, HUB, f"ftp://{HUB}"),
    ],
)
def test_nobody_else_may_for_that(name, host, origin):
    assert not is_trusted(host, origin, (parse_allowed_host(name),))


@pytest.mark.parametrize(
    "text",
    [
        "",
        "http://hub.example.org",
        "hub.example.org/",
        "hub.example.org/user",
        "hub.example.org:",
        "hub.example.org:0",
        "hub.example.org:65536",
        "hub.example.org:http",
        "*",
        "*.example.org",
        "hub example",
        "hub,other",
        "ada@hub",
        "hub;script-src *",
        "hub\n",
        "-hub",
        "hub..org",
        "hub.",
        "a_b",
        "bücher.example/x",
        "x" * 64,
        "::1",
        "[::1",
    ],
)
def test_what_is_no_name_is_refused_in_one_line(text):
    with pytest.raises(InputError, match="is not a host name with an optional port") as refused:
        parse_allowed_host(text)
    assert "\n" not in str(refused.value)


def test_an_authority_is_a_name_and_a_port_and_nothing_else():
    assert [authority(one) for one in ("LOCALHOST:80", "[::1]:80", "10.0.0.1")] == [
        "localhost:80",
        "[::1]:80",
        "10.0.0.1",
    ]
    assert [authority(one) for one in (None, "", "a/", "a?b", "a#b", "b@a", "a:", "[::1")] == [
        None
    ] * 8
