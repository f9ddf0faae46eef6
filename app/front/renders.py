"""Pictures of the scene that a server asks a browser for: what it draws, at a size of ours.

viser takes such a picture for what the browser says it is, of whatever size, and waits for it in a
thread for ever. Here only a picture that was asked for comes in, once and from whom was asked; it
is looked at before it is unpacked, and who asks is told why there is none.
"""

from __future__ import annotations

import io
import secrets
import threading
import time
from concurrent.futures import Future
from concurrent.futures import TimeoutError as Late
from dataclasses import dataclass, field
from typing import Any

import msgspec
import numpy as np
import viser
from PIL import Image

from app.front.viser_internals import handle_messages, is_connected, messages, send
from worlds.input_error import InputError

LEAST, MOST = 64, 3840
"""Pixels of a side."""
TIMEOUT = 15.0
"""Seconds that a browser has to answer; one whose window is not in front draws nothing."""
LOOK = 0.2
"""Seconds between two looks whether it is there still."""
LOSSLESS = 2_100_000
"""Pixels up to which a picture comes without loss; a larger one would be too long a message."""
QUALITY = 93
GROUND = (246, 248, 251)
"""What is behind the scene on the page, sRGB."""


@dataclass(frozen=True)
class RenderCamera:
    """From where a scene is to be drawn."""

    position: np.ndarray
    wxyz: np.ndarray
    fov: float
    """Vertical, rad."""

    @staticmethod
    def of(camera: viser.CameraHandle) -> RenderCamera:
        """Where a browser's own camera is."""
        return RenderCamera(np.array(camera.position), np.array(camera.wxyz), float(camera.fov))


@dataclass
class PendingPicture:
    """A picture that a browser is to send."""

    browser: int
    came: bool = False
    answer: Future[bytes] = field(default_factory=Future)


class PictureMessage(msgspec.Struct):
    """Of a message with a picture, which one it is."""

    render_uuid: str


named = msgspec.msgpack.Decoder(PictureMessage)


class Renders:
    """What one server has asked for and not got yet; any thread may ask."""

    def __init__(self) -> None:
        self.awaited: dict[str, PendingPicture] = {}
        self.lock = threading.Lock()

    def expects(self, data: bytes) -> bool:
        """Whether a message is the first answer to what was asked; looked at as it comes in."""
        try:
            name = named.decode(data).render_uuid
        except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
            return False
        with self.lock:
            wanted = self.awaited.get(name)
            if wanted is None or wanted.came:
                return False
            wanted.came = True
            return True

    def take(self, browser: Any, message: messages.GetRenderResponseMessage) -> None:
        """A picture has come; viser calls it on its loop."""
        wanted = self.awaited.get(message.render_uuid)
        if wanted is not None and wanted.browser == browser and not wanted.answer.done():
            wanted.answer.set_result(message.payload)

    def ask(
        self,
        client: viser.ClientHandle,
        size: tuple[int, int],
        eye: RenderCamera | None = None,
        exact: bool = False,
        timeout: float = TIMEOUT,
    ) -> np.ndarray:
        """What a browser draws, (height, width, 3) uint8; from its own camera unless `eye` says.

        `exact`: without loss, if it is not too large. It waits: not for viser's own thread. Raises
        InputError if the browser goes, does not answer in time or answers something else.
        """
        wide, tall = size
        exact = exact and wide * tall <= LOSSLESS
        eye = eye or RenderCamera.of(client.camera)
        name, wanted = secrets.token_urlsafe(16), PendingPicture(client.client_id)
        with self.lock:
            self.awaited[name] = wanted
        try:
            request = messages.GetRenderRequestMessage(
                format="image/png" if exact else "image/jpeg",
                height=tall,
                width=wide,
                quality=QUALITY,
                wxyz=numbers(eye.wxyz),
                position=numbers(eye.position),
                fov=eye.fov,
                render_uuid=name,
            )
            send(client, request)
            return decode_picture(self.wait(client, wanted, timeout), size)
        finally:
            with self.lock:
                del self.awaited[name]

    def wait(self, client: viser.ClientHandle, wanted: PendingPicture, timeout: float) -> bytes:
        """What the browser sends. Raises InputError."""
        until = time.monotonic() + timeout
        while True:
            try:
                return wanted.answer.result(min(LOOK, timeout))
            except Late:
                pass
            if not is_connected(client):
                raise InputError("the browser has gone")
            if time.monotonic() > until:
                raise InputError(
                    f"the browser has drawn nothing in {timeout:g} s: is its window in front?"
                )


def numbers(values: np.ndarray) -> Any:
    """An array as a tuple of floats."""
    return tuple(map(float, values))


def decode_picture(payload: bytes, size: tuple[int, int]) -> np.ndarray:
    """The pixels of a picture, (height, width, 3) uint8, before the page's ground.

    Raises InputError for what is no picture, or one of another size, which is never unpacked.
    """
    if not payload:
        raise InputError(f"the browser cannot draw {size[0]} x {size[1]} pixels")
    try:
        found = Image.open(io.BytesIO(payload), formats=("PNG", "JPEG"))
        if found.size == size:
            return before_ground(found)
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        raise InputError("the browser has sent what is no picture") from None
    raise InputError("the browser has drawn another size than it was asked for")


def before_ground(picture: Image.Image) -> np.ndarray:
    """The pixels of a picture, where it is clear those of the page's ground."""
    if picture.mode != "RGBA":
        return np.asarray(picture.convert("RGB"))
    whole = Image.new("RGBA", picture.size, (*GROUND, 255))
    whole.alpha_composite(picture)
    return np.asarray(whole.convert("RGB"))


def accept_renders(server: viser.ViserServer, renders: Renders) -> None:
    """Let the pictures in that were asked for."""
    handle_messages(server, messages.GetRenderResponseMessage, renders.take)
