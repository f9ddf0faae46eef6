"""Rooms of real cars without cars, for every test of the viewer."""

from __future__ import annotations

import pytest

from tests.viewer.live_rooms import Rooms


@pytest.fixture
def enter():
    """Makes rooms with stub desks."""
    with Rooms() as rooms:
        yield rooms


@pytest.fixture
def desks(enter):
    """The desks of these rooms."""
    return enter.desks
