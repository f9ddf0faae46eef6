"""Compiled functions as WebAssembly give what they give here."""

from __future__ import annotations

import math
import struct

import numpy as np
import pytest
import wasmtime
from hypothesis import given
from hypothesis import strategies as st

from worlds.compilation import compiled, entry
from worlds.web_assembly import (
    FIRST_FREE,
    MemoryImage,
    linked_code,
    web_module,
)
from worlds.web_binary import imported_functions, to_leb128

PAGE = 65536
"""Bytes of WebAssembly's unit of memory."""
STACK = 1024 * 1024


class Running:
    """A module that runs on an image of memory."""

    def __init__(self, content: bytes, image: MemoryImage):
        self.store = wasmtime.Store()
        module = wasmtime.Module(self.store.engine, content)
        pages = (FIRST_FREE + len(image.content)) // PAGE + 2
        self.memory = wasmtime.Memory(self.store, wasmtime.MemoryType(wasmtime.Limits(pages, None)))
        given_ = [self.given(one) for one in module.imports]
        self.exports = wasmtime.Instance(self.store, module, given_).exports(self.store)
        self.memory.write(self.store, bytes(image.content), FIRST_FREE)

    def given(self, wanted):
        """What a module imports, by its name."""
        if wanted.name == "__linear_memory":
            return self.memory
        if wanted.name == "__stack_pointer":
            kind = wasmtime.GlobalType(wasmtime.ValType.i32(), mutable=True)
            return wasmtime.Global(self.store, kind, wasmtime.Val.i32(STACK))
        if wanted.name == "__indirect_function_table":
            kind = wasmtime.TableType(wasmtime.ValType.funcref(), wasmtime.Limits(64, None))
            return wasmtime.Table(self.store, kind, None)
        if wanted.name == "sched_yield":
            return wasmtime.Func(self.store, wanted.type, lambda: 0)
        return wasmtime.Func(self.store, wanted.type, getattr(math, wanted.name))

    def call(self, name: str, image: MemoryImage) -> None:
        """Call a function, which is to raise nothing."""
        assert self.exports[name](self.store, image.block) == 0

    def read(self, address: int, layout: str):
        """Numbers that stand somewhere."""
        size = struct.calcsize(layout)
        return struct.unpack(layout, self.memory.read(self.store, address, address + size))

    def array(self, image: MemoryImage, path: str) -> np.ndarray:
        """An array as it is now."""
        found = image.arguments[path]
        size = int(np.prod(found.shape)) * np.dtype(found.kind).itemsize
        content = self.memory.read(self.store, found.address, found.address + size)
        return np.frombuffer(bytes(content), found.kind).reshape(found.shape)


def run(function, names: str, *values) -> tuple[Running, MemoryImage]:
    """Call a function there with these values."""
    image = MemoryImage()
    for name, value in zip(names.split(), values, strict=True):
        image.add(name, value)
    image.finish()
    module = web_module({"go": linked_code(function, values)})
    assert module.slots["go"] == tuple(kind for kind, _ in image.slots)
    running = Running(module.content, image)
    running.call("go", image)
    return running, image


@compiled
def bent(x):
    return math.sqrt(x) * math.atan2(x, 2.0)


@entry
def total(values, weight, doubles):
    s = 0.0
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            s += bent(values[i, j]) * weight
    return 2.0 * s if doubles else s


@entry
def shift(values, by, steps):
    for i in range(values.shape[0]):
        values[i] += by[0] * steps
    return len(by), steps


@entry
def split(values, fractions, exponents):
    for i in range(values.shape[0]):
        fractions[i], exponents[i] = math.frexp(values[i])


@pytest.mark.parametrize("doubles", [False, True])
def test_numbers_arrays_and_what_is_called_come_out_as_here(doubles):
    values = np.arange(12.0).reshape(3, 4)
    running, image = run(total, "values weight doubles", values, 0.5, doubles)
    assert running.read(image.answer, "<d")[0] == pytest.approx(total(values, 0.5, doubles), 1e-15)


def test_an_array_is_changed_in_place_and_several_answers_come_back():
    values, by = np.arange(5.0), np.array([2.0, 9.0])
    running, image = run(shift, "values by steps", values, by, 3)
    assert running.array(image, "values").tolist() == [6.0, 7.0, 8.0, 9.0, 10.0]
    assert running.read(image.answer, "<qq") == (2, 3)


@pytest.fixture(scope="module")
def frexp():
    values, exponents = np.zeros(1), np.zeros(1, np.int64)
    return run(split, "values fractions exponents", values, np.zeros(1), exponents)


@given(st.floats(allow_nan=False))
def test_frexp_needs_no_help_of_the_page(frexp, value):
    running, image = frexp
    place = image.arguments["values"].address
    running.memory.write(running.store, struct.pack("<d", value), place)
    running.call("go", image)
    fraction, exponent = math.frexp(value)
    assert running.array(image, "fractions")[0] == fraction
    assert math.isinf(value) or running.array(image, "exponents")[0] == exponent


def test_one_module_has_several_functions():
    image = MemoryImage()
    values = (np.arange(4.0).reshape(2, 2), 1.0, False)
    for name, value in zip(("values", "weight", "doubles"), values, strict=True):
        image.add(name, value)
    image.finish()
    both = {
        "add": linked_code(total, values),
        "move": linked_code(shift, (np.zeros(2), np.zeros(1), 1)),
    }
    module = web_module(both)
    running = Running(module.content, image)
    running.call("add", image)
    assert running.read(image.answer, "<d")[0] == pytest.approx(total(*values), 1e-15)
    assert set(module.slots) == {"add", "move"}


@entry
def rare(x):
    return math.erf(x) + math.exp(x)


def test_what_a_module_asks_for_is_read_from_it():
    module = web_module({"go": linked_code(rare, (0.5,))})
    asked = wasmtime.Module(wasmtime.Engine(), module.content).imports
    functions = [one.name for one in asked if isinstance(one.type, wasmtime.FuncType)]
    assert imported_functions(module.content) == functions
    assert sorted(functions) == ["erf", "exp"]


def test_the_same_array_stands_there_once_and_members_of_tuples_have_paths():
    image, shared = MemoryImage(), np.zeros(3)
    image.add("pair", (shared, (shared, 7)))
    assert image.arguments["pair.0"].address == image.arguments["pair.1.0"].address
    assert image.arguments["pair.1.1"].kind == "int64"
    assert all(one.address % 64 == 0 for one in image.arguments.values())


@pytest.mark.parametrize("value", ["text", None, 1j, {}])
def test_what_no_function_takes_is_refused_by_its_path(value):
    with pytest.raises(TypeError, match=r"context\.eta"):
        MemoryImage().add("context.eta", value)


def test_an_array_in_another_order_is_refused():
    with pytest.raises(ValueError, match="positions is not in C order"):
        MemoryImage().add("positions", np.zeros((2, 3)).T)


def test_a_module_needs_a_function():
    with pytest.raises(ValueError, match="needs a function"):
        web_module({})


@given(st.integers(0, 2**40))
def test_numbers_in_seven_bits_a_byte(number):
    packed = to_leb128(number)
    assert all(byte >= 128 for byte in packed[:-1])
    assert packed[-1] < 128
    assert sum((byte & 127) << 7 * k for k, byte in enumerate(packed)) == number
