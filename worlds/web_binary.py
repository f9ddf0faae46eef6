"""The binary format of WebAssembly: sections of a number, a length and a body.

Here is read what a module imports, and added by what names it is called.
"""

from __future__ import annotations

from collections.abc import Sequence

CUSTOM, IMPORTS, EXPORTS = 0, 2, 7
SYMBOL_TABLE = 8
"""A part of the custom section `linking`."""
FUNCTION, DATA, GLOBAL, SECTION, EVENT, TABLE = range(6)
"""What a symbol may be."""
OF_FUNCTION, OF_TABLE, OF_MEMORY, OF_GLOBAL = range(4)
"""What an import may be."""
UNDEFINED, NAMED = 0x10, 0x40
"""Flags of a symbol: it is imported; it has a name of its own all the same."""


def to_leb128(number: int) -> bytes:
    """A whole number from 0 on in seven bits a byte.

    >>> to_leb128(300).hex()
    'ac02'
    """
    found = bytearray()
    while True:
        found.append(number & 127 | (128 if number > 127 else 0))
        number >>= 7
        if not number:
            return bytes(found)


class BinaryReader:
    """Reads a module from its start."""

    def __init__(self, content: bytes, place: int = 0):
        self.content = content
        self.place = place

    def __bool__(self) -> bool:
        return self.place < len(self.content)

    def byte(self) -> int:
        """The next byte."""
        self.place += 1
        return self.content[self.place - 1]

    def number(self) -> int:
        """The next number."""
        found = shift = 0
        while True:
            byte = self.byte()
            found |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return found

    def block(self) -> bytes:
        """The next bytes, whose number stands before them."""
        size = self.number()
        self.place += size
        return self.content[self.place - size : self.place]


def imported_functions(content: bytes) -> list[str]:
    """The names of the functions that a module asks of whoever runs it."""
    reader = BinaryReader(content, place=8)
    names = []
    while reader:
        section, body = reader.byte(), BinaryReader(reader.block())
        if section != IMPORTS:
            continue
        for _ in range(body.number()):
            body.block()  # `env`
            name, kind = body.block().decode(), body.byte()
            if kind == OF_FUNCTION:
                names.append(name)
                body.number()
            elif kind == OF_GLOBAL:
                body.place += 2
            else:
                body.place += kind == OF_TABLE
                has_maximum = body.byte() & 1
                for _ in range(1 + has_maximum):
                    body.number()
    return names


def function_numbers(linking: bytes) -> dict[str, int]:
    """The numbers of a module's functions by name, from its section `linking`."""
    reader = BinaryReader(linking)
    reader.number()  # the version
    found: dict[str, int] = {}
    while reader:
        kind, body = reader.byte(), BinaryReader(reader.block())
        if kind != SYMBOL_TABLE:
            continue
        for _ in range(body.number()):
            what, flags = body.byte(), body.number()
            if what in (FUNCTION, GLOBAL, EVENT, TABLE):
                index = body.number()
                if not flags & UNDEFINED or flags & NAMED:
                    name = body.block().decode()
                    if what == FUNCTION:
                        found[name] = index
            elif what == DATA:
                body.block()
                if not flags & UNDEFINED:
                    for _ in range(3):
                        body.number()
            else:
                body.number()
    return found


def with_exports(content: bytes, names: Sequence[str]) -> bytes:
    """An object as a module that can be run: functions are exported, what linkers need is left
    out."""
    reader = BinaryReader(content, place=8)
    sections = []
    while reader:
        sections.append((reader.byte(), reader.block()))
    numbers: dict[str, int] = {}
    for kind, body in sections:
        inner = BinaryReader(body)
        if kind == CUSTOM and inner.block() == b"linking":
            numbers = function_numbers(body[inner.place :])
    exports = to_leb128(len(names)) + b"".join(
        to_leb128(len(name)) + name.encode() + b"\0" + to_leb128(numbers[name]) for name in names
    )
    kept = [section for section in sections if section[0] != CUSTOM]
    after = next((k for k, (kind, _) in enumerate(kept) if kind > EXPORTS), len(kept))
    kept.insert(after, (EXPORTS, exports))
    return content[:8] + b"".join(
        bytes([kind]) + to_leb128(len(body)) + body for kind, body in kept
    )
