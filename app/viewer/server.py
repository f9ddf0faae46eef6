"""A viser server that keeps its port, its visitors and its values in hand.

viser takes the next free port when its own is busy, answers pages of any origin, opens a public
tunnel for any browser that asks, and believes what browsers send. This one does none of it.
"""

from __future__ import annotations

import contextlib
import io
import os
import socket
import threading
from collections.abc import Iterator
from typing import Any

import viser
import websockets.asyncio.server
from viser import _messages as messages
from websockets.http11 import Request, Response

from app.viewer.allowance import Allowance
from app.viewer.serving.front import Front
from app.viewer.values import UnusableError, is_pose, usable
from worlds.refusal import Refusal

UNWANTED = (
    messages.ShareUrlRequest,
    messages.ShareUrlDisconnect,
    messages.FileTransferStartUpload,
    messages.FileTransferPart,
    messages.GuiFormSubmitMessage,
    messages.GuiFormDirtyMessage,
)
"""What browsers may send to viser but not to a laboratory."""

starting = threading.Lock()


def open_server(
    host: str = "127.0.0.1", port: int = 8080, front: Front | None = None
) -> viser.ViserServer:
    """A server on exactly this host and port; port 0 takes any free one.

    `front` answers what comes by HTTP; by default one with viser's page alone. Raises Refusal if
    the port is busy or the host is not this machine's.
    """
    answering, quiet = front or Front(), contextlib.redirect_stdout(io.StringIO())
    with starting, served_on(listening(host, port), answering), quiet:
        server = viser.ViserServer(host=host, port=port, label="flockscope", verbose=False)
    for kind in UNWANTED:
        server._websock_server.unregister_handler(kind)
    guard(server.gui)
    server.on_client_connect(guard_client)
    return server


def close_server(server: viser.ViserServer) -> None:
    """Stop a server without a word on standard output."""
    with starting, contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def listening(host: str, port: int) -> socket.socket:
    """A socket that is bound already, so that nobody can take the port in between."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family)
    except (OSError, OverflowError) as error:
        number = getattr(error, "errno", None)
        why = os.strerror(number) if number else str(error)
        raise Refusal(
            f"port {port} on {host} cannot be used: {why}; choose another with --port"
        ) from None


@contextlib.contextmanager
def served_on(sock: socket.socket, front: Front) -> Iterator[None]:
    """Within it, viser serves on this socket, and only what `front` lets in."""
    serve = websockets.asyncio.server.serve

    def serve_here(handler: Any, _host: str, _port: int, *, process_request: Any, **options: Any):
        def answer(connection: Any, request: Request) -> Response | None:
            return front.answer(request, lambda: process_request(connection, request))

        def finish(_connection: Any, _request: Request, response: Response) -> None:
            front.finish(response)

        return serve(handler, sock=sock, process_request=answer, process_response=finish, **options)

    websockets.asyncio.server.serve = serve_here  # type: ignore[misc, assignment]
    try:
        yield
    finally:
        websockets.asyncio.server.serve = serve  # type: ignore[misc]


def guard(gui: viser.GuiApi) -> None:
    """Clamp what browsers send before viser, callbacks and other browsers see it."""
    accept = gui._handle_gui_updates
    allowance = Allowance()

    async def accept_usable(client_id: Any, message: messages.GuiUpdateMessage) -> None:
        if not isinstance(message.uuid, str) or not isinstance(message.updates, dict):
            return
        control = gui._gui_input_handle_from_uuid.get(message.uuid)
        if control is None or set(message.updates) != {"value"}:
            return
        if not isinstance(control, viser.GuiButtonHandle) and not allowance.has(client_id):
            return
        sent = message.updates["value"]
        try:
            value = usable(control, sent)
            await accept(client_id, messages.GuiUpdateMessage(message.uuid, {"value": value}))
        except UnusableError:
            value = control.value
        if value != sent:
            gui._websock_interface.queue_message(
                messages.GuiUpdateMessage(message.uuid, {"value": value})
            )

    gui._websock_interface.unregister_handler(messages.GuiUpdateMessage)
    gui._websock_interface.register_handler(messages.GuiUpdateMessage, accept_usable)
    guard_drags(gui._websock_interface)


def guard_drags(line: Any) -> None:
    """Drop drags that lead nowhere: viser keeps what is sent, and nobody could draw it again."""
    kind = messages.TransformControlsUpdateMessage
    handlers = tuple(line._incoming_handlers[kind])
    allowance = Allowance()

    async def accept_usable(client_id: Any, message: messages.TransformControlsUpdateMessage):
        if allowance.has(client_id) and is_pose(message.position, message.wxyz):
            for handler in handlers:
                await handler(client_id, message)

    line.unregister_handler(kind)
    line.register_handler(kind, accept_usable)


async def guard_client(client: viser.ClientHandle) -> None:
    """Guard the controls and handles that only one browser has."""
    guard(client.gui)
