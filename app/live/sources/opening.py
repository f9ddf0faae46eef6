"""The kinds of source by name: a new one is a file beside this and one line here."""

from __future__ import annotations

from collections.abc import Callable

from app.live.sources import mocap, recorded
from app.live.sources.address import Address, parsed
from app.live.sources.source import Source
from worlds.refusal import unknown

OPENERS: dict[str, Callable[[Address], Source]] = {
    "vicon": mocap.opened,
    "optitrack": mocap.opened,
    "qualisys": mocap.opened,
    "vrpn": mocap.opened,
    "mock": mocap.opened,
    "recorded": recorded.opened,
}


def open_source(text: str) -> Source:
    """The source that a text such as `optitrack:192.168.1.5?up=y` names, not yet connected.

    Raises Refusal in one line if there is no such kind, option or file, or its package is missing.
    """
    address = parsed(text)
    if address.kind not in OPENERS:
        raise unknown("kind of source", address.kind, OPENERS, text)
    return OPENERS[address.kind](address)
