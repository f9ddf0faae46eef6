"""Which messages of a browser reach viser: their kinds, how often, how long, and of what shape.

They are looked at before viser decodes them.
"""

from __future__ import annotations

import math
import time
import types
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields
from functools import cache
from typing import Any, Union, get_args, get_origin

import msgspec

from app.front.client_addresses import RateLimit
from app.front.viser_internals import message_class, message_hints, message_kinds

LONGEST = 16 * 1024
"""Bytes of a message that brings no file."""
LARGEST = 6 * 1024 * 1024
"""Bytes of any message; viser's page sends files in parts of half a mebibyte."""


@dataclass(frozen=True)
class AllowedMessage:
    """A kind of message."""

    rate: float
    """How many a second; viser's page sends at most 50 of any, a key held down repeats 30 times."""
    most: float
    """How many at once."""
    longest: int = LONGEST
    """Bytes."""


CAMERA = "ViewerCameraMessage"
"""What introduces a browser: viser acts on nothing of one that never sent it."""
RENDER = "GetRenderResponseMessage"
"""A picture of the scene, of which only those are heard that were asked for."""
KINDS = {
    CAMERA: AllowedMessage(80.0, 160.0),
    "GuiUpdateMessage": AllowedMessage(80.0, 300.0),
    "GuiButtonHoldMessage": AllowedMessage(10.0, 20.0),
    "CommandTriggerMessage": AllowedMessage(40.0, 60.0),
    "SceneNodeClickMessage": AllowedMessage(50.0, 60.0),
    "SceneNodeDragMessage": AllowedMessage(80.0, 160.0),
    "ScenePointerMessage": AllowedMessage(50.0, 60.0),
    "TransformControlsUpdateMessage": AllowedMessage(80.0, 160.0),
    "TransformControlsDragStartMessage": AllowedMessage(10.0, 20.0),
    "TransformControlsDragEndMessage": AllowedMessage(10.0, 20.0),
    "FileTransferStartUpload": AllowedMessage(2.0, 8.0),
    "FileTransferPart": AllowedMessage(20.0, 40.0, LARGEST),
    RENDER: AllowedMessage(40.0, 60.0, LARGEST),
}
"""Of these a laboratory hears, and of no others."""
KNOWN = message_kinds()
"""All kinds that viser knows."""


class UnusableMessage(ValueError):
    """A message that nobody can use; says why without a word of its content."""


class Envelope(msgspec.Struct):
    """What every message has."""

    type: str


envelope = msgspec.msgpack.Decoder(Envelope)


def kind_of(data: bytes) -> str:
    """The kind of a message, of all else of which nothing is decoded. Raises Unusable."""
    try:
        return envelope.decode(data).type
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        raise UnusableMessage("it is no message at all") from None


def demand_shape(kind: str, data: bytes) -> None:
    """Look that viser will find what it expects in a message. Raises Unusable."""
    if len(data) > KINDS[kind].longest:
        raise UnusableMessage(f"its {len(data)} bytes are too many for its kind, {kind}")
    try:
        found = shape(kind).decode(data)
        sound = all(map(is_finite, msgspec.structs.astuple(found)))
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError):
        sound = False
    if not sound:
        raise UnusableMessage(f"it has not the shape of its kind, {kind}")


@cache
def shape(kind: str) -> msgspec.msgpack.Decoder:
    """What decodes a kind as strictly as viser has declared it."""
    declared, hints = message_class(kind), message_hints(kind)
    made: list[Any] = [("type", str)]
    for one in fields(declared):
        if one.name in hints and one.init:
            optional = () if one.default is MISSING else (one.default,)
            made.append((one.name, relax_numbers(hints[one.name]), *optional))
    made.sort(key=len)
    return msgspec.msgpack.Decoder(
        msgspec.defstruct(kind, made, forbid_unknown_fields=True, gc=False)
    )


def relax_numbers(hint: Any) -> Any:
    """A type as a page sends it: JavaScript does not tell 900 from 900.0."""
    if hint is int:
        return int | float
    if get_origin(hint) in (Union, types.UnionType):
        return Union[tuple(relax_numbers(one) for one in get_args(hint))]  # noqa: UP007
    return hint


def is_finite(value: Any) -> bool:
    """Whether all numbers of a field are; what a control is given is looked at by the control.

    >>> is_finite((1.0, (2.0, float("nan")))), is_finite({"value": float("inf")})
    (False, True)
    """
    if isinstance(value, float):
        return math.isfinite(value)
    if isinstance(value, tuple | list):
        return all(map(is_finite, value))
    return isinstance(value, Mapping) or not isinstance(value, int) or abs(value) < 2**53


# Which messages of one browser are passed on.

ALL = (500.0, 1000.0)
"""Messages and pings, a second and at once; more ends a connection."""
BYTES = (1024.0 * 1024, 2.0 * LARGEST)
"""Bytes, a second and at once; more ends a connection."""
DROPPED = (30.0, 300.0)
"""Messages that are dropped, a second and at once; more ends a connection."""
UNUSABLE = 5.0
"""As many dropped messages does one count that nobody can use."""
TOO_MUCH = "more messages than anybody can mean"


class MessageFilter:
    """Decides which messages of one browser are passed on to viser; used by the front's thread.

    `shared` is a limit that all connections of an address have in common; `log` gets a line for a
    message that nobody can use; `expected` knows the answers that were asked for; `kinds` are the
    kinds that may be passed on.
    """

    def __init__(
        self,
        shared: RateLimit,
        log: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
        expected: Callable[[bytes], bool] = lambda _: False,
        kinds: Mapping[str, AllowedMessage] = KINDS,
    ):
        self.shared = shared
        self.expected = expected
        self.log = log
        self.messages = RateLimit(*ALL, clock)
        self.bytes = RateLimit(*BYTES, clock)
        self.dropped = RateLimit(*DROPPED, clock)
        self.kinds = {name: RateLimit(kind.rate, kind.most, clock) for name, kind in kinds.items()}
        self.introduced = False
        """Whether the browser has sent its camera."""
        self.verdict = ""
        """Why the connection is to be ended; empty: it is not."""

    def count_bytes(self, size: int) -> None:
        """Count bytes as they come in, whether they are a whole message yet or not."""
        if not self.bytes.take(size):
            self.verdict = self.verdict or TOO_MUCH

    def count_message(self) -> None:
        """Count a message or a ping."""
        if not self.messages.take():
            self.verdict = self.verdict or TOO_MUCH

    def accepts(self, data: bytes | str) -> bool:
        """Whether viser may have a message."""
        if self.verdict:
            return False
        try:
            return self.judge(data)
        except UnusableMessage as why:
            self.log(str(why))
            self.drop(UNUSABLE)
            return False

    def judge(self, data: bytes | str) -> bool:
        """Whether a message is allowed now. Raises Unusable."""
        if isinstance(data, str):
            raise UnusableMessage("it is text")
        kind = kind_of(data)
        limit = self.kinds.get(kind)
        if limit is None:
            if kind not in KNOWN:
                raise UnusableMessage("it is of no kind that there is")
            return self.drop()
        if not (self.introduced or kind == CAMERA):
            return self.drop()
        if not (limit.take() and self.shared.take()):
            return self.drop()
        demand_shape(kind, data)
        if kind == RENDER:
            if not self.expected(data):
                return self.drop()
            self.bytes.give_back(len(data))  # we asked for them
        self.introduced = True
        return True

    def drop(self, cost: float = 1.0) -> bool:
        """Count a message that is not passed on; a connection that goes on so is to be ended."""
        if not self.dropped.take(cost):
            self.verdict = self.verdict or TOO_MUCH
        return False
