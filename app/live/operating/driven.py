"""A laboratory driven by its rule; apart from `ends`, as importing rules takes long."""

from __future__ import annotations

from app.live.laboratory.lab import Lab
from app.live.operating.ends import Ends, open_ends
from app.live.operating.flock_driver import FlockDriver


def open_driven(lab: Lab) -> Ends:
    """Source and link of a laboratory, real or emulated, with its rule as driver.

    Raises Refusal.
    """
    return open_ends(lab, FlockDriver(lab))
