"""The texts of sources and links: their kinds, and the names under which they are chosen.

A text is `kind:place?option=value`. One that begins with `simulated` means emulated cars, whose
source and link go together; `app.live.emulation.emulated_cars` opens it.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from app.live.link_address import read_place
from worlds.input_error import InputError

SIMULATED = "simulated"
"""The text of the source of emulated cars, and the kind of the link to them."""
DRY = "dry"
"""The kind of the link that sends nothing, and its text."""
RECORDED = "recorded"
"""The kind of the source that plays a recording."""
EMULATED = "emulated cars"
BUILT_IN_NAMES = {SIMULATED: EMULATED, DRY: "dry run"}
"""The names of a source and a link that may always be chosen, by their texts."""
FILE = ".py"
"""The ending of the kind of a link that is a Python file."""


def kind_of(text: str) -> str:
    """The kind that a text begins with.

    >>> kind_of("serial:/dev/ttyUSB0?baud=57600"), kind_of("simulated?port=5005")
    ('serial', 'simulated')
    """
    return text.partition("?")[0].partition(":")[0]


def name_of(text: str) -> str:
    """The name under which the source or the link of a laboratory's file is chosen.

    >>> name_of("optitrack:192.168.1.5?up=y"), name_of("/home/ann/my_radio.py:/dev/ttyACM0")
    ('optitrack:192.168.1.5?up=y', 'my_radio.py:/dev/ttyACM0')
    """
    kind = kind_of(text)
    if kind == SIMULATED:
        return BUILT_IN_NAMES[SIMULATED]
    if kind.endswith(FILE):
        return Path(kind).name + text.removeprefix(kind)
    return BUILT_IN_NAMES.get(text, text)


def is_same_name(text: str, other: str) -> bool:
    """Whether two names differ in capitals and spaces only.

    >>> is_same_name("Second  room", "second room "), is_same_name("room 1", "room 2")
    (True, False)
    """
    return text.casefold().split() == other.casefold().split()


def demand_name(name: str, others: Iterable[str]) -> None:
    """Refuse a name that cannot be read, or that is like one of the others."""
    if not name.strip() or not name.isprintable():
        raise InputError(f"nothing can be called {name!r}")
    for other in others:
        if is_same_name(name, other):
            raise InputError(f"{name!r} cannot be told from {other!r}")


def port_of(link: str) -> int:
    """The UDP port that emulated cars listen to, `simulated?port=5005`; 0: any.

    Raises InputError if the text says anything else.
    """
    place = read_place(link)
    if place.where:
        raise InputError(f"the link {link!r} leads to the room in software: write {SIMULATED}")
    return place.whole(port=(0, 0, 65535))["port"]
