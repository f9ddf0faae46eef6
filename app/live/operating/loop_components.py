"""What the control loop of a laboratory stands between: source of poses, link, and driver."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from app.live.control.car_control import CarControl
from app.live.control.control_loop import FrameFeed, Journal, Loop
from app.live.control.driver import Driver
from app.live.control.injected_target import InjectedTarget
from app.live.device_kinds import SIMULATED, kind_of
from app.live.emulation.emulated_source import open_emulated
from app.live.laboratory.lab_file import Lab
from app.live.links.link import CarLink
from app.live.links.link_catalogue import open_link
from app.live.sources.feed import Feed
from app.live.sources.pose_source import Source
from app.live.sources.source_catalogue import open_source

TIMEOUT = 90.0
"""Seconds that the source of emulated cars may take to begin."""
Opener = Callable[[Lab], "LoopComponents"]
"""Opens source, link and driver in the process of the loop: a function of a module."""


@dataclass(frozen=True)
class LoopComponents:
    """The source, the link and the driver of a laboratory, open."""

    feed: FrameFeed
    link: CarLink
    driver: Driver

    def loop(self, lab: Lab, journal: Journal | None = None) -> Loop:
        """The control loop of the laboratory between these ends, unarmed."""
        return Loop(
            CarControl(lab.safety(), self.driver),
            self.feed,
            self.link,
            lab.addresses,
            InjectedTarget(lab.injected, lab.area),
            journal,
            lab.rate,
        )

    def close(self) -> None:
        """Close the source; the loop has closed the link."""
        if isinstance(self.feed, Feed):
            self.feed.close()


def open_ends(lab: Lab, driver: Driver) -> LoopComponents:
    """The source and the link of a laboratory, open, with this driver. Raises InputError."""
    source, link = source_and_link(lab)
    try:
        feed = Feed(source, TIMEOUT) if kind_of(lab.source) == SIMULATED else Feed(source)
        return LoopComponents(feed, link, driver)
    except BaseException:
        link.close()
        raise


def source_and_link(lab: Lab) -> tuple[Source, CarLink]:
    """The source of a laboratory, not yet connected, and its link, open. Raises InputError."""
    if kind_of(lab.source) == SIMULATED:
        return open_emulated(lab)
    source = open_source(lab.source)
    return source, open_link(lab.link)
