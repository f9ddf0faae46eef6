"""A browser without a screen: hears what a page says, presses its buttons, says what it likes."""

from __future__ import annotations

import socket
import threading
import time
from typing import Any

import msgspec
import viser
import zstandard
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from tests.live.waiting import until

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [0.0, 0.0, 40.0],
    "fov": 0.3,
    "near": 0.1,
    "far": 100.0,
    "image_height": 900,
    "image_width": 800,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 1.0, 0.0],
}
TIMEOUT = 60.0
"""Seconds that a control may take to appear."""
AGAIN = 5.0
"""Seconds after which the cars are asked to be armed again."""
LITTLE = 4096
"""Bytes of each buffer between the page and a browser that takes nothing."""


class StandIn:
    """One browser, used with `with`; with `reads` False it never takes what it is sent."""

    def __init__(self, port: int, reads: bool = True):
        self.controls: dict[str, dict[str, Any]] = {}
        """What the page has of controls, by uuid: kind, and properties as they are now."""
        self.commands: dict[str, str] = {}
        """The hotkeys: label -> uuid."""
        self.nodes: dict[str, str] = {}
        """The kinds of what is in the scene."""
        self.asked_at = 0.0
        """When it last asked to arm, as `time.monotonic` has it."""
        self.gone = False
        """Whether the page has closed the connection."""
        line = socket.socket()
        if not reads:  # or the kernel takes, megabytes of it, what the browser does not
            line.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, LITTLE)
        line.connect(("127.0.0.1", port))
        self.socket = connect(
            f"ws://localhost:{port}",
            sock=line,
            subprotocols=[f"viser-v{viser.__version__}"],  # type: ignore[list-item]
            max_size=None,
            max_queue=None if reads else 1,
            close_timeout=1.0,
        )
        self.say(**CAMERA)
        if reads:
            threading.Thread(target=self.read, daemon=True).start()

    def __enter__(self) -> StandIn:
        return self

    def __exit__(self, *_: object) -> None:
        self.socket.close()

    def say(self, **message: Any) -> None:
        """Send a message as a browser does."""
        self.socket.send(msgspec.msgpack.encode(message))

    def read(self) -> None:
        """Take what comes, until the page closes."""
        try:
            for data in self.socket:
                assert isinstance(data, bytes)
                size = int.from_bytes(data[8:16], "little")
                inner = zstandard.ZstdDecompressor().decompress(data[16 : 16 + size])
                for message in msgspec.msgpack.decode(inner)["messages"]:
                    self.hear(message)
        except ConnectionClosed:
            pass
        self.gone = True

    def hear(self, message: dict[str, Any]) -> None:
        """Follow what there is on the page."""
        kind, uuid = message["type"], message.get("uuid", "")
        if kind == "GuiUpdateMessage":
            self.controls.get(uuid, {}).update(message["updates"])
        elif kind == "GuiRemoveMessage":
            self.controls.pop(uuid, None)
        elif kind == "RegisterCommandMessage":
            self.commands[message["props"]["label"]] = uuid
        elif kind.startswith("Gui") and "props" in message:
            value = {"value": message["value"]} if "value" in message else {}
            self.controls[uuid] = {"kind": kind} | message["props"] | value
        elif "props" in message and "name" in message:
            self.nodes[message["name"]] = kind

    def found(self, label: str) -> str:
        """The uuid of the control with a label that came last; empty if there is none."""
        with_it = [u for u, one in tuple(self.controls.items()) if one.get("label") == label]
        return with_it[-1] if with_it else ""

    def can(self, label: str) -> bool:
        """Whether the control with a label is there, can be seen and is not disabled."""
        one = self.controls.get(self.found(label), {})
        return bool(one.get("visible")) and not one.get("disabled")

    def set(self, label: str, value: Any) -> None:
        """Give the control with a label a value, as soon as that can be done."""
        until(lambda: self.can(label), TIMEOUT)
        self.say(type="GuiUpdateMessage", uuid=self.found(label), updates={"value": value})

    def press(self, label: str) -> None:
        """Press a button, as soon as that can be done."""
        self.set(label, True)

    def arm(self, code: str) -> None:
        """Arm the cars, and say yes when asked, with the code of the terminal.

        A busy machine may hold the cars before the page asks: then it is pressed again.
        """

        def asked() -> bool:
            if self.can("Arm …") and time.monotonic() > self.asked_at + AGAIN:
                self.asked_at = time.monotonic()
                self.press("Arm …")
            return self.can("Code")

        until(asked, TIMEOUT)
        self.set("Code", code)
        self.press("Arm")

    def stop(self) -> None:
        """Press the emergency stop."""
        self.press("EMERGENCY STOP")
