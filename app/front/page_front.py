"""Answers everything that asks by HTTP, before viser and mostly in its stead.

viser serves its page to anyone, with no headers, and its client obeys the page's address. Here a
request is refused first and answered then, and every answer is given its headers at the end.
"""

from __future__ import annotations

import hmac
import re
import secrets
from collections.abc import Callable, Iterable
from http import HTTPStatus
from urllib.parse import parse_qsl

from websockets.datastructures import Headers
from websockets.http11 import Request, Response

from app.front.client_page import client_page
from app.front.origin import AllowedHost, authority, trusted

# The headers that every answer carries, whatever it answers.

FIXED = {
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


def policy(hashes: Iterable[str], lines: Iterable[str], framed_by: Iterable[str] = ()) -> str:
    """The Content-Security-Policy of a page whose scripts have these hashes and which may open
    websockets to these places; pages of the origins `framed_by` may show it in a frame.

    Scripts run by their hash alone: none that is loaded from anywhere, none that a message brings,
    no handler in HTML, no `eval`. viser's client needs the rest: WebAssembly that unpacks messages,
    a worker that it makes of itself (`blob:`), styles in HTML, and pictures, fonts and light out of
    its own page (`data:`). The gallery's pictures are this server's own. One script of viser's is
    refused at every start: the one that sorts Gaussian splats, which are not drawn here, makes
    functions of strings (EvalError in the console).
    """
    rules = {
        "default-src": "'none'",
        "script-src": " ".join((*hashes, "'wasm-unsafe-eval'")),
        "worker-src": "blob:",
        "connect-src": " ".join(("'self'", "data:", *lines)),
        "style-src": "'unsafe-inline'",
        "img-src": "'self' data: blob:",
        "font-src": "data:",
        "base-uri": "'none'",
        "form-action": "'none'",
        "frame-ancestors": " ".join(framed_by) or UNFRAMED,
    }
    return "; ".join(f"{name} {value}" for name, value in rules.items())


POLICY = "Content-Security-Policy"
UNFRAMED = "'none'"
CLOSED = "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
"""The policy of every answer that is not a page."""


def secure(headers: Headers) -> None:
    """Give an answer its headers; a policy of its own stays."""
    for name, value in FIXED.items():
        headers.pop(name, None)
        headers[name] = value
    if POLICY not in headers:
        headers[POLICY] = CLOSED
    framed_by = headers[POLICY].partition("frame-ancestors ")[2].partition(";")[0]
    if framed_by not in ("", UNFRAMED):
        del headers["X-Frame-Options"]  # which can name no origins


# What the address of a page may not ask for.

FORBIDDEN = ("websocket", "playbackpath")
"""Parameters by which viser's client would take its messages from elsewhere, in small letters."""
OTHER = re.compile(r"[^a-z]")
MOST = 100
"""Parameters of an address."""


def leads_elsewhere(query: str) -> str:
    """The parameter of a query that names another source of messages; empty if none does.

    >>> leads_elsewhere("a=1&%57ebSocket=ws://example.org")
    'websocket'
    >>> leads_elsewhere("token=1")
    ''
    """
    try:
        named = parse_qsl(query, keep_blank_values=True, max_num_fields=MOST)
    except ValueError:
        return f"more than {MOST} parameters"
    for name, _ in named:
        letters = OTHER.sub("", name.casefold())
        for word in FORBIDDEN:
            if word in letters:
                return word
    return ""


PAGES = ("/", "/index.html")
ALIVE = "/alive"
"""Where a page asks whether its server is there, and whether it is the one it was served by."""
OWN_SITE = ("same-origin", "none")
"""What `Sec-Fetch-Site` says of a request that our own page or a person makes."""
FOLLOWED = ("navigate", "document")
"""Mode and destination of a request that somebody made by following a link in a window."""
FRAMED = ("navigate", "iframe")
"""The same of a page that another page shows in a frame."""
ONCE = ("Host", "Origin", "Upgrade", "Sec-Fetch-Site", "Sec-Fetch-Mode", "Sec-Fetch-Dest")
"""Headers that may stand there once."""
BEGINNING = "flockscope is just beginning: try again in a moment"
METHODS = ("GET", "HEAD")
Answering = Callable[[Request], Response]


class Front:
    """What one server answers.

    `scripts`: files of `static/` that are part of its page and run before viser's. `allow`: names
    by which it may be reached beside this machine's own. `secret`: the first part of every path,
    without which there is nothing; whoever knows it may come by any name, as a proxy does.
    `framed_by`: the origins of pages that may show it in a frame; nobody's otherwise. Raises
    InputError if the page cannot be made.
    """

    def __init__(
        self,
        scripts: tuple[str, ...] = (),
        allow: tuple[AllowedHost, ...] = (),
        secret: str = "",
        framed_by: tuple[str, ...] = (),
    ):
        self.page = client_page(scripts)
        self.allow = allow
        self.secret = secret
        self.framed_by = framed_by
        name = secrets.token_hex(8)
        self.routes: dict[str, Answering] = {ALIVE: lambda _: text_response(HTTPStatus.OK, name)}

    def route(self, path: str, answering: Answering) -> None:
        """Have GET of this path, which begins with a slash, answered by a function of the request.

        It is called on the server's own loop, for requests that were let in: it must not wait. What
        it changes can be asked for by any page at an address that is not localhost or https, since
        browsers say there neither where a GET comes from; a websocket always says so.
        """
        self.routes[path] = answering

    def loads_page(self, path: str) -> bool:
        """Whether it is of the page alone, which can be loaded before anything is behind it."""
        inner = without(self.secret, path) if self.secret else path
        return inner is None or inner.partition("?")[0] in (*PAGES, ALIVE)

    def answer(
        self, request: Request, viser: Callable[[], Response | None], method: str = "GET"
    ) -> Response | None:
        """What a request is answered; None for a websocket, which may be opened.

        `viser` gives its own answer, for what is nobody else's. HEAD is answered as GET is, and
        loses its body at the end.
        """
        if self.secret:
            inner = without(self.secret, request.path)
            if inner is None:
                return text_response(HTTPStatus.NOT_FOUND, "there is nothing here")
            request.path = inner  # nobody further in is told it
        refused = refusal(request, self.allow, bool(self.secret), bool(self.framed_by))
        if refused is not None:
            return refused
        if method not in METHODS:
            return not_allowed(f"{method[:20]} is not answered here, only GET and HEAD", METHODS)
        if is_websocket(request):
            only = not_allowed("a websocket is opened by GET", ("GET",))
            return viser() if method == "GET" else only
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
        places = lines(request, self.allow, bool(self.secret))
        headers[POLICY] = policy(self.page.hashes, places, self.framed_by)
        return Response(HTTPStatus.OK, "OK", headers, body)

    def finish(self, response: Response, method: str = "GET") -> None:
        """Give an answer, whoever made it, the headers that every one has; to HEAD no body."""
        secure(response.headers)
        if response.status_code != HTTPStatus.SWITCHING_PROTOCOLS:
            if "Content-Length" not in response.headers:
                response.headers["Content-Length"] = str(len(response.body or b""))
            if method == "HEAD":
                response.body = b""


def without(secret: str, path: str) -> str | None:
    """The path behind a secret that it begins with; None if it does not.

    >>> without("a1", "/a1/alive?x"), without("a1", "/a1"), without("a1", "/a12/alive")
    ('/alive?x', '/', None)
    """
    place, _, query = path.partition("?")
    first, _, rest = place.removeprefix("/").partition("/")
    if not hmac.compare_digest(first.encode(errors="replace"), secret.encode()):
        return None
    return f"/{rest}?{query}" if query else f"/{rest}"


def refusal(
    request: Request, allow: tuple[AllowedHost, ...], invited: bool = False, framed: bool = False
) -> Response | None:
    """What a request gets that may not be answered; None for one that may.

    `invited`: whether it knows a secret, and so may come by any name. `framed`: whether its page
    may be in a frame, whose the page's own policy says.
    """
    headers = request.headers
    twice = next((name for name in ONCE if len(headers.get_all(name)) > 1), "")
    if twice:
        return text_response(HTTPStatus.BAD_REQUEST, f"the header {twice} stands there twice")
    if not trusted(headers.get("Host"), headers.get("Origin"), allow, invited):
        return text_response(HTTPStatus.FORBIDDEN, "flockscope only answers its own pages")
    named = leads_elsewhere(request.path.partition("?")[2])
    if named:
        text = f"the address of this page may not name {named}"
        return text_response(HTTPStatus.BAD_REQUEST, text)
    site = headers.get("Sec-Fetch-Site", "none")
    way = (headers.get("Sec-Fetch-Mode"), headers.get("Sec-Fetch-Dest"))
    if site not in OWN_SITE and way != FOLLOWED and not (framed and way == FRAMED):
        return text_response(HTTPStatus.FORBIDDEN, "flockscope is not shown or used by other pages")
    return None


def is_websocket(request: Request) -> bool:
    """Whether a request wants to become a websocket."""
    return request.headers.get("Upgrade", "").lower() == "websocket"


def lines(
    request: Request, allow: tuple[AllowedHost, ...], invited: bool = False
) -> tuple[str, ...]:
    """Where the page that this request gets may open websockets, as its policy writes it.

    A proxy may have been reached by any allowed name, whatever it says as `Host`; one that was
    `invited` is not known by name, and may have TLS before it. No policy can write a numeric
    address of IPv6; `'self'` stands for it.
    """
    reached = authority(request.headers.get("Host"))
    named = [f"{scheme}://{one}" for one in allow for scheme in ("ws", "wss")]
    safe = [f"wss://{reached}"] if invited else []
    found = dict.fromkeys((f"ws://{reached}", *safe, *named))
    return tuple(line for line in found if "[" not in line)


def text_response(status: HTTPStatus, text: str) -> Response:
    """An answer of one line."""
    return content(f"{text}\n".encode(), "text/plain; charset=utf-8", status)


def not_allowed(text: str, methods: tuple[str, ...]) -> Response:
    """What a request gets whose method is not one of these."""
    answer = text_response(HTTPStatus.METHOD_NOT_ALLOWED, text)
    answer.headers["Allow"] = ", ".join(methods)
    return answer


def content(body: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK) -> Response:
    """An answer of bytes of some kind."""
    headers = Headers({"Content-Type": kind})
    headers["Content-Length"] = str(len(body))
    headers["Connection"] = "close"
    return Response(status, status.phrase, headers, body)
