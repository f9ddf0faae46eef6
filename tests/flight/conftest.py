"""Trims that several tests look at, searched once."""

import pytest

from agents.flight.trim import trim


@pytest.fixture(scope="session")
def trims():
    """Level flights by speed (m/s), at 1.5 Hz and R = 20 deg."""
    made = {3.5: trim()}
    for speed, near in ((4.0, 3.5), (5.0, 4.0), (6.0, 5.0), (3.0, 3.5)):
        made[speed] = trim(speed=speed, near=made[near])
    return made
