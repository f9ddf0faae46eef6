"""An emulated XBee S2C for IEEE 802.15.4 in API mode, written from the frame tables of its manual.

It knows the API frames that opening a radio and sending to a 16-bit address take. What it is told
to send is handed to `on_air`.
"""

from __future__ import annotations

import os
import pty
import select
import threading
import tty

DELIMITER = 0x7E
AT_COMMAND, AT_QUEUED, AT_ANSWER = 0x08, 0x09, 0x88
TX_16, TX_STATUS = 0x01, 0x89
SETTINGS = {
    b"AP": b"\x01",  # API mode without escapes
    b"HV": b"\x2e\x41",  # XB24C
    b"VR": b"\x20\x03",  # firmware 2xxx: 802.15.4
    b"SH": b"\x00\x13\xa2\x00",
    b"SL": b"\x41\x5a\x10\x01",
    b"NI": b"lab",
    b"MY": b"\x00\x01",
    b"CE": b"\x00",
}


def api_frame(data):
    """Delimiter, length, data, and the checksum that makes the sum of the data 0xFF."""
    head = bytes([DELIMITER]) + len(data).to_bytes(2, "big")
    return head + data + bytes([0xFF - sum(data) % 256])


class Radio:
    """Answers on a pseudo-terminal; `settings` replaces some of the radio's settings."""

    def __init__(self, on_air=None, answers=True, **settings):
        self.end, self.other = pty.openpty()
        tty.setraw(self.other)
        self.port = os.ttyname(self.other)
        self.settings = SETTINGS | {name.encode(): value for name, value in settings.items()}
        self.on_air = on_air
        self.answers = answers
        self.asked = []
        self.sizes = []
        self.waiting = bytearray()
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.ended.set()
        self.thread.join(timeout=2.0)
        os.close(self.other)
        os.close(self.end)

    def stall(self):
        """Read nothing any more."""
        self.ended.set()
        self.thread.join(timeout=2.0)

    def run(self):
        while not self.ended.is_set():
            if select.select([self.end], [], [], 0.02)[0]:
                self.waiting += os.read(self.end, 4096)
                while (data := self.next_frame()) is not None:
                    self.take(data)

    def next_frame(self):
        start = self.waiting.find(DELIMITER)
        if start < 0 or len(self.waiting) < start + 3:
            return None
        length = int.from_bytes(self.waiting[start + 1 : start + 3], "big")
        end = start + 3 + length + 1
        if len(self.waiting) < end:
            return None
        data = bytes(self.waiting[start + 3 : end - 1])
        assert (sum(data) + self.waiting[end - 1]) % 256 == 0xFF
        del self.waiting[:end]
        self.sizes.append(end - start)
        return data

    def take(self, data):
        if data[0] in (AT_COMMAND, AT_QUEUED):
            name = data[2:4]
            self.asked.append(name.decode())
            known = name in self.settings
            value = self.settings.get(name, b"")
            self.say(bytes([AT_ANSWER, data[1]]) + name + bytes([0 if known else 2]) + value)
        elif data[0] == TX_16:
            if self.on_air:
                self.on_air(int.from_bytes(data[2:4], "big"), data[5:])
            if data[1]:
                self.say(bytes([TX_STATUS, data[1], 0]))

    def say(self, data):
        if self.answers:
            os.write(self.end, api_frame(data))
