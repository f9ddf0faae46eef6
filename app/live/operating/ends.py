"""What the control loop of a laboratory stands between: source of poses, link, and driver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from app.live.control.control import Control
from app.live.control.driver import Driver
from app.live.control.injected import Injected
from app.live.control.loop import Frames, Journal, Loop
from app.live.emulation.ends import open_emulated
from app.live.kinds import SIMULATED, kind_of
from app.live.laboratory.lab import Lab
from app.live.links.link import CarLink
from app.live.links.links import open_link
from app.live.sources.feed import Feed
from app.live.sources.opening import open_source
from app.live.sources.source import Source

PATIENCE = 90.0
"""Seconds that the source of emulated cars may take to begin."""
Opener = Callable[[Lab], "Ends"]
"""Opens source, link and driver in the process of the loop: a function of a module."""


@dataclass(frozen=True)
class Ends:
    """The source, the link and the driver of a laboratory, open."""

    feed: Frames
    link: CarLink
    driver: Driver

    def loop(self, lab: Lab, journal: Journal | None = None) -> Loop:
        """The control loop of the laboratory between these ends, unarmed."""
        return Loop(
            Control(lab.safety(), self.driver),
            self.feed,
            self.link,
            lab.addresses,
            Injected(lab.injected, lab.area),
            journal,
            lab.rate,
        )

    def close(self) -> None:
        """Close the source; the loop has closed the link."""
        if isinstance(self.feed, Feed):
            self.feed.close()


def open_ends(lab: Lab, driver: Driver) -> Ends:
    """The source and the link of a laboratory, open, with this driver. Raises Refusal."""
    source, link = source_and_link(lab)
    try:
        feed = Feed(source, PATIENCE) if kind_of(lab.source) == SIMULATED else Feed(source)
        return Ends(feed, link, driver)
    except BaseException:
        link.close()
        raise


def source_and_link(lab: Lab) -> tuple[Source, CarLink]:
    """The source of a laboratory, not yet connected, and its link, open. Raises Refusal."""
    if kind_of(lab.source) == SIMULATED:
        return open_emulated(lab)
    source = open_source(lab.source)
    return source, open_link(lab.link)
