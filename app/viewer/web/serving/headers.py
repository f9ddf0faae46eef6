"""The headers that every answer carries, whatever it answers."""

from __future__ import annotations

from collections.abc import Iterable

from websockets.datastructures import Headers

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
