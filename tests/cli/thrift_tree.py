"""Footers of Parquet files as trees that can be changed: Thrift's compact protocol, there and back.

A struct is a list of [field, kind, value], a list is [kind of its values, values].
"""

from __future__ import annotations

TRUE, FALSE, BYTE, I16, I32, I64, DOUBLE, BINARY, LIST, SET, MAP, STRUCT = range(1, 13)
ODD = (0, 1, -1, 2, 7, 15, 127, 255, 2**31 - 1, -(2**31), 2**32, 2**63 - 1, -(2**63))


class Cursor:
    """Reads values from bytes."""

    def __init__(self, content):
        self.content, self.at = content, 0

    def take(self, count):
        self.at += count
        return self.content[self.at - count : self.at]

    def varint(self):
        value = shift = 0
        while True:
            (more,) = self.take(1)
            value |= (more & 127) << shift
            shift += 7
            if more < 128:
                return value

    def value(self, kind):
        if kind in (I16, I32, I64):
            raw = self.varint()
            return (raw >> 1) ^ -(raw & 1)
        if kind == BINARY:
            return self.take(self.varint())
        if kind == LIST:
            (head,) = self.take(1)
            count = head >> 4 if head >> 4 < 15 else self.varint()
            return [head & 15, [self.value(head & 15) for _ in range(count)]]
        if kind == STRUCT:
            return self.struct()
        return self.take({BYTE: 1, DOUBLE: 8}[kind])

    def struct(self):
        fields, field = [], 0
        while head := self.take(1)[0]:
            field = field + (head >> 4) if head >> 4 else self.value(I16)
            kind = head & 15
            fields.append([field, kind, None if kind in (TRUE, FALSE) else self.value(kind)])
        return fields


def varint(value):
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes(out) + bytes([value])


def zigzag(value):
    return varint(value << 1 if value >= 0 else (-value << 1) - 1)


def packed(kind, value):
    """A value as bytes."""
    if kind in (I16, I32, I64):
        return zigzag(value)
    if kind == BINARY:
        return varint(len(value)) + value
    if kind == LIST:
        of, values = value
        return bytes([0xF0 | of]) + varint(len(values)) + b"".join(packed(of, v) for v in values)
    if kind != STRUCT:
        return value
    out = b""
    for field, kind, inner in value:
        out += bytes([kind]) + zigzag(field)
        out += b"" if kind in (TRUE, FALSE) else packed(kind, inner)
    return out + b"\0"


def split(content):
    """What stands before the footer of a file, and the footer."""
    size = int.from_bytes(content[-8:-4], "little")
    return content[: -8 - size], content[-8 - size : -8]


def joined(body, footer):
    """The file of both."""
    return body + footer + len(footer).to_bytes(4, "little") + b"PAR1"


def fields_of(struct):
    """Every field in a struct, with the struct that it is in."""
    for field in struct:
        yield struct, field
        inner = field[2] if field[1] == LIST else [field[1], [field[2]]]
        if inner[0] == STRUCT:
            for one in inner[1]:
                yield from fields_of(one)


def change(tree, draw):
    """Change a field somewhere in a tree: leave it out, repeat it, rename it, or its value."""
    within, field = draw.choice(list(fields_of(tree)))
    kind, value, what = field[1], field[2], draw.random()
    if what < 0.25:
        within.remove(field)
    elif what < 0.3:
        within.append(list(field))
    elif what < 0.4:
        field[0] = draw.randrange(20)
    elif kind in (I16, I32, I64):
        field[2] = draw.choice([draw.choice(ODD), value + 1, value - 1, draw.randrange(40)])
    elif kind == BINARY:
        field[2] = draw.choice([b"", b"tick", value[:-1], b"\xff" + value, value[::-1]])
    elif kind == LIST and value[1]:
        values = list(value[1])
        values.pop() if what < 0.7 else values.append(draw.choice(values))
        field[2] = [value[0], values]
    elif kind in (TRUE, FALSE):
        field[1] = 3 - kind
    elif kind == STRUCT:
        field[2] = []


def forged(content, changed):
    """The file with a footer whose tree `changed` has changed."""
    body, footer = split(content)
    tree = Cursor(footer).struct()
    changed(tree)
    return joined(body, packed(STRUCT, tree))


def at(struct, *path):
    """The value at a path of field numbers and, in lists, places."""
    for step in path:
        if isinstance(struct, list) and struct and isinstance(struct[0], int):
            struct = struct[1][step]  # a list of values
        else:
            (struct,) = (value for field, _, value in struct if field == step)
    return struct


def without(struct, *path):
    """Leave out the field at a path."""
    inner = at(struct, *path[:-1])
    inner[:] = [one for one in inner if one[0] != path[-1]]


def put(struct, *path, value):
    """Give the field at a path another value."""
    (field,) = (one for one in at(struct, *path[:-1]) if one[0] == path[-1])
    field[2] = value
