"""Emulated cars at the other end of a pseudo-terminal or a datagram port, moved in real time."""

from __future__ import annotations

import os
import select
import socket
import threading
import time
from collections.abc import Callable
from typing import Protocol

from app.live.links.firmware import Firmware
from worlds.input_error import InputError

RATE = 200.0
"""Times per second at which the plant is moved."""
AT_ONCE = 4096
"""Bytes read at a time."""

Plant = Callable[[float, dict[int, tuple[float, float]]], None]
"""Called with the time (time.monotonic(), s) and (steer, throttle) of every car by address."""
Air = Callable[[bytes], bytes]
"""What of the bytes sent arrives: loses or changes some, in a test."""


class CarStream(Protocol):
    """Where bytes come from."""

    link: str
    """The text of the link that leads there."""

    def fileno(self) -> int:
        """What to wait for."""
        ...

    def read(self) -> bytes:
        """What has come."""
        ...

    def close(self) -> None:
        """Let go of it."""
        ...


class Terminal:
    """A pseudo-terminal: a serial port with nothing but this at the other end."""

    def __init__(self) -> None:
        try:
            import pty
            import tty
        except ImportError:
            raise InputError(
                "this system has no pseudo-terminals: emulate the cars over udp"
            ) from None
        self.end, self.other = pty.openpty()
        tty.setraw(self.other)  # before anybody opens it: what is written is not echoed
        self.port = os.ttyname(self.other)
        self.link = f"serial:{self.port}"

    def fileno(self) -> int:
        """See Stream."""
        return self.end

    def read(self) -> bytes:
        """See Stream."""
        return os.read(self.end, AT_ONCE)

    def close(self) -> None:
        """See Stream."""
        os.close(self.other)
        os.close(self.end)


class Datagrams:
    """A datagram port of this machine, any that is free unless one is given."""

    def __init__(self, port: int = 0):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self.socket.bind(("127.0.0.1", port))
        except OSError as error:
            self.socket.close()
            raise InputError(f"udp port {port} cannot be listened to: {error.strerror}") from None
        self.link = f"udp:127.0.0.1:{self.socket.getsockname()[1]}"

    def fileno(self) -> int:
        """See Stream."""
        return self.socket.fileno()

    def read(self) -> bytes:
        """See Stream."""
        return self.socket.recv(AT_ONCE)

    def close(self) -> None:
        """See Stream."""
        self.socket.close()


class EmulatedCars:
    """Runs firmware on a stream in a thread of its own and moves a plant with what it says.

    Used with `with`; `link` is the text of the link that leads to the cars.
    """

    def __init__(
        self,
        firmware: Firmware,
        plant: Plant,
        stream: CarStream,
        air: Air | None = None,
        rate: float = RATE,
    ):
        self.firmware = firmware
        self.plant = plant
        self.stream = stream
        self.air = air
        self.period = 1.0 / rate
        self.link = stream.link
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self.run, name="emulated cars", daemon=True)

    def __enter__(self) -> EmulatedCars:
        self.thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def run(self) -> None:
        """Read what comes and move the plant, until closed."""
        due = time.monotonic()
        while not self.ended.is_set():
            now = time.monotonic()
            if now >= due:
                self.plant(now, self.firmware.drive(now))
                due = max(due + self.period, now)
            if select.select([self.stream], [], [], max(0.0, due - time.monotonic()))[0]:
                data = self.stream.read()
                self.firmware.feed(self.air(data) if self.air else data, time.monotonic())

    def close(self) -> None:
        """Stop; once only."""
        if not self.ended.is_set():
            self.ended.set()
            self.thread.join(timeout=2.0)
            self.stream.close()
