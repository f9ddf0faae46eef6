"""Rooms of real cars without cars, for every test of the viewer."""

from __future__ import annotations

import pytest

from tests.viewer.live_sessions import Sessions


@pytest.fixture
def enter():
    """Makes rooms with stub desks."""
    with Sessions() as sessions:
        yield sessions


@pytest.fixture
def operators(enter):
    """The desks of these rooms."""
    return enter.operators
