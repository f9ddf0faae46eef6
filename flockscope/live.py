"""Real cars: what a source of poses and a link to cars are, and cars in software to try them on.

docs/tracking-source.md has a source of one's own, docs/car-link.md a link.

>>> from flockscope.live import Pose, seen
>>> seen("red", Pose(1.0, 2.0, 0.0)).name
'red'
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
import sys

from app.live.control.pose import MocapFrame, Pose, Sighting, seen, unseen
from app.live.emulation.emulated_cars import EmulatedCars, Terminal
from app.live.link_address import LinkAddress
from app.live.links.command_frame import FULL, levels
from app.live.links.firmware import Firmware
from app.live.links.link import CarLink, LinkLost, shortage
from app.live.links.wire import SerialWire, open_wire
from app.live.sources.feed import Feed
from app.live.sources.pose_source import Source
from app.live.sources.source_address import Address
from app.live.sources.source_catalogue import open_source
from flockscope._old_names import old_names as _old_names
from worlds.input_error import InputError

if TYPE_CHECKING:
    from app.live.links.link_catalogue import open_link
    from app.live.recording.recording_replay import read as read_recording

__all__ = [
    "FULL",
    "Address",
    "CarLink",
    "EmulatedCars",
    "Feed",
    "Firmware",
    "InputError",
    "LinkAddress",
    "LinkLost",
    "MocapFrame",
    "Pose",
    "SerialWire",
    "Sighting",
    "Source",
    "Terminal",
    "levels",
    "open_link",
    "open_source",
    "open_wire",
    "read_recording",
    "seen",
    "shortage",
    "unseen",
]


_old_name = _old_names(
    sys.modules[__name__], {"Place": "LinkAddress", "Refusal": "InputError", "Wire": "SerialWire"}
)


def __getattr__(name: str) -> Any:
    """What is imported when asked for: links of plug-ins, which import this module; recordings."""
    if name == "open_link":
        from app.live.links.link_catalogue import open_link

        return open_link
    if name == "read_recording":
        from app.live.recording.recording_replay import read

        return read
    return _old_name(name)
