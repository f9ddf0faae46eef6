"""The frame that is broadcast to all cars, and its reader.

    80 80   sync
    L       bytes from here to the CRC: 3 + 3 per car
    seq     2 bytes, low byte first; counts frames modulo 65536
    mode    0 stop, 1 run, 2 emergency stop
    per car: address (1 to 254), steer, throttle (signed bytes, -127 to 127 for -1 to 1)
    crc     2 bytes, high byte first: CRC-16/CCITT-FALSE of all after the sync

A command is never 80 (-128) and neither is L or a mode, so that a sync cannot stand among them.
The paper's chain of addresses has none of this: one lost byte shifts all that follow for good.
"""

from __future__ import annotations

import binascii
import math
from typing import NamedTuple

from app.live.links.link import MODES, RUN
from worlds.input_error import InputError

SYNC = b"\x80\x80"
FULL = 127
"""What a command of 1 is sent as."""
LEAST_ADDRESS, MOST_ADDRESS = 1, 254
"""0 and 255 are what a blank memory reads."""
MOST_CARS = 30
"""A frame to more would not fit into the 100 bytes of an IEEE 802.15.4 packet."""
HEAD = 3
"""Bytes of sequence and mode, counted by L."""
PER_CAR = 3
AROUND = len(SYNC) + 1 + 2
"""Bytes that L does not count: sync, L itself, CRC."""

PIECE = 64
"""Bytes that are looked at together: the time to read a stream grows with its length only."""


class CommandFrame(NamedTuple):
    """What a frame says."""

    seq: int
    """Modulo 65536."""
    mode: int
    commands: dict[int, tuple[float, float]]
    """(steer, throttle) by address, in [-1, 1]."""


def level(value: float, thing: str) -> int:
    """A command as a whole number, -127 to 127. Raises InputError outside [-1, 1]."""
    if not math.isfinite(value) or not -1.0 <= value <= 1.0:
        raise InputError(f"{thing} = {value:g} is outside [-1, 1]")
    return round(FULL * value)


def levels(mode: int, commands: dict[int, tuple[float, float]]) -> list[tuple[int, int, int]]:
    """(address, steer, throttle) of every car as whole numbers; throttle 0 unless mode is RUN.

    Raises InputError naming the first mode, address or command that no car may be sent.
    """
    if mode not in MODES:
        raise InputError(f"mode = {mode!r} is none of 0 (stop), 1 (run), 2 (emergency stop)")
    if len(commands) > MOST_CARS:
        raise InputError(f"{len(commands)} cars are more than the {MOST_CARS} of a frame")
    result = []
    for address, (steer, throttle) in commands.items():
        if isinstance(address, bool) or not isinstance(address, int):
            raise InputError(f"address = {address!r} is no whole number")
        if not LEAST_ADDRESS <= address <= MOST_ADDRESS:
            raise InputError(f"address = {address} is outside [{LEAST_ADDRESS}, {MOST_ADDRESS}]")
        turn = level(steer, f"steer of car {address}")
        drive = level(throttle, f"throttle of car {address}")
        result.append((address, turn, drive if mode == RUN else 0))
    return result


def size(cars: int) -> int:
    """Bytes of a frame to so many cars."""
    return AROUND + HEAD + PER_CAR * cars


def encode(seq: int, mode: int, commands: dict[int, tuple[float, float]]) -> bytes:
    """The bytes of a frame; see `CarLink.send`. Raises InputError for what no car may be told.

    >>> encode(1, 1, {7: (0.0, 1.0)}).hex(" ")
    '80 80 06 01 00 01 07 00 7f 69 17'
    """
    cars = levels(mode, commands)
    body = bytearray([HEAD + PER_CAR * len(cars)])
    body += (seq & 0xFFFF).to_bytes(2, "little")
    body.append(mode)
    for address, steer, throttle in cars:
        body += bytes([address, steer & 0xFF, throttle & 0xFF])
    return SYNC + bytes(body) + binascii.crc_hqx(body, 0xFFFF).to_bytes(2, "big")


def decode(frame: bytes) -> CommandFrame | None:
    """What a whole frame says, None if anything in it is not as `encode` writes it."""
    body = frame[len(SYNC) : -2]
    if binascii.crc_hqx(body, 0xFFFF) != int.from_bytes(frame[-2:], "big"):
        return None
    mode = body[3]
    commands = {}
    for at in range(1 + HEAD, len(body), PER_CAR):
        address, *pair = body[at : at + PER_CAR]
        steer, throttle = (byte - 256 if byte > FULL else byte for byte in pair)
        if steer < -FULL or throttle < -FULL or address in commands:
            return None
        if not LEAST_ADDRESS <= address <= MOST_ADDRESS:
            return None
        commands[address] = (steer / FULL, throttle / FULL)
    if mode not in MODES or (mode != RUN and any(pair[1] for pair in commands.values())):
        return None
    return CommandFrame(int.from_bytes(body[1:3], "little"), mode, commands)


def is_length(byte: int) -> bool:
    """Whether a frame can have this L."""
    cars, rest = divmod(byte - HEAD, PER_CAR)
    return rest == 0 and 0 <= cars <= MOST_CARS


class Decoder:
    """Reads frames from a stream of bytes with anything lost, changed or put between them.

    Frames count in the order in which they end, whatever stands before them: a sync that is none
    cannot hold up the frames that follow it. What has been understood does not depend on how the
    bytes were cut up.
    """

    def __init__(self) -> None:
        self.waiting = bytearray()
        self.rejected = 0
        """Syncs with a possible length after which no valid frame came."""

    def feed(self, data: bytes) -> list[CommandFrame]:
        """The commands that these bytes complete, oldest first."""
        pieces = range(0, len(data), PIECE)
        return [command for at in pieces for command in self.decode(data[at : at + PIECE])]

    def decode(self, data: bytes) -> list[CommandFrame]:
        """The commands that a few more bytes complete."""
        self.waiting += data
        frames = []
        while (span := self.first_complete()) is not None:
            start, end = span
            command = decode(bytes(self.waiting[start:end]))
            if command is None:
                self.rejected += 1
                self.waiting[start] = 0  # no valid frame has a sync within: none is spoilt
            else:
                frames.append(command)
                del self.waiting[:end]
        self.forget()
        return frames

    def starts(self) -> list[tuple[int, int]]:
        """(start, end) of everything that begins like a frame; the end may be yet to come."""
        candidates = []
        at = self.waiting.find(SYNC)
        while at >= 0:
            length = at + len(SYNC)
            if length >= len(self.waiting):
                candidates.append((at, length + 1))
            elif is_length(self.waiting[length]):
                candidates.append((at, at + AROUND + self.waiting[length]))
            at = self.waiting.find(SYNC, at + 1)
        return candidates

    def first_complete(self) -> tuple[int, int] | None:
        """Of what begins like a frame and is all there, the one that ends first."""
        complete = [(end, at) for at, end in self.starts() if end <= len(self.waiting)]
        if not complete:
            return None
        end, at = min(complete)
        return at, end

    def forget(self) -> None:
        """Drop the bytes that can begin no frame any more."""
        starts = self.starts()
        if starts:
            del self.waiting[: starts[0][0]]
        else:
            del self.waiting[: -1 if self.waiting.endswith(SYNC[:1]) else len(self.waiting)]
