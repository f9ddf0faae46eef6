"""What browsers give to controls and handles, before viser and other browsers see it."""

from __future__ import annotations

from typing import Any

import viser
from viser import _messages as messages

from app.viewer.web.incoming.rate_limit import RateLimit
from app.viewer.web.values import UnusableError, is_pose, usable

PRESSES = (10.0, 20.0)
"""Presses of buttons by one browser, a second and at once; a value costs far less than what a
button begins."""
BUTTONS = (viser.GuiButtonHandle, viser.GuiButtonGroupHandle)


class ButtonPresses:
    """The presses of every browser that is there; used by viser's thread."""

    def __init__(self) -> None:
        self.limits: dict[int, RateLimit] = {}

    def take(self, browser: int) -> bool:
        """Whether a browser may press a button now."""
        return self.limits.setdefault(browser, RateLimit(*PRESSES)).take()

    def forget(self, browser: int) -> None:
        """A browser is gone."""
        self.limits.pop(browser, None)


def guard(server: viser.ViserServer) -> None:
    """Look at all that browsers give to the controls of a server."""
    presses = ButtonPresses()
    guard_controls(server.gui, presses)

    async def guard_own(client: viser.ClientHandle) -> None:
        guard_controls(client.gui, presses)

    async def forget(client: viser.ClientHandle) -> None:
        presses.forget(client.client_id)

    server.on_client_connect(guard_own)
    server.on_client_disconnect(forget)


def guard_controls(gui: viser.GuiApi, presses: ButtonPresses) -> None:
    """Clamp what browsers send before viser, callbacks and other browsers see it.

    What comes of a browser that is not there, or no more, is neither stored nor shown.
    """
    accept = gui._handle_gui_updates

    async def accept_usable(client_id: Any, message: messages.GuiUpdateMessage) -> None:
        if gui._resolve_client(client_id) is None:
            return
        if not isinstance(message.uuid, str) or not isinstance(message.updates, dict):
            return
        control = gui._gui_input_handle_from_uuid.get(message.uuid)
        if control is None or set(message.updates) != {"value"}:
            return
        if isinstance(control, BUTTONS) and not presses.take(client_id):
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

    line = gui._websock_interface
    line.unregister_handler(messages.GuiUpdateMessage)
    line.register_handler(messages.GuiUpdateMessage, accept_usable)
    guard_drags(line)


def guard_drags(line: Any) -> None:
    """Drop drags that lead nowhere: viser keeps what is sent, and nobody could draw it again."""
    kind = messages.TransformControlsUpdateMessage
    handlers = tuple(line._incoming_handlers[kind])

    async def accept_usable(client_id: Any, message: messages.TransformControlsUpdateMessage):
        if is_pose(message.position, message.wxyz):
            for handler in handlers:
                await handler(client_id, message)

    line.unregister_handler(kind)
    line.register_handler(kind, accept_usable)
