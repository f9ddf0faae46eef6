"""The ends of a laboratory, driven by its rule; importing a rule takes long, opening ends not."""

from __future__ import annotations

from app.live.laboratory.lab import Lab
from app.live.operating.ends import Ends, open_ends
from app.live.operating.squashing_driver import FlockDriver


def open_driven(lab: Lab) -> Ends:
    """The ends that the laboratory's file names, real or in software, driven by its rule.

    Raises Refusal.
    """
    return open_ends(lab, FlockDriver(lab))
