"""Checks that the sources and links of a laboratory's file fit together, by their texts alone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from app.live.device_kinds import (
    BUILT_IN_NAMES,
    DRY,
    SIMULATED,
    demand_name,
    kind_of,
    name_of,
    port_of,
)
from app.live.links.link_catalogue import known_link
from app.live.sources.source_catalogue import known_source
from worlds.input_error import InputError

KNOWN = {"sources": known_source, "links": known_link}


class LabFileConflict(ValueError):
    """Values of a laboratory's file that contradict each other, and the keys that lead to them."""

    def __init__(self, words: str, *keys: str):
        super().__init__(words)
        self.keys = keys


def fitted(demand: Callable[[str], object], text: str, *keys: str) -> None:
    """Demand something of a text at these keys. Raises Misfit where `demand` raises InputError."""
    try:
        demand(text)
    except InputError as refused:
        raise LabFileConflict(str(refused), *keys) from None


def demand_matching_ends(source: str, link: str, follows_body: bool) -> None:
    """Source and link are both simulated, or neither is; a simulated injected car has no body.

    Raises Misfit.
    """
    if kind_of(source) != SIMULATED:
        if kind_of(link) == SIMULATED:
            raise LabFileConflict(
                f"link = {link!r} needs source = {SIMULATED!r}, not {source!r}", "link"
            )
        return
    if source != SIMULATED:
        raise LabFileConflict(
            f"source = {source!r} is of software and has no place: {SIMULATED}", "source"
        )
    if kind_of(link) not in (SIMULATED, DRY):
        raise LabFileConflict(
            f"source = {SIMULATED!r} needs link = {SIMULATED!r} or {DRY!r}, not {link!r}", "link"
        )
    if kind_of(link) == SIMULATED:
        fitted(port_of, link, "link")
    if follows_body:
        raise LabFileConflict(
            'injected.path = "body" cannot be emulated: use "circle", "hand" or "none" there',
            "injected",
            "path",
        )


def demand_choices(table: str, own: str, others: Mapping[str, str]) -> None:
    """The names of what may be chosen differ, and their texts are those of sources or links.

    `table` is `sources` or `links`, `own` the one that the file begins with. Raises Misfit.
    """
    names = [name_of(own), *BUILT_IN_NAMES.values()]
    for name, text in others.items():
        fitted(partial(demand_name, others=names), name, table, name)
        names.append(name)
        if kind_of(text) == SIMULATED:
            words = f"{text!r} can be chosen anyway, as {BUILT_IN_NAMES[SIMULATED]!r}"
            raise LabFileConflict(words, table, name)
        fitted(KNOWN[table], text, table, name)
