"""The kinds of source by name: a new one is a file beside this and one line here, or a plug-in."""

from __future__ import annotations

from collections.abc import Callable

from app.live.device_kinds import SIMULATED, kind_of
from app.live.sources import mocap, recorded_source
from app.live.sources.pose_source import Source
from app.live.sources.source_address import Address, parse_address
from worlds.input_error import InputError, unknown
from worlds.plug_ins import plug_ins

Opener = Callable[[Address], Source]
"""Makes a source, not yet connected; raises InputError if it cannot."""

BUILT_IN: dict[str, Opener] = {
    "vicon": mocap.open_mocap,
    "optitrack": mocap.open_mocap,
    "qualisys": mocap.open_mocap,
    "vrpn": mocap.open_mocap,
    "mock": mocap.open_mocap,
    "recorded": recorded_source.open_recording,
}


def source_of_entry(name: str, thing: object) -> tuple[str, Opener]:
    """The source that an entry point brings. Raises TypeError if it opens nothing."""
    if not callable(thing):
        raise TypeError(f"a function is needed, not {type(thing).__name__}")
    return name, thing


OPENERS = BUILT_IN | plug_ins("flockscope.sources", source_of_entry, {*BUILT_IN, SIMULATED})
"""All kinds of source: the built-in ones, then those of other packages, which replace none."""


def open_source(text: str) -> Source:
    """The source that a text such as `optitrack:192.168.1.5?up=y` names, not yet connected.

    Raises InputError in one line if there is no such kind, option or file, or its package is
    missing.
    """
    if kind_of(text) == SIMULATED:
        raise InputError(f"source {text!r} has cars to show only where a laboratory is opened")
    address = known_source(text)
    return OPENERS[address.kind](address)


def known_source(text: str) -> Address:
    """The parts of a text. Raises InputError if it is none of a source, or there is no such kind.

    The kind `simulated` is opened together with its link, by `app.live.emulation.emulated_cars`.
    """
    address = parse_address(text)
    if address.kind not in OPENERS:
        raise unknown("kind of source", address.kind, (*OPENERS, SIMULATED), text)
    return address
