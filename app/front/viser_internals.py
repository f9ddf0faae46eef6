"""All that flockscope uses of viser beyond its public interface, each with the reason why.

Nothing else in the tree touches a private name of viser: a new version of it is tried against this
file. Each part says what would make it unnecessary.
"""

from __future__ import annotations

import asyncio
import contextlib
import functools
import threading
import warnings
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_type_hints

import viser
import websockets.asyncio.server
from viser import _icons
from viser import _messages as messages
from viser._assignable_props_api import AssignablePropsBase
from viser._gui_handles import GuiModalHandle
from viser.infra import _infra
from viser.infra._async_message_buffer import AsyncMessageBuffer
from viser.infra._messages import get_type_hints_cached

__all__ = ["GuiModalHandle", "messages"]

Handler = Callable[[Any, Any], Any]
"""Takes the number of a browser and its message."""

PROTOCOL = f"viser-v{viser.__version__}"
"""The subprotocol of viser's page: it and the server have to be of one version."""
PAGE = Path(viser.__file__).parent / "client" / "build" / "index.html"
"""viser's page, which is served with our scripts. Public once viser takes scripts of its user."""

# A browser may leave while something is drawn for it alone: nobody misses that. Unnecessary once
# viser says so to whoever asks, and not to the terminal.
warnings.filterwarnings("ignore", r"Queued a \w+ on a closed connection", UserWarning)


def identifier(handle: Any) -> str:
    """By what the page knows a control, so that our scripts find it there."""
    return str(handle._impl.uuid)


def message_kinds() -> frozenset[str]:
    """The names of all kinds of messages that viser knows: what has another is dropped unread."""
    return frozenset(messages.Message._subclass_from_type_string())


def message_class(kind: str) -> Any:
    """The dataclass of a kind of message, which says of what shape it is."""
    return messages.Message._subclass_from_type_string()[kind]


def message_hints(kind: str) -> dict[str, Any]:
    """The types of a kind's fields."""
    return get_type_hints_cached(message_class(kind))


def camera_report(camera: viser.CameraHandle) -> object:
    """What a browser has last said of its camera; another object each time that it says something.

    The public properties do not tell whether a browser has moved the camera or a script has.
    """
    return camera._state


def show_background(scene: viser.SceneApi, file: bytes, depth: bytes | None = None) -> None:
    """Draw a PNG or a JPEG over the whole picture: behind everything, or where the grey PNG `depth`
    says, in steps of `DEPTH_STEP`; `set_background_image` would import all of imageio for it."""
    # The page looks at what the files are, not at what the message calls them.
    scene._websock_interface.queue_message(
        messages.BackgroundImageMessage(format="png", rgb_data=file, depth_data=depth)
    )


DEPTH_STEP = (0.00255 + 0.6528 + 167.1168) / 255.0
"""How far ahead of the camera a pixel is whose grey is 1, display units: what the page makes of
three bytes that are equal."""


def add_jpeg(scene: viser.SceneApi, name: str, jpeg: bytes) -> viser.ImageHandle:
    """Add an image whose file is made already; `add_image` would make it anew for each browser."""
    sides = {"render_width": 1.0, "render_height": 1.0, "scale": 1.0}
    props = messages.ImageProps("jpeg", jpeg, cast_shadow=False, receive_shadow=False, **sides)
    message = messages.ImageMessage(name=name, props=props)
    level, middle = (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    return viser.ImageHandle._make(scene, message, name, level, middle, visible=True)


def show_jpeg(image: viser.ImageHandle, jpeg: bytes) -> None:
    """Show another file."""
    image._data = jpeg


def change_updates(message: Any, change: Callable[[str, Any], Any]) -> None:
    """Change the values of a message that updates a node, as a recording takes it."""
    if isinstance(message, messages.SceneNodeUpdateMessage):
        message.updates = {name: change(name, value) for name, value in message.updates.items()}


def event_loop(server: viser.ViserServer) -> asyncio.AbstractEventLoop:
    """The loop of viser's thread, on which all that browsers send is handled."""
    return server._event_loop


def control_loop(control: Any) -> asyncio.AbstractEventLoop:
    """The same of a control."""
    loop: asyncio.AbstractEventLoop = control._impl.gui_api._event_loop
    return loop


def is_connected(client: viser.ClientHandle) -> bool:
    """Whether a browser is there; `get_clients` waits for the loop."""
    return client.client_id in client._viser_server._connected_clients


def send(client: viser.ClientHandle, message: Any) -> None:
    """Send a message to one browser, after all that was drawn before."""
    client._viser_server.flush()
    client._websock_connection.queue_message(message)
    client.flush()


def send_to_all(server: viser.ViserServer, message: Any) -> None:
    """Send a message to every browser."""
    server._websock_server.queue_message(message)


def drop_messages(server: viser.ViserServer, kinds: tuple[type, ...]) -> None:
    """Handle messages of these kinds no more: what they ask for is not the browser's to ask."""
    for kind in kinds:
        server._websock_server.unregister_handler(kind)


def handle_messages(server: viser.ViserServer, kind: type, handler: Handler) -> None:
    """Have messages of a kind handled, on viser's loop, beside what handles them already."""
    server._websock_server.register_handler(kind, handler)


# What browsers give to controls and handles. viser takes it as it comes; that a value is checked
# first would be needless if viser had a hook before it stores and shows one.


def guard_updates(
    gui: viser.GuiApi, check: Callable[[int, Any, dict[str, Any]], tuple[bool, Any]]
) -> None:
    """Have every value that a browser gives to a control checked before it is stored and shown.

    `check(browser, control, updates)` returns whether it is taken, and the value, which is shown to
    the browser if it is another than it has sent. What comes of a browser that is not there, or of
    a control that is none, is neither stored nor shown.
    """
    accept = gui._handle_gui_updates
    line = gui._websock_interface

    async def accept_checked(browser: Any, message: messages.GuiUpdateMessage) -> None:
        if gui._resolve_client(browser) is None:
            return
        if not isinstance(message.uuid, str) or not isinstance(message.updates, dict):
            return
        control = gui._gui_input_handle_from_uuid.get(message.uuid)
        if control is None or set(message.updates) != {"value"}:
            return
        taken, value = check(browser, control, message.updates)
        if taken:
            await accept(browser, messages.GuiUpdateMessage(message.uuid, {"value": value}))
        if value != message.updates["value"]:
            line.queue_message(messages.GuiUpdateMessage(message.uuid, {"value": value}))

    line.unregister_handler(messages.GuiUpdateMessage)
    line.register_handler(messages.GuiUpdateMessage, accept_checked)


def guard_drags(gui: viser.GuiApi, is_usable: Callable[[Any, Any], bool]) -> None:
    """Drop drags to where nothing can be: viser keeps what is sent, and nobody could draw it."""
    line, kind = gui._websock_interface, messages.TransformControlsUpdateMessage
    handlers: list[Any] = list(line._incoming_handlers[kind])

    async def accept_usable(browser: Any, message: messages.TransformControlsUpdateMessage) -> None:
        if is_usable(message.position, message.wxyz):
            for handler in handlers:
                await handler(browser, message)

    line.unregister_handler(kind)
    line.register_handler(kind, accept_usable)


# Files from browsers. viser takes any number of any size; it bounds neither.


class UploadStates:
    """The files that browsers are sending to a server, as viser keeps them."""

    def __init__(self, server: viser.ViserServer):
        self.server = server
        self.gui = server.gui
        self.under_way: dict[str, Any] = server.gui._current_file_upload_states

    def has_browser(self, browser: int) -> bool:
        """Whether a browser is there."""
        return browser in self.server._connected_clients

    def control(self, uuid: str) -> Any:
        """The control that a file is for, None if there is none."""
        return self.gui._gui_input_handle_from_uuid.get(uuid)

    def start(self, browser: Any, message: messages.FileTransferStartUpload) -> None:
        """Let viser begin a file."""
        self.gui._handle_file_transfer_start(browser, message)

    def add(self, browser: Any, message: messages.FileTransferPart) -> None:
        """Let viser take a part of one."""
        self.gui._handle_file_transfer_part(browser, message)

    def when_browsers_leave(self) -> None:
        """Have the files of a browser that leaves dropped."""

        async def leave(connection: Any) -> None:
            self.gui._drop_uploads_from_client(connection.client_id)

        self.server._websock_server.on_client_disconnect(leave)


# The server of websockets. viser opens it itself, on the next free port and for any page; that it
# gets lines that our front has accepted would be needless if viser took a socket, or listened on
# one that has a name in the file system.


@contextlib.contextmanager
def served_by(serve_ours: Callable[..., Any]) -> Iterator[Callable[..., Any]]:
    """Within it, a viser server that opens is served by `serve_ours`; gives what serves usually."""
    serve = websockets.asyncio.server.serve
    websockets.asyncio.server.serve = serve_ours  # type: ignore[misc, assignment]
    try:
        yield serve
    finally:
        websockets.asyncio.server.serve = serve  # type: ignore[misc]


def protocol_factory(inner: Any) -> Callable[[], asyncio.Protocol]:
    """What makes the protocol of a connection that somebody else has accepted."""
    factory: Callable[[], asyncio.Protocol] = inner.server._protocol_factory
    return factory


# viser's icons from an archive that is opened once.
#
# viser opens it for every icon, and reads the names of all the thousands in it: half a second for
# the buttons of a page. Not needed any more once viser keeps it open.


class IconArchive(zipfile.ZipFile):
    """An archive that stays open."""

    def __exit__(self, *_: object) -> None:
        """Stay open for the next icon."""


def keep_icons_open() -> None:
    """Have viser read its icons so."""
    _icons.zipfile = SimpleNamespace(ZipFile=functools.cache(IconArchive))  # type: ignore[assignment]


# The kinds of the properties of viser's controls and nodes, found once for each class.
#
# viser finds them anew for every control and every node: a fifth of the start of a laboratory. Not
# needed any more once viser keeps what it has found.

known: dict[type, dict[str, Any]] = {}


def kinds_of(handle: Any) -> dict[str, Any]:
    """The kinds of the properties of a control or a node."""
    of = type(handle._impl.props)
    if of not in known:
        known[of] = get_type_hints(of)
    return known[of]


def find_kinds_once() -> None:
    """Have viser do so from now on."""
    once = cached_property(kinds_of)
    once.__set_name__(AssignablePropsBase, "_prop_hints")
    AssignablePropsBase._prop_hints = once  # type: ignore[assignment]


# Events of viser's loop that other threads may set.
#
# viser sets an `asyncio.Event` from whatever thread gives it a message. That wakes who waits from
# the wrong thread: at times "deque mutated during iteration", at times nobody wakes. Not needed any
# more once viser sets them by `call_soon_threadsafe`.


class LoopEvent(asyncio.Event):
    """An event that is only ever set on its loop, whoever sets it."""

    def __init__(self, loop: asyncio.AbstractEventLoop, later: Callable[[], Any] = bool):
        """`later` says whether who sets it will set it again: so long nobody need be woken."""
        super().__init__()
        self.loop = loop
        self.later = later
        self.handing = threading.Lock()
        """Held from the hand-over to the setting: of many only one is on its way."""

    def set(self) -> None:
        """Set it now on its own loop, or soon from another thread."""
        try:
            if asyncio.get_running_loop() is self.loop:
                super().set()
                return
        except RuntimeError:  # a thread without a loop
            pass
        if not self.later() and self.handing.acquire(blocking=False):
            try:
                self.loop.call_soon_threadsafe(self.arrive)
            except RuntimeError:  # the loop is closed, and nobody waits
                self.handing.release()

    def arrive(self) -> None:
        """On its loop."""
        self.handing.release()
        super().set()


@dataclass
class Buffer(AsyncMessageBuffer):
    """viser's buffer of messages, with events that are handed over."""

    def __post_init__(self) -> None:
        self.message_event = LoopEvent(self.event_loop, lambda: self.atomic_counter)
        self.flush_event = LoopEvent(self.event_loop)


def use_loop_events() -> None:
    """Have viser use such buffers from now on."""
    _infra.AsyncMessageBuffer = Buffer  # type: ignore[misc]
