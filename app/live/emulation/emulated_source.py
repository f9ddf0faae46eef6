"""Emulated cars: the source that tracks them and the link that leads to them."""

from __future__ import annotations

from app.live.device_kinds import SIMULATED, kind_of, port_of
from app.live.emulation.emulated_room import RoomBuilder, free_port
from app.live.laboratory.lab_file import Lab
from app.live.link_address import LinkAddress
from app.live.links.link import CarLink
from app.live.links.link_catalogue import open_link
from app.live.links.udp import open_udp
from app.live.sources.pose_source import Source
from app.live.sources.simulated_source import SimulatedSource


def open_emulated(lab: Lab) -> tuple[Source, CarLink]:
    """The source of emulated cars, not yet connected, and the link to them, open.

    With the link `dry` there are cars too, and nothing is sent to them. Raises InputError.
    """
    to_cars = kind_of(lab.link) == SIMULATED
    port = (port_of(lab.link) if to_cars else 0) or free_port()
    link = udp_link(lab.link, port) if to_cars else open_link(lab.link)
    return SimulatedSource(RoomBuilder(lab.to_toml(), port), title="emulated cars"), link


def udp_link(name: str, port: int) -> CarLink:
    """A link to a UDP port of this machine."""
    return open_udp(LinkAddress(name, "udp", f"127.0.0.1:{port}", {}))
