"""A laboratory driven by its rule; apart from `ends`, as importing rules takes long."""

from __future__ import annotations

from app.live.laboratory.lab_file import Lab
from app.live.operating.flock_driver import FlockDriver
from app.live.operating.loop_components import LoopComponents, open_ends


def open_driven(lab: Lab) -> LoopComponents:
    """Source and link of a laboratory, real or emulated, with its rule as driver.

    Raises InputError.
    """
    return open_ends(lab, FlockDriver(lab))
