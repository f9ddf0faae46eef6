"""Names of links and how each is opened; links of a laboratory's own enter here."""

from __future__ import annotations

import runpy
from collections.abc import Callable
from pathlib import Path

from app.live.device_kinds import FILE, SIMULATED, kind_of
from app.live.link_address import LinkAddress, read_place
from app.live.links.chain import open_chain
from app.live.links.dry import open_dry
from app.live.links.link import CarLink
from app.live.links.serial_link import open_serial
from app.live.links.udp import open_udp
from app.live.links.xbee import open_xbee
from worlds.input_error import InputError, unknown
from worlds.plug_ins import plug_ins

Opener = Callable[[LinkAddress], CarLink]
"""Opens a link; raises InputError if it cannot."""
ENTRY = "open_link"
"""What the file of a link calls its opener."""

BUILT_IN: dict[str, Opener] = {
    "serial": open_serial,
    "xbee": open_xbee,
    "udp": open_udp,
    "chain": open_chain,
    "dry": open_dry,
}


def collect() -> dict[str, Opener]:
    """All kinds of link: the built-in ones, then those of other packages, which replace none."""
    return BUILT_IN | plug_ins("flockscope.links", link_of_entry, BUILT_IN)


def link_of_entry(name: str, thing: object) -> tuple[str, Opener]:
    """The link that an entry point brings. Raises TypeError if it opens nothing."""
    if not callable(thing):
        raise TypeError(f"a function is needed, not {type(thing).__name__}")
    return name, thing


LINKS = collect()


def open_link(text: str, folder: Path | None = None) -> CarLink:
    """Open the link that a text names, as `serial:/dev/ttyUSB0?baud=57600`.

    The kind may be a Python file, as `my_radio.py:/dev/ttyACM0`, looked for in `folder`, the
    working directory if there is none. That runs the file: the text must come from the person who
    runs the laboratory, never from a browser. Raises InputError.
    """
    if kind_of(text) == SIMULATED:
        raise InputError(f"the link {text!r} has cars to reach only where a laboratory is opened")
    place = known_link(text)
    if place.kind.endswith(FILE):
        return load_opener((folder or Path()) / place.kind, text)(place)
    return LINKS[place.kind](place)


def known_link(text: str) -> LinkAddress:
    """The parts of a text. Raises InputError if it is none of a link, or there is no such kind.

    The kind `simulated` is opened together with its source, by
    `app.live.emulation.emulated_cars`.
    """
    place = read_place(text)
    if place.kind not in LINKS and not place.kind.endswith(FILE):
        raise unknown("link", place.kind, (*LINKS, SIMULATED), text)
    return place


def load_opener(file: Path, text: str) -> Opener:
    """The opener in a Python file. Raises InputError if there is none."""
    if not file.is_file():
        raise InputError(f"there is no file {file} (link {text!r})")
    try:
        names = runpy.run_path(str(file))
    except Exception as error:
        raise InputError(f"{file} cannot be run: {type(error).__name__}: {error}") from error
    if not callable(names.get(ENTRY)):
        raise InputError(f"{file} has no function {ENTRY}(place)")
    opener: Opener = names[ENTRY]
    return opener
