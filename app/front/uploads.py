"""Files from browsers: only through an upload button, of bounded size, a few at a time."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import viser

from app.front.viser_internals import UploadStates, handle_messages, messages, send_to_all

AT_ONCE = 4
"""Files on their way at the same time at most."""
MOST_PARTS = 1000
STANDSTILL = 20.0
"""Seconds without a part after which a file is given up."""


def accept_uploads(
    server: viser.ViserServer,
    largest: int,
    clock: Callable[[], float] = time.monotonic,
    bound: str = "at most {} are taken",
) -> None:
    """Let upload buttons take files of up to `largest` bytes; what is more is never kept.

    `bound` says to whom sends more how many are taken.

    A file whose browser leaves, or that stands still, makes room for others.
    """
    uploads = UploadStates(server)
    under_way = uploads.under_way
    heard: dict[str, float] = {}
    """When each file was last heard of, s."""

    def give_up() -> None:
        for transfer in [one for one in heard if one not in under_way]:
            del heard[transfer]
        for transfer in [one for one, then in heard.items() if clock() - then > STANDSTILL]:
            del heard[transfer], under_way[transfer]

    def start(client_id: Any, message: messages.FileTransferStartUpload) -> None:
        if not well_formed(message) or not uploads.has_browser(client_id):
            return
        give_up()
        if message.transfer_uuid in under_way:
            return
        button = uploads.control(message.source_component_uuid)
        own = [one for one in under_way.values() if one["client_id"] == client_id]
        if not isinstance(button, viser.GuiUploadButtonHandle) or button.disabled:
            return
        if message.size_bytes > largest or own or len(under_way) >= AT_ONCE:
            end_progress(server, message)
            too_large = bound.format(largest) if message.size_bytes > largest else ""
            notify_browser(server, client_id, message, too_large)
            return
        uploads.start(client_id, message)
        heard[message.transfer_uuid] = clock()

    def part(client_id: Any, message: messages.FileTransferPart) -> None:
        state = under_way.get(message.transfer_uuid)
        if state is None or state["client_id"] != client_id:
            return
        if not isinstance(message.content, bytes) or type(message.part_index) is not int:
            return
        if state["transferred_bytes"] + len(message.content) > state["total_bytes"]:
            under_way.pop(message.transfer_uuid, None)
            return
        heard[message.transfer_uuid] = clock()
        uploads.add(client_id, message)

    uploads.when_browsers_leave()
    handle_messages(server, messages.FileTransferStartUpload, start)
    handle_messages(server, messages.FileTransferPart, part)


def well_formed(message: messages.FileTransferStartUpload) -> bool:
    """Whether the announcement of a file is one."""
    texts = (message.source_component_uuid, message.transfer_uuid, message.filename)
    numbers = (message.part_count, message.size_bytes)
    return (
        all(isinstance(text, str) and len(text) <= 300 for text in texts)
        and all(type(number) is int and number >= 0 for number in numbers)
        and message.part_count <= MOST_PARTS
    )


def end_progress(server: viser.ViserServer, message: messages.FileTransferStartUpload) -> None:
    """Let the browser think that all has arrived, so that its progress bar goes away."""
    send_to_all(
        server,
        messages.FileTransferPartAck(
            source_component_uuid=message.source_component_uuid,
            transfer_uuid=message.transfer_uuid,
            transferred_bytes=message.size_bytes,
            total_bytes=message.size_bytes,
        ),
    )


def notify_browser(
    server: viser.ViserServer,
    client_id: int,
    message: messages.FileTransferStartUpload,
    too_large: str,
) -> None:
    """Say in the browser that sent it why a file is not taken."""
    client = server.get_clients().get(client_id)
    if client is None:
        return
    why = (
        f"it has {message.size_bytes} bytes, {too_large}"
        if too_large
        else "another file is on its way"
    )
    client.add_notification(
        "flockscope",
        f"{message.filename} was not read: {why}",
        color="red",
        auto_close_seconds=10.0,
    )
