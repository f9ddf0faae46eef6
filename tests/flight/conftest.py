"""Trims that several tests look at, each searched once, when one looks at it first."""

import pytest

from agents.flight.trim import Trim, trim

SPEEDS = (3.0, 3.5, 4.0, 5.0, 6.0)


class Trims(dict[float, Trim]):
    """Level flights by speed (m/s), at 1.5 Hz and R = 20 deg."""

    def __missing__(self, speed: float) -> Trim:
        """Search it from its neighbour."""
        if speed == 3.5:
            self[speed] = trim()
        else:
            at = SPEEDS.index(speed)
            self[speed] = trim(speed=speed, near=self[SPEEDS[at + (1 if speed < 3.5 else -1)]])
        return self[speed]


@pytest.fixture(scope="session")
def trims():
    return Trims()
