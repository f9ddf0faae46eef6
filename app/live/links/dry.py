"""`dry`: a link that leads nowhere, to see what would be sent."""

from __future__ import annotations

from app.live.link_address import LinkAddress
from app.live.links.command_frame import CommandFrame, encode
from app.live.links.link import CarLink
from worlds.input_error import InputError

MOST_EVERY = 100_000


class DryLink(CarLink):
    """Checks what is sent as every link does, keeps the last of it, and sends nothing.

    `every` > 0 prints one frame in that many, beginning with the first.
    """

    def __init__(self, name: str = "dry", every: int = 0):
        self.name = name
        self.every = every
        self.sent = 0
        self.last: CommandFrame | None = None
        """The last frame, its commands as they were given."""

    def send(self, seq: int, mode: int, commands: dict[int, tuple[float, float]]) -> None:
        """See CarLink."""
        frame = encode(seq, mode, commands)
        if self.every and self.sent % self.every == 0:
            print(f"{self.name}: {frame.hex(' ')}")
        self.last = CommandFrame(seq, mode, dict(commands))
        self.sent += 1

    def close(self) -> None:
        """See CarLink."""


def open_dry(place: LinkAddress) -> DryLink:
    """`dry`, or `dry?every=100` to print every hundredth frame."""
    if place.where:
        raise InputError(f"the link {place.text!r} leads nowhere: write dry, not {place.where!r}")
    return DryLink(place.text, place.whole(every=(0, 0, MOST_EVERY))["every"])
