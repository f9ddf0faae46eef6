"""Real cars: what a source of poses and a link to cars are, and cars in software to try them on.

docs/tracking.md has a source of one's own, docs/car-link.md a link.

>>> from flockscope.live import Pose, seen
>>> seen("red", Pose(1.0, 2.0, 0.0)).name
'red'
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
from app.live.control.pose import MocapFrame, Pose, Sighting, seen, unseen
from app.live.emulation.cars import EmulatedCars, Terminal
from app.live.links.firmware import Firmware
from app.live.links.frame import FULL, levels
from app.live.links.link import CarLink, LinkLost, shortage
from app.live.links.wire import Wire, open_wire
from app.live.place import Place
from app.live.sources.address import Address
from app.live.sources.feed import Feed
from app.live.sources.opening import open_source
from app.live.sources.source import Source
from worlds.refusal import Refusal

if TYPE_CHECKING:
    from app.live.links.links import open_link
    from app.live.recording.replay import read as read_recording

__all__ = [
    "FULL",
    "Address",
    "CarLink",
    "EmulatedCars",
    "Feed",
    "Firmware",
    "LinkLost",
    "MocapFrame",
    "Place",
    "Pose",
    "Refusal",
    "Sighting",
    "Source",
    "Terminal",
    "Wire",
    "levels",
    "open_link",
    "open_source",
    "open_wire",
    "read_recording",
    "seen",
    "shortage",
    "unseen",
]


def __getattr__(name: str) -> Any:
    """What is imported when asked for: links of plug-ins, which import this module; recordings."""
    if name == "open_link":
        from app.live.links.links import open_link

        return open_link
    if name == "read_recording":
        from app.live.recording.replay import read

        return read
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
