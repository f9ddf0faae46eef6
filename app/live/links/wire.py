"""A serial port that is written whole frames at a time and never waited for."""

from __future__ import annotations

import errno
import os
import select
import time
from contextlib import suppress
from typing import Any

from app.live.link_address import LinkAddress
from app.live.links.link import LinkLost
from worlds.input_error import InputError
from worlds.plug_ins import install

# Tells a port that is busy, and drops a frame, from one that takes nothing any more.

MOST_IN_A_ROW = 25
"""Frames: at 100 per second, the time after which the cars' watchdogs have stopped them."""


class StallDetector:
    """Counts the frames in a row for which a port was not free."""

    def __init__(self, name: str):
        self.name = name
        self.in_a_row = 0

    def count_stall(self, free: bool) -> bool:
        """`free`. Raises LinkLost at the last of MOST_IN_A_ROW frames that were not taken."""
        self.in_a_row = 0 if free else self.in_a_row + 1
        if self.in_a_row >= MOST_IN_A_ROW:
            raise LinkLost(f"the link {self.name!r} has taken none of {self.in_a_row} frames")
        return free


LEAST_BAUD, MOST_BAUD = 300, 4_000_000
BITS = 10
"""Bits on the wire per byte: start, eight, stop."""
DRAIN = 0.2
"""Longest time that closing waits for what has been written, s."""
WHY = {
    errno.ENOENT: "there is no such port",
    errno.EACCES: "it is not allowed (is the user in the group that owns the port, as dialout?)",
    errno.EAGAIN: "another program has it open",
    errno.EBUSY: "another program has it open",
}


def describe_port_error(error: OSError) -> str:
    """What went wrong with a port, in words."""
    if error.errno is None:
        return str(error)
    return WHY.get(error.errno, os.strerror(error.errno).lower())


def take_port(place: LinkAddress) -> str:
    """The port that a text names."""
    return place.wants("which port", f"{place.kind}:/dev/ttyUSB0")


def open_wire(place: LinkAddress, baud: int) -> SerialWire:
    """Open the serial port that a text names. Raises InputError."""
    port = take_port(place)
    try:
        import serial
    except ImportError:
        raise InputError(f"the link {place.text!r} needs pyserial: {install('live')}") from None
    try:
        return SerialWire(serial.Serial(port, baud, exclusive=True), place.text)
    except (OSError, ValueError) as error:
        reason = describe_port_error(error) if isinstance(error, OSError) else str(error)
        raise InputError(f"the link {place.text!r} cannot open {port}: {reason}") from None


class SerialWire:
    """A serial port of pyserial, open, for sending; `name` is the text of its link."""

    def __init__(self, port: Any, name: str):
        # To wait for nothing, pyserial must never be asked to write what cannot be written: with
        # no time allowed it spins, with a little it calls what it has written late (see `free`).
        port.timeout = port.write_timeout = 0
        self.port = port
        self.name = name
        self.jam = StallDetector(name)
        self.left = b""
        """The rest of a frame that has been begun."""

    def seconds(self, count: int) -> float:
        """Time that so many bytes take, s."""
        return float(BITS * count / self.port.baudrate)

    def offer(self, frame: bytes) -> bool:
        """Send a frame, unless one is still on its way; whether it was taken.

        Frames go out whole: what the port does not take at once follows with the next offer.
        Raises LinkLost if the port is gone or takes nothing any more.
        """
        try:
            self.port.read(self.port.in_waiting)  # whatever a radio says: it must never wait for us
            self.push()
            if not self.jam.count_stall(free=not self.left and not self.port.out_waiting):
                return False
            self.left = frame
            self.push()
        except LinkLost:
            raise
        except OSError as error:
            raise LinkLost(
                f"the link {self.name!r} is lost: {describe_port_error(error)}"
            ) from None
        return True

    def free(self) -> bool:
        """Whether the port takes at least a byte now."""
        if os.name != "posix":
            return True
        return bool(select.select([], [self.port.fileno()], [], 0.0)[1])

    def push(self) -> None:
        """Write as much of what is left as the port takes."""
        while self.left and self.free():
            self.left = self.left[self.port.write(self.left) or 0 :]

    def drain(self) -> None:
        """Let what has been written go out, for DRAIN at most. Raises OSError if it cannot."""
        until = time.monotonic() + DRAIN
        while (self.left or self.port.out_waiting) and time.monotonic() < until:
            self.push()
            time.sleep(0.002)

    def close(self) -> None:
        """Let what has been written go out, and let go of the port."""
        with suppress(OSError):  # the port may be gone already
            self.drain()
        with suppress(OSError):
            self.port.close()
