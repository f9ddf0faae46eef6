"""What a laboratory answers by HTTP: its page, its routes, and nothing to other pages.

viser serves its page to anyone, with no headers, and its client obeys the page's address. Here a
request is refused first and answered then; viser itself is asked for nothing but websockets.
"""

from __future__ import annotations

import hmac
import re
import secrets
from collections.abc import Callable, Iterable
from urllib.parse import parse_qsl

from aiohttp import web

from app.front.client_page import ClientPage, client_page
from app.front.http_server import POLICY, UNFRAMED, Request, text_response
from app.front.origin import AllowedHost, authority, is_trusted


def page_policy(hashes: Iterable[str], lines: Iterable[str], framed_by: Iterable[str] = ()) -> str:
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


# What the address of a page may not ask for.

FORBIDDEN = ("websocket", "playbackpath")
"""Parameters by which viser's client would take its messages from elsewhere, in small letters."""
OTHER = re.compile(r"[^a-z]")
MOST = 100
"""Parameters of an address."""


def foreign_source(query: str) -> str:
    """The parameter of a query that names another source of messages; empty if none does.

    >>> foreign_source("a=1&%57ebSocket=ws://example.org")
    'websocket'
    >>> foreign_source("token=1")
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
Answering = Callable[[Request], web.Response]


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
        self.routes: dict[str, Answering] = {ALIVE: lambda _: text_response(200, name)}

    def route(self, path: str, answering: Answering) -> None:
        """Have GET of this path, which begins with a slash, answered by a function of the request.

        It is called on viser's loop, for requests that were let in: it must not wait. What it
        changes can be asked for by any page at an address that is not localhost or https, since
        browsers say there neither where a GET comes from; a websocket always says so.
        """
        self.routes[path] = answering

    def path_of(self, request: Request) -> str | None:
        """The path behind the secret, without its query; None where the secret is missing."""
        path = request.raw_path.partition("?")[0]
        return strip_secret(self.secret, path) if self.secret else path

    def refusal(self, request: Request) -> web.Response | None:
        """What a request gets that may not be answered; None for one that may."""
        return refusal(request, self.allow, bool(self.secret), bool(self.framed_by))

    def loads_page(self, path: str) -> bool:
        """Whether it is of the page alone, which can be loaded before anything is behind it."""
        return path in (*PAGES, ALIVE)

    def serve_page(self, request: Request) -> web.Response:
        """viser's page with our scripts."""
        lines = websocket_addresses(request, self.allow, bool(self.secret))
        return page_response(request, self.page, lines, self.framed_by)


def page_response(
    request: Request, page: ClientPage, lines: Iterable[str], framed_by: Iterable[str] = ()
) -> web.Response:
    """A page with what it may do, packed where the browser takes that."""
    packed = "gzip" in ",".join(request.headers.getall("Accept-Encoding", []))
    headers = {POLICY: page_policy(page.hashes, lines, framed_by), "Vary": "Accept-Encoding"}
    if packed:
        headers["Content-Encoding"] = "gzip"
    body = page.packed if packed else page.html
    return web.Response(body=body, content_type="text/html", charset="utf-8", headers=headers)


def strip_secret(secret: str, path: str) -> str | None:
    """The path behind a secret that it begins with; None if it does not.

    >>> strip_secret("a1", "/a1/alive"), strip_secret("a1", "/a1"), strip_secret("a1", "/a12/alive")
    ('/alive', '/', None)
    """
    first, _, rest = path.removeprefix("/").partition("/")
    if not hmac.compare_digest(first.encode(errors="replace"), secret.encode()):
        return None
    return f"/{rest}"


def refusal(
    request: Request, allow: tuple[AllowedHost, ...], invited: bool = False, framed: bool = False
) -> web.Response | None:
    """What a request gets that may not be answered; None for one that may.

    `invited`: whether it knows a secret, and so may come by any name. `framed`: whether its page
    may be in a frame, whose the page's own policy says.
    """
    headers = request.headers
    twice = next((name for name in ONCE if len(headers.getall(name, [])) > 1), "")
    if twice:
        return text_response(400, f"the header {twice} stands there twice")
    if not is_trusted(headers.get("Host"), headers.get("Origin"), allow, invited):
        return text_response(403, "flockscope only answers its own pages")
    named = foreign_source(request.raw_path.partition("?")[2])
    if named:
        return text_response(400, f"the address of this page may not name {named}")
    site = headers.get("Sec-Fetch-Site", "none")
    way = (headers.get("Sec-Fetch-Mode"), headers.get("Sec-Fetch-Dest"))
    if site not in OWN_SITE and way != FOLLOWED and not (framed and way == FRAMED):
        return text_response(403, "flockscope is not shown or used by other pages")
    return None


def websocket_addresses(
    request: Request, allow: tuple[AllowedHost, ...], invited: bool = False, scheme: str = "ws"
) -> tuple[str, ...]:
    """Where the page that this request gets may open websockets, as its policy writes it.

    A proxy may have been reached by any allowed name, whatever it says as `Host`; one that was
    `invited` is not known by name, and may have TLS before it. No policy can write a numeric
    address of IPv6; `'self'` stands for it.
    """
    reached = authority(request.headers.get("Host"))
    named = [f"{one}://{host}" for host in allow for one in ("ws", "wss")]
    safe = [f"wss://{reached}"] if invited else []
    found = dict.fromkeys((f"{scheme}://{reached}", *safe, *named))
    return tuple(address for address in found if "[" not in address)
