"""Arrays of NumPy, zip and HDF5 files that anybody may have made, read with bounds.

A few bytes can declare arrays of any size, a pickle can run code, and an HDF5 file can point to
other files. So what is declared is looked at before room is made for it, a pickle is taken only if
it holds nothing but plain values and arrays, and links out of a file are not followed.
"""

from __future__ import annotations

import io
import math
import pickle
import pickletools
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, ClassVar

import numpy as np

from worlds.input_error import InputError, shorten
from worlds.plug_ins import demand

MOST_BYTES = 3 << 30
"""Of an array."""
MOST_PARTS = 10_000
"""Names at the top of an HDF5 file, members of a zip file."""
LARGEST_CHUNK = 1 << 28
"""Bytes of a chunk of HDF5, for which its library makes room whatever is in it."""
LONGEST_TEXT = 1 << 20
"""Bytes of a text of HDF5."""
PLAIN_KINDS = "biuf"
"""Kinds of NumPy types that are numbers."""


# NumPy: arrays, and dictionaries in pickles.


def read_npy(path: Path) -> Any:
    """The array of a .npy file, or the plain value that it holds as a pickle. Raises InputError."""
    with open(path, "rb") as file:
        return npy_of(file, path.stat().st_size, path.name)


def npy_of(file: BinaryIO, size: int, name: str) -> Any:
    """The same of an open file, or member of a zip file, of so many bytes."""
    try:
        version = np.lib.format.read_magic(file)
        read_header = {
            (1, 0): np.lib.format.read_array_header_1_0,
            (2, 0): np.lib.format.read_array_header_2_0,
        }.get(version)
        if read_header is None:
            raise ValueError("an unknown version")
        shape, fortran, kind = read_header(file, max_header_size=10_000)
    except (ValueError, SyntaxError, OverflowError, RecursionError, MemoryError):
        raise InputError(f"{name} is damaged: its header cannot be read") from None
    if kind.hasobject:
        if shape != ():
            raise InputError(f"{name} holds an array of objects, which are not read")
        values = plain_values(file.read(size), name)  # of an array of one object
        return values[0] if isinstance(values, list) and len(values) == 1 else values
    count = math.prod(shape)
    if kind.names or kind.subdtype or kind.kind not in "biufcSU":
        raise InputError(f"{name} holds an array of {shorten(str(kind))}, not of numbers")
    if count * kind.itemsize > min(size, MOST_BYTES):
        raise InputError(
            f"{name} is damaged: it declares {count * kind.itemsize} bytes and has {size}"
        )
    content = file.read(count * kind.itemsize)
    if len(content) < count * kind.itemsize:
        raise InputError(f"{name} is damaged: it ends too early")
    return np.frombuffer(content, kind).reshape(shape, order="F" if fortran else "C")


@contextmanager
def opened_zip(path: Path) -> Iterator[zipfile.ZipFile]:
    """A zip file of few members. Raises InputError, also for what its reading raises."""
    try:
        with zipfile.ZipFile(path) as opened:
            if len(opened.infolist()) > MOST_PARTS:
                raise InputError(f"{path.name} holds more than {MOST_PARTS} files")
            yield opened
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError):
        raise InputError(f"{path.name} is damaged: it cannot be unpacked") from None


def zip_names(path: Path) -> frozenset[str]:
    """The members of a zip file, arrays without their .npy; empty for one that cannot be read."""
    try:
        with opened_zip(path) as opened:
            return frozenset(info.filename.removesuffix(".npy") for info in opened.infolist())
    except InputError:
        return frozenset()


def read_npz(path: Path, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """The arrays of a .npz file that are there of these names. Raises InputError."""
    arrays = {}
    with opened_zip(path) as opened:
        for info in opened.infolist():
            name = info.filename.removesuffix(".npy")
            if name not in names:
                continue
            if info.file_size > MOST_BYTES:
                raise InputError(f"{path.name}: {name} unpacks to {info.file_size} bytes, too many")
            with opened.open(info) as member:
                array = npy_of(member, info.file_size, f"{path.name}, {name}")  # type: ignore[arg-type]
            if not isinstance(array, np.ndarray):
                raise InputError(f"{path.name}: {name} is no array")
            arrays[name] = array
    return arrays


# Pickles. Only opcodes that make plain values, and the few calls that make an array of NumPy: these
# are to functions of our own, so that nothing of a pickle reaches NumPy before it is checked.

OPCODES = {
    "PROTO", "FRAME", "STOP", "MARK", "POP", "POP_MARK", "DUP", "MEMOIZE", "PUT", "BINPUT",
    "LONG_BINPUT", "GET", "BINGET", "LONG_BINGET", "NONE", "NEWTRUE", "NEWFALSE", "INT", "BININT",
    "BININT1", "BININT2", "LONG", "LONG1", "LONG4", "FLOAT", "BINFLOAT", "STRING", "BINSTRING",
    "SHORT_BINSTRING", "BINBYTES", "SHORT_BINBYTES", "BINBYTES8", "BYTEARRAY8", "UNICODE",
    "BINUNICODE", "SHORT_BINUNICODE", "BINUNICODE8", "EMPTY_LIST", "APPEND", "APPENDS", "LIST",
    "EMPTY_TUPLE", "TUPLE", "TUPLE1", "TUPLE2", "TUPLE3", "EMPTY_DICT", "DICT", "SETITEM",
    "SETITEMS", "GLOBAL", "STACK_GLOBAL", "REDUCE", "BUILD",
}  # fmt: skip
"""What a pickle may be made of."""
MOST_OPCODES = 5_000_000
LONGEST_NUMBER = 64
"""Bytes of a whole number of a pickle."""


def plain_values(content: bytes, name: str) -> Any:
    """What a pickle holds, if that is plain values and arrays. Nothing in it is run.

    Raises InputError for anything else, and for a damaged one.
    """
    count = 0
    try:
        for opcode, argument, _ in pickletools.genops(io.BytesIO(content)):
            count += 1
            if opcode.name not in OPCODES or count > MOST_OPCODES:
                raise refused_pickle(name, f"it has {opcode.name}")
            if opcode.name in ("PUT", "LONG_BINPUT") and not 0 <= int(argument or 0) <= count:
                raise refused_pickle(name, "it counts wrongly")  # or room is made for as many
            if isinstance(argument, int) and abs(argument) >> 8 * LONGEST_NUMBER:
                raise refused_pickle(name, "it has a number that is too long")
        return plain_value(PlainUnpickler(io.BytesIO(content), name).load())
    except InputError as refusal:
        message = str(refusal)
        raise InputError(message if name in message else f"{name} is damaged: {message}") from None
    except RecursionError:
        raise InputError(f"{name} is damaged: it is nested too deep") from None
    except Exception as error:  # whatever a damaged pickle has our functions called with
        raise InputError(f"{name} is damaged: {shorten(' '.join(str(error).split()))}") from None


def refused_pickle(name: str, reason: str) -> InputError:
    """The refusal of a pickle that is more than values."""
    return InputError(
        f"{name} is refused: {reason}; only plain values and arrays are read from a pickle, as "
        "others could run code"
    )


class PlainUnpickler(pickle.Unpickler):
    """Reads pickles that call nothing but what makes arrays."""

    def __init__(self, file: BinaryIO, name: str):
        super().__init__(file, encoding="latin1")
        self.name = name

    def find_class(self, module: str, name: str) -> Any:
        """What stands for a function of NumPy. Raises InputError for anything else."""
        maker = ArrayMaker.kinds.get((module.replace("numpy.core", "numpy._core"), name))
        if maker is None:
            raise refused_pickle(self.name, f"it calls {shorten(f'{module}.{name}')}")
        return ArrayMaker(maker)


class PickledType:
    """A type of NumPy in a pickle: what it was called with, then the order of its bytes."""

    def __init__(self, code: object):
        if not isinstance(code, str) or len(code) > 12:
            raise InputError("a type of an array is none")
        self.code = code.lstrip("<>|=")
        self.order: Any = "="

    def __setstate__(self, state: Any) -> None:
        order = state[1]
        if order not in ("<", ">", "|", "="):
            raise InputError("the order of bytes of an array is none")
        self.order = order

    def dtype(self) -> np.dtype:
        """The type. Raises InputError for one that is neither numbers nor text."""
        kind = np.dtype(self.code)
        if kind.names or kind.subdtype or kind.kind not in "biufSUO":
            raise InputError(f"an array of {shorten(self.code)} is not read")
        return kind.newbyteorder(self.order) if kind.kind != "O" else kind


class PickledArray:
    """An array of NumPy in a pickle, which is filled by its state."""

    def __init__(self) -> None:
        self.array: Any = np.zeros(0)

    def __setstate__(self, state: Any) -> None:
        _, shape, kind, is_fortran, content = state
        self.array = array_of(content, kind, shape, "F" if is_fortran else "C")


class ArrayMaker:
    """Stands in a pickle for a function that makes an array; it has no state to be changed."""

    __slots__ = ("_kind",)
    kinds: ClassVar = {
        ("numpy._core.multiarray", "_reconstruct"): "array",
        ("numpy._core.multiarray", "scalar"): "scalar",
        ("numpy._core.numeric", "_frombuffer"): "buffer",
        ("numpy", "ndarray"): "class",
        ("numpy", "dtype"): "type",
        ("_codecs", "encode"): "bytes",
    }  # fmt: skip

    def __init__(self, kind: str):
        self._kind = kind

    def __call__(self, *arguments: Any) -> Any:
        if self._kind == "array":
            return PickledArray()
        if self._kind == "type":
            return PickledType(arguments[0])
        if self._kind == "bytes":  # how bytes stand in pickles of Python 2's protocol
            text, encoding = arguments
            if encoding != "latin1" or not isinstance(text, str):
                raise InputError("bytes of a pickle are none")
            return text.encode("latin1")
        if self._kind == "scalar":
            kind, content = arguments
            return array_of(content, kind, (), "C").item()
        if self._kind == "buffer":
            content, kind, shape, order = arguments
            return array_of(content, kind, shape, order)
        raise InputError("a class of a pickle is called")

    def __setstate__(self, state: Any) -> None:
        raise InputError("a function of a pickle is given a state")


def array_of(content: Any, kind: Any, shape: Any, order: str) -> Any:
    """An array of its bytes, once they are as many as its type and shape say."""
    if not isinstance(kind, PickledType) or not all(isinstance(side, int) for side in shape):
        raise InputError("an array of a pickle has no type or no shape")
    dtype, count = kind.dtype(), math.prod(shape)
    if dtype.kind == "O":
        if not isinstance(content, list) or len(content) != count:
            raise InputError("an array of objects of a pickle has no values")
        return content
    if isinstance(content, str):  # of Python 2
        content = content.encode("latin1")
    if not isinstance(content, bytes | bytearray) or len(content) != count * dtype.itemsize:
        raise InputError(f"an array of {shape} does not have as many bytes")
    if order not in ("C", "F"):
        raise InputError("the order of an array is none")
    return np.frombuffer(content, dtype).reshape(tuple(shape), order=order)  # type: ignore[call-overload]


MOST_ITEMS = 1_000_000
"""Values of a pickle that are taken: a list may hold itself many times."""


def plain_value(value: Any, depth: int = 0, budget: list[int] | None = None) -> Any:
    """A value with arrays of NumPy for those of a pickle, a few levels of it."""
    budget = [MOST_ITEMS] if budget is None else budget
    budget[0] -= 1
    if budget[0] < 0 or depth > 4 or isinstance(value, (ArrayMaker, PickledType)):
        return None
    if isinstance(value, PickledArray):
        return plain_value(value.array, depth, budget)
    if isinstance(value, dict):
        return {
            str(key): plain_value(item, depth + 1, budget)
            for key, item in value.items()
            if isinstance(key, str | int)
        }
    if isinstance(value, list | tuple):
        return [plain_value(item, depth + 1, budget) for item in value]
    return value


# HDF5.


class ArrayFile:
    """An open HDF5 file, whose arrays are read once they are found to be of a sensible size."""

    def __init__(self, file: Any, name: str):
        self.file, self.name = file, name

    def has(self, path: str) -> bool:
        """Whether there is an array of this name, in the file itself."""
        import h5py

        at = self.file
        for part in path.split("/"):
            if not isinstance(at, h5py.Group) or part not in at:
                return False
            if not isinstance(at.get(part, getlink=True), h5py.HardLink):
                return False  # a link to another file, which is not ours to open
            at = at[part]
        return isinstance(at, h5py.Dataset)

    def array(self, path: str, kinds: str = PLAIN_KINDS) -> np.ndarray:
        """An array of numbers, or of records of numbers ("V"). Raises InputError."""
        dataset = self.dataset(path)
        if dataset.dtype.kind not in kinds:
            raise InputError(f"{self.name}: {path} does not hold numbers")
        return np.asarray(dataset[()])

    def dataset(self, path: str) -> Any:
        """An array that is not read yet, once its size is sensible. Raises InputError."""
        if not self.has(path):
            raise InputError(f"{self.name} has no {path}")
        dataset = self.file[path]
        if dataset.shape is None:
            raise InputError(f"{self.name}: {path} is empty")
        size = math.prod(dataset.shape) * dataset.dtype.itemsize
        chunk = math.prod(dataset.chunks or ()) * dataset.dtype.itemsize
        if size > MOST_BYTES or chunk > LARGEST_CHUNK:
            raise InputError(
                f"{self.name}: {path} of shape {dataset.shape} is too large: {MOST_BYTES >> 20} "
                "MiB are read"
            )
        if dataset.external or dataset.is_virtual:
            raise InputError(f"{self.name}: {path} lies in other files, which are not opened")
        return dataset

    def texts(self, path: str) -> list[str]:
        """A list of texts, of fixed or of any length. Raises InputError."""
        dataset = self.dataset(path)
        if dataset.dtype.kind not in "SUO" or dataset.size > MOST_PARTS:
            raise InputError(f"{self.name}: {path} is no list of names")
        values = np.ravel(dataset.asstr(errors="replace")[()] if dataset.dtype.kind != "U"
                          else dataset[()])  # fmt: skip
        return [str(value)[:1000] for value in values.tolist()]

    def attribute(self, name: str, path: str = "") -> Any:
        """A number or a text of the file, or of a part of it; None if there is none."""
        holder = self.file[path] if path else self.file
        if name not in holder.attrs:
            return None
        stored = holder.attrs.get_id(name)
        if math.prod(stored.shape or (1,)) > 10_000:
            return None
        value = holder.attrs[name]
        if isinstance(value, bytes):
            value = value.decode("utf-8", "replace")
        if isinstance(value, np.ndarray | np.generic):
            value = value.item() if value.size == 1 else value.tolist()
        return value[:LONGEST_TEXT] if isinstance(value, str) else value


@contextmanager
def opened_hdf5(path: Path) -> Iterator[ArrayFile]:
    """An HDF5 file. Raises InputError, also for what its library raises while it is read."""
    demand("h5py", f"reading {path.name}", "tracks")
    import h5py

    try:
        with h5py.File(path, "r", locking=False) as file:
            yield ArrayFile(file, path.name)
    except InputError:
        raise
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError, MemoryError):
        raise InputError(f"{path.name} is damaged: it cannot be read as HDF5") from None


def hdf5_names(path: Path) -> frozenset[str]:
    """The names at the top of an HDF5 file; empty for one that cannot be read."""
    demand("h5py", f"reading {path.name}", "tracks")
    try:
        with opened_hdf5(path) as opened:
            names = opened.file.keys()
            # a name that is no UTF-8 is bytes
            return frozenset(name for name in list(names)[:MOST_PARTS] if isinstance(name, str))
    except InputError:
        return frozenset()
