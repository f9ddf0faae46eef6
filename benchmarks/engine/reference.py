"""Compiles `vicsek.cpp`, the same model written in C++ by hand, and calls it."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

SOURCE = Path(__file__).with_name("vicsek.cpp")
COMPILER = os.environ.get("CXX", "g++")
OPTIONS = ("-std=c++17", "-O3", "-march=native", "-shared", "-fPIC")
COLUMN = np.ctypeslib.ndpointer(np.float64, ndim=1, flags="C_CONTIGUOUS")
ARGUMENTS = [
    ctypes.c_int64, ctypes.c_double, ctypes.c_double, ctypes.c_double, ctypes.c_double,
    ctypes.c_uint64, ctypes.c_int64, COLUMN, COLUMN, COLUMN, COLUMN,
]  # fmt: skip


def reference() -> Callable[..., None] | None:
    """`run` of `vicsek.cpp`, None without a compiler.

    `run(n, side, r, v0, eta, seed, ticks, x, y, ux, uy)`: the four columns, (n,) float64 each, are
    positions in [0, side) and headings, and are written to; side is at least 3 r.
    """
    compiler = shutil.which(COMPILER)
    if compiler is None:
        return None
    with tempfile.TemporaryDirectory() as folder:
        library = Path(folder) / "vicsek.so"
        subprocess.run([compiler, *OPTIONS, str(SOURCE), "-o", str(library)], check=True)
        run = ctypes.CDLL(str(library)).run
    run.argtypes, run.restype = ARGUMENTS, None
    return run
