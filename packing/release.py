"""Make the wheels of a release: one for each Python, with the kernels of all models.

    uv run python packing/release.py [--python 3.12 3.13] [--models MODEL ...] [--out dist]

A wheel without kernels is built and installed for each Python; that compiles all models for the
levels of x86-64 that this machine can run, which takes some minutes each; and a wheel is built with
what came of it. Where numba, Python or the CPU do not fit, the wheel compiles as one without does.
For each wheel a line says how many kernels it has, for which CPUs, and how large it is.
"""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from agents.engine.cache import FOLDER, count_kernels  # noqa: E402
from worlds.compilation import levels_here  # noqa: E402

PYTHONS = ("3.12", "3.13")
PLATFORM = "manylinux_2_28_x86_64"
"""The systems that a wheel is for: kernels call nothing of the C library but its mathematics."""


def run(*words: object, **variables: object) -> str:
    """Run a program in the checkout, with variables in its environment; its stdout."""
    environment = {name: value for name, value in os.environ.items() if name != "VIRTUAL_ENV"}
    environment |= {name: str(value) for name, value in variables.items()}
    command = [str(word) for word in words]
    done = subprocess.run(command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, text=True)
    if done.returncode:
        raise SystemExit(f"{command[0]} ended with {done.returncode}: {' '.join(command)}")
    return done.stdout


def build(folder: Path, **variables: object) -> Path:
    """The one wheel that is built into an empty folder."""
    run("uv", "build", "--quiet", "--wheel", "--out-dir", folder, **variables)
    [wheel] = folder.glob("*.whl")
    return wheel


def compile_models(wheel: Path, python: str, models: list[str], folder: Path) -> None:
    """Compile models as they are in a wheel, for each level, into a folder."""
    here = folder / "environment"
    run("uv", "venv", "--quiet", "--python", python, here)
    locked = folder / "locked.txt"
    locked.write_text(
        run("uv", "export", "--quiet", "--locked", "--no-dev", "--no-hashes", "--no-emit-project")
    )
    install = "uv", "pip", "install", "--quiet", "--python", here / "bin" / "python"
    run(*install, "--constraints", locked, wheel)
    for level in levels_here():
        target = {"NUMBA_CPU_NAME": level, "NUMBA_CPU_FEATURES": ""}
        run(here / "bin" / "flockscope", "warm", *models, FLOCKSCOPE_CACHE=folder, **target)


def release(python: str, models: list[str], out: Path) -> str:
    """Build the wheel for one Python: a line that says what is in it."""
    with TemporaryDirectory(prefix="flockscope-") as name:
        folder = Path(name)
        compile_models(build(folder / "plain"), python, models, folder)
        counts = count_kernels(folder)
        tag = f"cp{python.replace('.', '')}-none-{PLATFORM}"
        kernels = {"FLOCKSCOPE_KERNELS": folder / FOLDER, "FLOCKSCOPE_WHEEL_TAG": tag}
        wheel = build(folder / "whole", **kernels)
        out.mkdir(parents=True, exist_ok=True)
        wheel = Path(shutil.copy(wheel, out))
    parts = [
        f"{number} kernels for {target}, {size / 1e6:.1f} MB"
        for target, (number, size) in counts.items()
    ]
    return f"{wheel}: {wheel.stat().st_size / 1e6:.1f} MB; {'; '.join(parts)}"


def main() -> None:
    """Make the wheels."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--python", nargs="+", default=PYTHONS, metavar="VERSION")
    parser.add_argument("--models", nargs="+", default=[], help="by default all")
    parser.add_argument("--out", type=Path, default=ROOT / "dist", metavar="FOLDER")
    arguments = parser.parse_args()
    if platform.system() != "Linux" or not levels_here():
        raise SystemExit("wheels with kernels are made on Linux, on a CPU of x86-64-v3 or later")
    for python in arguments.python:
        print(release(python, arguments.models, arguments.out.resolve()), flush=True)


if __name__ == "__main__":
    main()
