"""The ends of a laboratory in software; apart from its room, which is quick to import."""

from __future__ import annotations

from app.live.emulated_room import Build
from app.live.ends import Ends
from app.live.lab import Lab
from app.live.links.links import open_link
from app.live.sources.feed import Feed
from app.live.sources.simulated import Simulated
from app.live.squashing_driver import FlockDriver

PATIENCE = 30.0
"""Seconds that the room may take to begin."""


def open_emulated(lab: Lab) -> Ends:
    """The ends of a laboratory that `emulated` has made. Raises Refusal."""
    driver = FlockDriver(lab)
    link = open_link(lab.link)
    build = Build(lab.to_toml(), int(lab.link.rpartition(":")[2]))
    try:
        return Ends(Feed(Simulated(build, title="emulated cars"), PATIENCE), link, driver)
    except BaseException:
        link.close()
        raise
