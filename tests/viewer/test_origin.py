"""Who may talk to the laboratory."""

from __future__ import annotations

import socket

import pytest

from app.viewer.origin import trusted

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
    assert trusted(host, origin)


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
        (None, None),
        ("", ""),
    ],
)
def test_foreign_pages_and_foreign_names_may_not(host, origin):
    assert not trusted(host, origin)
