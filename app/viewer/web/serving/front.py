"""Answers everything that asks by HTTP, before viser and mostly in its stead.

viser serves its page to anyone, with no headers, and its client obeys the page's address. Here a
request is refused first and answered then, and every answer is given its headers at the end.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable
from http import HTTPStatus

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from app.viewer.web.origin import Allowed, authority, trusted
from app.viewer.web.serving.client_page import client_page
from app.viewer.web.serving.headers import POLICY, policy, secure
from app.viewer.web.serving.query import leads_elsewhere

PAGES = ("/", "/index.html")
ALIVE = "/alive"
"""Where a page asks whether its server is there, and whether it is the one it was served by."""
OWN_SITE = ("same-origin", "none")
"""What `Sec-Fetch-Site` says of a request that our own page or a person makes."""
FOLLOWED = ("navigate", "document")
"""Mode and destination of a request that somebody made by following a link in a window."""
ONCE = ("Host", "Origin", "Upgrade", "Sec-Fetch-Site", "Sec-Fetch-Mode", "Sec-Fetch-Dest")
"""Headers that may stand there once."""
Answering = Callable[[Request], Response]


class Front:
    """What one server answers.

    `scripts`: files of `static/` that are part of its page and run before viser's. `allow`: names
    by which it may be reached beside this machine's own. Raises Refusal if the page cannot be made.
    """

    def __init__(self, scripts: tuple[str, ...] = (), allow: tuple[Allowed, ...] = ()):
        self.page = client_page(scripts)
        self.allow = allow
        name = secrets.token_hex(8)
        self.routes: dict[str, Answering] = {ALIVE: lambda _: words(HTTPStatus.OK, name)}

    def route(self, path: str, answering: Answering) -> None:
        """Have GET of this path, which begins with a slash, answered by a function of the request.

        It is called on the server's own loop, for requests that were let in: it must not wait. What
        it changes can be asked for by any page at an address that is not localhost or https, since
        browsers say there neither where a GET comes from; a websocket always says so.
        """
        self.routes[path] = answering

    def answer(self, request: Request, viser: Callable[[], Response | None]) -> Response | None:
        """What a request is answered; None for a websocket, which may be opened.

        `viser` gives its own answer, for what is nobody else's.
        """
        refused = refusal(request, self.allow)
        if refused is not None:
            return refused
        if is_websocket(request):
            return viser()
        path = request.path.partition("?")[0]
        if path in self.routes:
            return self.routes[path](request)
        return self.serve_page(request) if path in PAGES else viser()

    def serve_page(self, request: Request) -> Response:
        """viser's page with our scripts."""
        packed = any("gzip" in value for value in request.headers.get_all("Accept-Encoding"))
        body = self.page.packed if packed else self.page.html
        headers = Headers({"Content-Type": "text/html; charset=utf-8"})
        if packed:
            headers["Content-Encoding"] = "gzip"
        headers["Vary"] = "Accept-Encoding"
        headers["Content-Length"] = str(len(body))
        headers["Connection"] = "close"
        headers[POLICY] = policy(self.page.hashes, lines(request, self.allow))
        return Response(HTTPStatus.OK, "OK", headers, body)

    def finish(self, response: Response) -> None:
        """Give an answer, whoever made it, the headers that every one has."""
        secure(response.headers)


def refusal(request: Request, allow: tuple[Allowed, ...]) -> Response | None:
    """What a request gets that may not be answered; None for one that may."""
    headers = request.headers
    twice = next((name for name in ONCE if len(headers.get_all(name)) > 1), "")
    if twice:
        return words(HTTPStatus.BAD_REQUEST, f"the header {twice} stands there twice")
    if not trusted(headers.get("Host"), headers.get("Origin"), allow):
        return words(HTTPStatus.FORBIDDEN, "flockscope only answers its own pages")
    named = leads_elsewhere(request.path.partition("?")[2])
    if named:
        text = f"the address of this page may not name {named}"
        return words(HTTPStatus.BAD_REQUEST, text)
    site = headers.get("Sec-Fetch-Site", "none")
    followed = (headers.get("Sec-Fetch-Mode"), headers.get("Sec-Fetch-Dest")) == FOLLOWED
    if site not in OWN_SITE and not followed:
        return words(HTTPStatus.FORBIDDEN, "flockscope is not shown or used by other pages")
    return None


def is_websocket(request: Request) -> bool:
    """Whether a request wants to become a websocket."""
    return request.headers.get("Upgrade", "").lower() == "websocket"


def lines(request: Request, allow: tuple[Allowed, ...]) -> tuple[str, ...]:
    """Where the page that this request gets may open websockets, as its policy writes it.

    A proxy may have been reached by any allowed name, whatever it says as `Host`. No policy can
    write a numeric address of IPv6; `'self'` stands for it.
    """
    reached = authority(request.headers.get("Host"))
    named = [f"{scheme}://{one}" for one in allow for scheme in ("ws", "wss")]
    found = dict.fromkeys((f"ws://{reached}", *named))
    return tuple(line for line in found if "[" not in line)


def words(status: HTTPStatus, text: str) -> Response:
    """An answer of one line."""
    return content(f"{text}\n".encode(), "text/plain; charset=utf-8", status)


def content(body: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK) -> Response:
    """An answer of bytes of some kind."""
    headers = Headers({"Content-Type": kind})
    headers["Content-Length"] = str(len(body))
    headers["Connection"] = "close"
    return Response(status, status.phrase, headers, body)
