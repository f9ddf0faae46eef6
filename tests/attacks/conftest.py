"""Servers to attack, each bound to this machine alone."""

from __future__ import annotations

import pytest

from app.front.server import admit_browsers, close_server, open_server


@pytest.fixture
def server():
    opened = open_server(port=0)
    admit_browsers(opened)
    yield opened
    close_server(opened)


@pytest.fixture
def count():
    """Prints what an attack came to, for whoever reads the tests' output."""

    def tell(**counts):
        print("attack:", ", ".join(f"{name} {number}" for name, number in counts.items()))

    return tell
