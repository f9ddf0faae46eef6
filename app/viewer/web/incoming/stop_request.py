"""The emergency stop as a request of its own, beside viser's messages.

Any page of ours sends it, and so may a program on this machine or a button on the wall:

    curl -X POST -H 'X-Flockscope: stop' http://localhost:8080/emergency
"""

from __future__ import annotations

import http.client
import io
from dataclasses import dataclass
from http import HTTPStatus

from websockets.datastructures import Headers
from websockets.http11 import Request

from app.viewer.web.origin import AllowedHost
from app.viewer.web.serving.front import METHODS, refusal
from app.viewer.web.serving.headers import secure

PATH = "/emergency"
MARK, WORD = "X-Flockscope", "stop"
"""A header that no foreign page can send: a browser would ask first whether it may."""
NOT_ALLOWED = "only GET and HEAD, and POST of an emergency stop"
LONGEST = 8 * 1024
"""Bytes of a request."""


@dataclass(frozen=True)
class StopReply:
    """What a request comes to."""

    status: HTTPStatus
    words: str = ""
    stops: bool = False

    def to_bytes(self) -> bytes:
        """As it is sent."""
        body = f"{self.words}\n".encode() if self.words else b""
        headers = Headers({"Content-Type": "text/plain; charset=utf-8"})
        headers["Content-Length"] = str(len(body))
        headers["Connection"] = "close"
        secure(headers)
        if self.status is HTTPStatus.METHOD_NOT_ALLOWED:
            headers["Allow"] = ", ".join((*METHODS, "POST"))
        line = f"HTTP/1.1 {self.status.value} {self.status.phrase}\r\n"
        return line.encode() + headers.serialize() + body


def answered(head: bytes, stops: bool, allow: tuple[AllowedHost, ...] = ()) -> StopReply:
    """What to do with a request, of which `head` is all up to the empty line.

    `stops` says whether there is anything to stop here; `allow` are names by which it may be
    reached beside this machine's own.
    """
    first, _, rest = head.partition(b"\r\n")
    try:
        method, path, version = first.decode("ascii").split(" ")
        found = http.client.parse_headers(io.BytesIO(rest))
    except (ValueError, http.client.HTTPException):
        return StopReply(HTTPStatus.BAD_REQUEST, "this is no request")
    if method != "POST" or not version.startswith("HTTP/1."):
        return StopReply(HTTPStatus.METHOD_NOT_ALLOWED, NOT_ALLOWED)
    if path != PATH or not stops:
        return StopReply(HTTPStatus.NOT_FOUND, "there is nothing to stop here")
    headers = Headers([(name, str(value)) for name, value in found.items()])
    refused = refusal(Request(path, headers), allow)
    if refused is not None:
        return StopReply(HTTPStatus(refused.status_code), refused.body.decode().strip())
    if found.get_all(MARK) != [WORD]:
        return StopReply(HTTPStatus.FORBIDDEN, f"an emergency stop needs the header {MARK}: {WORD}")
    return StopReply(HTTPStatus.NO_CONTENT, stops=True)
