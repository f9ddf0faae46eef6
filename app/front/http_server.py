"""Serves HTTP on one socket, for the laboratory, the cars and a class alike.

What it is given to answer decides who may have what; here is what every answer needs: bounds on
lines that say nothing, the headers that every answer carries, one line for every error, and no
traceback.
"""

from __future__ import annotations

import asyncio
import os
import socket
import ssl
from collections import Counter
from collections.abc import Awaitable, Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from aiohttp import web
from multidict import CIMultiDict

from app.front.client_addresses import address_of
from app.front.log import Log, describe_error, make_logger
from worlds.input_error import InputError

Request = web.BaseRequest
Answer = Callable[[Request], Awaitable[web.StreamResponse]]
"""Answers a request. Raises InputError, and aiohttp's HTTP errors."""

# The headers that every answer carries, whatever it answers.

FIXED = {
    "Server": "flockscope",
    "X-Frame-Options": "DENY",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}
"""No frame may show it, unless a policy of its own says whose; no type is guessed, nobody is told
the address, no other page keeps a hold of its window or reads its files, and a page is never older
than its server."""
POLICY = "Content-Security-Policy"
UNFRAMED = "'none'"
CLOSED = "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
"""The policy of every answer that is not a page."""


def secure(headers: CIMultiDict[str]) -> None:
    """Give an answer its headers; what it has of its own stays."""
    for name, value in FIXED.items():
        headers.setdefault(name, value)
    framed_by = headers.setdefault(POLICY, CLOSED).partition("frame-ancestors ")[2]
    if framed_by.partition(";")[0] not in ("", UNFRAMED):
        del headers["X-Frame-Options"]  # which can name no origins


def text_response(status: int, text: str) -> web.Response:
    """An answer of one line."""
    body = f"{text}\n".encode("utf-8", "replace")
    return web.Response(status=status, body=body, content_type="text/plain", charset="utf-8")


def not_allowed(text: str, methods: tuple[str, ...]) -> web.Response:
    """What a request gets whose method is not one of these."""
    answer = text_response(405, f"{text}, only {' and '.join(methods)}")
    answer.headers["Allow"] = ", ".join(methods)
    return answer


def is_websocket(request: Request) -> bool:
    """Whether a request wants to become a websocket."""
    return request.headers.get("Upgrade", "").lower() == "websocket"


READING = ("GET", "HEAD")
"""The methods that only read: HEAD is answered as GET is, without a body."""
METHODS = (*READING, "POST")
LARGEST_BODY = 64 * 1024
"""Bytes of what a page sends by POST."""
SILENT = 10.0
"""Seconds that a line may be open without a whole request."""
LINGERS = 2.0
"""Seconds that more is taken of a request that has been refused, so that the refusal is read."""
READS = 60.0
"""Seconds in which an answer is to be read."""
FAREWELL = 0.5
"""Seconds that a browser has to read why its line is closed."""
BACKLOG = 1024
"""Lines that the system keeps until they are accepted."""
FILES = 8192
"""Files and sockets that the process may have open, if the system lets it: the usual 1024 are
too few for two hundred pages, each with a line from its browser and a pair of sockets inside."""


class Connection(web.RequestHandler):
    """One line from a browser."""

    __slots__ = ("address", "http", "on_bytes")

    def __init__(self, http: HttpServer, manager: web.Server, **options: Any):
        super().__init__(manager, **options)
        self.http = http
        self.address = ""
        self.on_bytes: Callable[[int], None] | None = None
        """Told how many bytes come in, before anybody reads them."""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.address = address_of(transport.get_extra_info("peername"))
        super().connection_made(transport)
        self.http.silent.add(self)

    def connection_lost(self, exc: BaseException | None) -> None:
        self.http.silent.discard(self)
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        if self.on_bytes is not None:
            self.on_bytes(len(data))
        super().data_received(data)

    def handle_error(
        self,
        request: Request,  # noqa: ARG002
        status: int = 500,
        exc: BaseException | None = None,
        message: str | None = None,  # noqa: ARG002, which quotes what was sent
    ) -> web.StreamResponse:
        """Answer what is no request, without a word of it."""
        if status >= 500:
            self.http.log.line(f"what a browser asked for failed: {describe_error(exc)}")
        answer = text_response(status, "this is no request" if status < 500 else NO_ANSWER)
        answer.force_close()
        secure(answer.headers)
        return answer


NO_ANSWER = "this cannot be answered"


class SilentConnections:
    """The lines on which nothing is asked now. One too many ends one: of the address that has most
    of them, the one that has been silent longest.

    Otherwise whoever opens many and says nothing would keep out everybody else, and an emergency
    stop with them.
    """

    def __init__(self, most: int):
        self.most = most
        self.of: Counter[str] = Counter()
        self.lines: dict[Connection, None] = {}
        """The longest silent first."""

    def add(self, line: Connection) -> None:
        """Nothing is asked on a line."""
        if line.transport is None or line in self.lines:
            return
        self.lines[line] = None
        self.of[line.address] += 1
        if len(self.lines) > self.most:
            ((address, _),) = self.of.most_common(1)
            oldest = next(one for one in self.lines if one.address == address)
            self.discard(oldest)
            if isinstance(oldest.transport, asyncio.Transport):
                oldest.transport.abort()

    def discard(self, line: Connection) -> None:
        """Something is asked on it, or it is gone."""
        if line in self.lines:
            del self.lines[line]
            self.of[line.address] -= 1
            if not self.of[line.address]:
                del self.of[line.address]


class LineServer(web.Server):
    """Makes the connections of an HttpServer."""

    def __init__(self, http: HttpServer, loop: asyncio.AbstractEventLoop):
        super().__init__(
            http.handle, request_factory=self.new_request, handler_cancellation=True, loop=loop
        )
        self.http, self.loop = http, loop

    def new_request(self, message: Any, payload: Any, line: Any, writer: Any, task: Any) -> Request:
        """A request whose body is bounded."""
        return Request(
            message, payload, line, writer, task, self.loop, client_max_size=LARGEST_BODY
        )

    def __call__(self) -> web.RequestHandler:
        return Connection(
            self.http,
            self,
            loop=self.loop,
            access_log=None,
            logger=make_logger(self.http.log),
            keepalive_timeout=SILENT,
            lingering_time=LINGERS,
            auto_decompress=False,
        )


class HttpServer:
    """Answers what is asked on a socket by `answer`, on the loop on which it is opened.

    `silent`: how many lines may be open on which nothing is asked. `tls` encrypts.
    """

    def __init__(
        self,
        sock: socket.socket,
        answer: Answer,
        silent: int,
        log: Log,
        tls: ssl.SSLContext | None = None,
    ):
        self.sock = sock
        self.answer = answer
        self.log = log
        self.tls = tls
        self.silent = SilentConnections(silent)

    async def open(self) -> None:
        """Serve, until closed."""
        loop = asyncio.get_running_loop()
        allow_many_files()
        self.lines = LineServer(self, loop)
        self.listener = await loop.create_server(
            self.lines, sock=self.sock, ssl=self.tls, backlog=BACKLOG
        )

    async def close(self) -> None:
        """Serve no more; whoever is being answered has `FAREWELL` seconds to read it."""
        self.listener.close()
        self.lines.pre_shutdown()
        await self.lines.shutdown(FAREWELL)

    async def handle(self, request: Request) -> web.StreamResponse:
        """Answer a request, however that ends."""
        line: Any = request.protocol
        self.silent.discard(line)
        try:
            response = await self.answer_safely(request)
            if response.status >= 400:
                response.force_close()
            await send(request, response)
        finally:
            self.silent.add(line)
        return response

    async def answer_safely(self, request: Request) -> web.StreamResponse:
        """What a request is answered; an error is one line."""
        try:
            if request.method not in METHODS:
                return not_allowed(f"{request.method[:20]} is not answered here", METHODS)
            if not request.path.startswith("/"):
                raise web.HTTPBadRequest(text="this is no address of a page\n")
            return await self.answer(request)
        except InputError as refusal:
            return text_response(400, str(refusal))
        except web.HTTPException as found:
            headers = {
                name: found.headers[name] for name in ("Location", "Allow") if name in found.headers
            }
            return web.Response(status=found.status, text=found.text, headers=headers)
        except ConnectionError:
            raise
        except Exception as error:
            self.log.line(f"what a browser asked for failed: {describe_error(error)}")
            return text_response(500, NO_ANSWER)


async def send(request: Request, response: web.StreamResponse) -> None:
    """Send an answer to who reads it."""
    if not isinstance(response, web.Response):
        return  # a stream or a websocket, which is over
    secure(response.headers)
    if request.method == "HEAD" and not response.body:
        response.headers.setdefault("Content-Length", "0")  # which aiohttp says to GET alone
    try:
        async with asyncio.timeout(READS):
            await response.prepare(request)
            await response.write_eof()
    except TimeoutError:
        if request.transport is not None:
            request.transport.abort()


def address_of_line(request: Request) -> str:
    """Where a request comes from, as it is counted."""
    line: Any = request.protocol
    return str(line.address)


def allow_many_files() -> None:
    """Let the process have `FILES` files open, or as many as the system allows."""
    try:
        import resource
    except ImportError:  # Windows, which has no such limit
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = FILES if hard == resource.RLIM_INFINITY else min(FILES, hard)
    if soft != resource.RLIM_INFINITY and soft < most:
        with suppress(ValueError):  # macOS allows fewer than its limit says
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))


def listen(host: str, port: int) -> socket.socket:
    """A socket that is bound already, so that nobody can take the port in between. Raises
    InputError if the port is busy or the host is not this machine's."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family, backlog=BACKLOG)
    except (OSError, OverflowError) as error:
        number = getattr(error, "errno", None) or 0
        said = str(getattr(error, "strerror", error)).partition(" (while")[0]
        why = os.strerror(number) if number > 0 else said
        raise InputError(
            f"port {port} on {host} cannot be used: {why}; choose another with --port"
        ) from None


def load_certificate(certificate: Path, key: Path) -> ssl.SSLContext:
    """What encrypts with a certificate. Raises InputError."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    context.minimum_version = ssl.TLSVersion.TLSv1_2
    try:
        context.load_cert_chain(certificate, key, password=lambda: "")  # else it would ask for it
    except (OSError, ssl.SSLError) as error:
        why = error.strerror or str(error)
        raise InputError(
            f"--certificate {str(certificate)!r} with --key {str(key)!r} cannot be used: {why}"
        ) from None
    return context
