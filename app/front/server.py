"""A viser server behind a front: its port, its visitors and its values are kept in hand.

viser takes the next free port when its own is busy, answers pages of any origin, opens a public
tunnel for any browser that asks, and believes what browsers send, however much it is. Here it has
no port at all: a thread of its own answers browsers, and gives viser what may reach it.
"""

from __future__ import annotations

import asyncio
import contextlib
import socket
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import Any
from weakref import WeakKeyDictionary

import rich
import viser
from aiohttp import web
from websockets.asyncio.client import ClientConnection
from websockets.asyncio.server import ServerConnection

from app.front.client_addresses import USUAL, ClientAddresses, ConnectionLimits
from app.front.controls import guard_values
from app.front.http_server import (
    READING,
    HttpServer,
    Request,
    address_of_line,
    is_websocket,
    listen,
    text_response,
)
from app.front.log import Log, log_failures, make_logger
from app.front.message_filter import KINDS, AllowedMessage, MessageFilter
from app.front.page_front import ALIVE, PAGES, Answering, Front
from app.front.relay import Admission, connect_viser, relay
from app.front.renders import Renders, accept_renders
from app.front.viser_internals import (
    drop_messages,
    event_loop,
    find_kinds_once,
    keep_icons_open,
    messages,
    protocol_factory,
    served_by,
    use_loop_events,
)

UNWANTED = (
    messages.ShareUrlRequest,
    messages.ShareUrlDisconnect,
    messages.FileTransferStartUpload,
    messages.FileTransferPart,
    messages.GuiFormSubmitMessage,
    messages.GuiFormDirtyMessage,
)
"""What browsers may send to viser but not to a laboratory."""
BEGINS = 6.0
"""Seconds that a request waits for a page that begins."""
BEGINNING = "flockscope is just beginning: try again in a moment"

# The emergency stop as a request of its own, beside viser's messages.
#
# Any page of ours sends it, and so may a program on this machine or a button on the wall:
#
#     curl -X POST -H 'X-Flockscope: stop' http://localhost:8080/emergency

EMERGENCY = "/emergency"
MARK, WORD = "X-Flockscope", "stop"
"""A header that no foreign page can send: a browser would ask first whether it may."""
Stop = Callable[[str], None]
"""Stops the cars; is told by whom."""
SOON = 0.002
"""Time from a message to its being told of, s: by then it has been carried out. Of many within it
one word is enough."""

starting = threading.Lock()
"""Held while viser's functions are replaced, which all servers of a process share."""


class MessageNotifier:
    """Tells whoever draws that a browser has sent something, so that nobody has to look for it.

    Used by viser's thread; `tell` is called there.
    """

    def __init__(self, tell: Callable[[], None] = lambda: None):
        self.tell = tell
        self.waiting = False

    def note(self, loop: asyncio.AbstractEventLoop) -> None:
        """A message goes to viser now."""
        if not self.waiting:
            self.waiting = True
            loop.call_later(SOON, self.pass_on)

    def pass_on(self) -> None:
        """Tell of what has been carried out by now."""
        self.waiting = False
        self.tell()


class Entrance:
    """How browsers come to one viser server: by a thread that waits for nothing of viser's.

    So an emergency stop waits for none of viser's work. Of the page of this thread's own work it
    waits for a moment: that counts messages, looks at them and carries them on.
    """

    def __init__(
        self,
        sock: socket.socket,
        front: Front,
        kinds: Mapping[str, AllowedMessage],
        limits: ConnectionLimits,
    ):
        self.front = front
        self.kinds = kinds
        self.visitors = ClientAddresses(limits=limits)
        self.log = Log()
        self.renders = Renders()
        self.heard = MessageNotifier()
        self.stop: Stop | None = None
        self.loop = asyncio.new_event_loop()
        self.admission = Admission(self.loop)
        self.settled = asyncio.Event()
        """Set once it is known whether there is anything to stop: a stop waits for that."""
        self.http = HttpServer(sock, self.answer, limits.silent, self.log)
        self.viser_loop: asyncio.AbstractEventLoop
        self.viser_protocol: Callable[[], asyncio.Protocol]

    def open(
        self, viser_loop: asyncio.AbstractEventLoop, protocol: Callable[[], asyncio.Protocol]
    ) -> None:
        """Answer browsers, until closed. `protocol` makes viser's end of a line."""
        self.viser_loop, self.viser_protocol = viser_loop, protocol
        log_failures(self.loop, self.log)
        self.thread = threading.Thread(target=self.loop.run_forever, name="front", daemon=True)
        self.thread.start()
        asyncio.run_coroutine_threadsafe(self.http.open(), self.loop).result()

    def close(self) -> None:
        """Answer nobody any more."""
        self.admission.decide(False)
        asyncio.run_coroutine_threadsafe(self.end(), self.loop).result()
        self.loop.call_soon_threadsafe(self.loop.stop)
        self.thread.join()
        self.loop.close()
        self.log.close()

    async def end(self) -> None:
        """On its loop: answer nobody any more, and leave nothing behind."""
        await self.http.close()
        tasks = asyncio.all_tasks() - {asyncio.current_task()}
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)

    def settle(self) -> None:
        """It is known now whether there is anything to stop; any thread may say so."""
        self.loop.call_soon_threadsafe(self.settled.set)

    async def answer(self, request: Request) -> web.StreamResponse:
        """What a request is answered."""
        if request.method not in READING:
            return await self.answer_stop(request)
        address = address_of_line(request)
        wait = self.visitors.enter(address)
        if wait is None:
            return text_response(429, "too many requests from one address")
        try:
            await asyncio.sleep(wait)
            return await self.answer_visitor(request, address)
        finally:
            self.visitors.leave(address)

    async def answer_stop(self, request: Request) -> web.Response:
        """Carry out an emergency stop, or say why not. It waits for no turn."""
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(BEGINS):
                await self.settled.wait()
        if request.raw_path != EMERGENCY or self.stop is None:
            return text_response(404, "there is nothing to stop here")
        refused = self.front.refusal(request)
        if refused is not None:
            return refused
        if request.headers.getall(MARK, []) != [WORD]:
            return text_response(403, f"an emergency stop needs the header {MARK}: {WORD}")
        self.stop(f"browser at {address_of_line(request)}")
        return web.Response(status=204)

    async def answer_visitor(self, request: Request, address: str) -> web.StreamResponse:
        """What somebody is answered whose turn it is."""
        path = self.front.path_of(request)
        if path is None:
            return text_response(404, "there is nothing here")
        refused = self.front.refusal(request)
        if refused is not None:
            return refused
        if is_websocket(request):
            return await self.connect(request, address)
        if path == ALIVE:
            return self.front.routes[ALIVE](request)
        if path in PAGES:
            return self.front.serve_page(request)
        if not await self.admission.admits(BEGINS):
            return text_response(503, BEGINNING)
        if path in self.front.routes:
            return await self.on_visers_loop(self.front.routes[path], request)
        return text_response(404, "there is nothing here")

    async def on_visers_loop(self, answering: Answering, request: Request) -> web.Response:
        """What a route answers, which is called where viser calls everything else of a page."""

        async def answer() -> web.Response:
            return answering(request)

        return await asyncio.wrap_future(
            asyncio.run_coroutine_threadsafe(answer(), self.viser_loop)
        )

    async def connect(self, request: Request, address: str) -> web.StreamResponse:
        """Connect a page with viser when it is its turn."""
        wait = self.visitors.page(address)
        if wait is None:
            refused = text_response(429, "too many pages from one address")
            refused.headers["Retry-After"] = "10"
            return refused
        await asyncio.sleep(wait)
        incoming = MessageFilter(
            self.visitors.messages(address),
            lambda why: self.log.line(f"a message from {address} is dropped: {why}"),
            expected=self.renders.expects,
            kinds=self.kinds,
        )

        def cut(why: str) -> None:
            self.visitors.cut(address)
            self.log.line(f"a browser at {address} is cut off: {why}")

        return await relay(request, self.open_line, incoming, admission=self.admission, cut=cut)

    async def open_line(self) -> ClientConnection:
        """A line to viser: a pair of sockets, so that nobody else can reach it by any port."""
        ours, theirs = socket.socketpair()
        try:
            for end in (ours, theirs):
                end.setblocking(False)
            handed = self.viser_loop.connect_accepted_socket(self.viser_protocol, theirs)
            asyncio.run_coroutine_threadsafe(handed, self.viser_loop)
            return await connect_viser("ws://viser/", sock=ours)
        except BaseException:
            ours.close()
            theirs.close()
            raise


entrances: WeakKeyDictionary[viser.ViserServer, Entrance] = WeakKeyDictionary()
"""Of every server that is open."""


def open_server(
    host: str = "127.0.0.1",
    port: int = 8080,
    front: Front | None = None,
    kinds: Mapping[str, AllowedMessage] = KINDS,
    limits: ConnectionLimits = USUAL,
) -> viser.ViserServer:
    """A server on exactly this host and port; port 0 takes any free one.

    Its page can be loaded at once, but nothing that browsers say or ask for arrives before
    `admit_browsers`: whoever opens a server first makes whole what it serves.

    `front` answers what comes by HTTP; by default one with viser's page alone. `kinds`: of which
    kinds of messages it hears, and how often; all others are dropped before anybody decodes them.
    `limits`: how many connections there may be, of all and of one address, and how soon more.
    Raises InputError if the port is busy or the host is not this machine's.
    """
    use_loop_events()
    find_kinds_once()
    keep_icons_open()
    front = front or Front()
    sock = listen(host, port)
    entrance = Entrance(sock, front, kinds, limits)
    with starting, served_by_entrance(entrance, sock.dup()) as begun, silence_viser():
        server = viser.ViserServer(host=host, port=port, label="flockscope", verbose=False)
    drop_messages(server, UNWANTED)
    guard_values(server)
    accept_renders(server, entrance.renders)
    entrance.open(event_loop(server), protocol_factory(begun[0]))
    entrances[server] = entrance
    return server


def admit_browsers(server: viser.ViserServer) -> None:
    """Let browsers use what a server serves: the last step of whoever makes what it serves."""
    entrance = entrances[server]
    entrance.admission.decide(True)
    entrance.settle()


def front_of(server: viser.ViserServer) -> Front:
    """What answers for a server by HTTP."""
    return entrances[server].front


def renders_of(server: viser.ViserServer) -> Renders:
    """What asks a server's browsers for pictures."""
    return entrances[server].renders


def on_browser_message(server: viser.ViserServer, tell: Callable[[], None]) -> None:
    """Have something told of, on viser's loop, soon after browsers have sent messages."""
    entrances[server].heard.tell = tell


def on_emergency_stop(server: viser.ViserServer, stop: Stop) -> None:
    """Have emergency stops carried out, on the front's thread; `stop` is told by whom."""
    entrance = entrances[server]
    entrance.stop = stop
    entrance.settle()


def close_server(server: viser.ViserServer) -> None:
    """Stop a server without a word on standard output."""
    entrance = entrances.pop(server, None)
    if entrance is not None:
        entrance.close()
    with starting, silence_viser():
        server.stop()


@contextlib.contextmanager
def silence_viser() -> Iterator[None]:
    """Within it viser says nothing, neither on standard output nor in a notebook's cell."""
    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before


@contextlib.contextmanager
def served_by_entrance(entrance: Entrance, sock: socket.socket) -> Iterator[list[Any]]:
    """Within it, a viser server that opens takes its lines from an entrance.

    It knows its address by the socket, on which it does not listen. The server of websockets that
    makes its end of a line is put into the list.
    """
    begun: list[Any] = []

    class NotingConnection(ServerConnection):
        """Viser's end of a line, which tells that a message has come."""

        async def recv(self, decode: bool | None = None) -> Any:
            data = await super().recv(decode)
            entrance.heard.note(self.loop)
            return data

    def serve_here(handler: Any, _host: str, _port: int, **options: Any) -> Any:
        log_failures(asyncio.get_running_loop(), entrance.log)
        ours = {
            "sock": sock,
            "start_serving": False,
            "ping_interval": None,
            "create_connection": NotingConnection,
            "logger": make_logger(entrance.log),
        }
        made = serve(handler, **(options | ours))
        begun.append(made.server)
        made.server.is_serving = lambda: made.server.close_task is None
        return made

    with served_by(serve_here) as serve:
        yield begun
