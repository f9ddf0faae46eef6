"""Make a release, into a folder: wheels, the source, the site of the pages, and their checksums.

    uv run python packing/release.py [--parts check kernels plain site] [--python 3.12 3.13 3.14]
                                     [--models MODEL ...] [--out dist]

Parts, in this order, by default all:

- `check`: the version is the same in pyproject.toml, CITATION.cff and at the top of CHANGELOG.md.
- `kernels`: one wheel for each Python, with the kernels of all models. A wheel without kernels is
  built and installed for it; that compiles all models for the levels of x86-64 that this machine
  can run, which takes some minutes; and a wheel is built with what came of it. Where numba, Python
  or the CPU do not fit, the wheel compiles as one without does. A line says how many kernels it
  has, for which CPUs, and how large it is.
- `plain`: the source distribution, and a wheel without kernels for every other machine.
- `site`: the pages as a folder and as the wheel flockscope-docs.

SHA256SUMS names every file that is then in the folder, but for those of the site.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import platform
import re
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from agents.engine.cache import FOLDER, count_kernels  # noqa: E402
from worlds.compilation import levels_here  # noqa: E402

PYTHONS = ("3.12", "3.13", "3.14")
PARTS = ("check", "kernels", "plain", "site")
SUMS = "SHA256SUMS"
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
        wheel = Path(shutil.copy(wheel, out))
    parts = [
        f"{number} kernels for {target}, {size / 1e6:.1f} MB"
        for target, (number, size) in counts.items()
    ]
    return f"{wheel}: {wheel.stat().st_size / 1e6:.1f} MB; {'; '.join(parts)}"


VERSIONS = {
    "pyproject.toml": r'^version = "([^"]+)"',
    "CITATION.cff": r"^version: (\S+)",
    "CHANGELOG.md": r"^## ([\d.]+)",
}
"""Files that name the version, and how."""


def check_version() -> str:
    """The version, if all that name it agree. Raises SystemExit."""
    text = {name: (ROOT / name).read_text(encoding="utf-8") for name in VERSIONS}
    found = {name: re.search(pattern, text[name], re.M) for name, pattern in VERSIONS.items()}
    versions = {name: match[1] if match else "none" for name, match in found.items()}
    if len(set(versions.values())) != 1:
        raise SystemExit(f"the versions differ: {versions}")
    if "not yet released" in text["CHANGELOG.md"].partition("\n## ")[2].partition("\n")[0]:
        print("CHANGELOG.md says that this version is not yet released", file=sys.stderr)
    return f"version {versions['pyproject.toml']}"


def write_sums(out: Path) -> Path:
    """The checksums of the files of a folder, not of those below it, as `sha256sum --check` reads
    them."""
    files = sorted(path for path in out.iterdir() if path.is_file() and path.name != SUMS)
    lines = [
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n"
        for path in files
        if not path.name.startswith(".")
    ]
    (out / SUMS).write_text("".join(lines), encoding="utf-8")
    return out / SUMS


def main() -> None:
    """Make the release."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS, metavar="PART")
    parser.add_argument("--python", nargs="+", default=PYTHONS, metavar="VERSION")
    parser.add_argument("--models", nargs="+", default=[], help="by default all")
    parser.add_argument("--no-flocks", action="store_true", help="a site without flocks that run")
    parser.add_argument("--out", type=Path, default=ROOT / "dist", metavar="FOLDER")
    arguments = parser.parse_args()
    out = arguments.out.resolve()
    out.mkdir(parents=True, exist_ok=True)
    if "check" in arguments.parts:
        print(check_version())
    if "kernels" in arguments.parts:
        if platform.system() != "Linux" or not levels_here():
            raise SystemExit(
                "wheels with kernels are made on Linux, on a CPU of x86-64-v3 or later"
            )
        for python in arguments.python:
            print(release(python, arguments.models, out), flush=True)
    if "plain" in arguments.parts:
        run("uv", "build", "--quiet", "--out-dir", out)
    if "site" in arguments.parts:
        more = ["--no-flocks"] if arguments.no_flocks else []
        build_site = ROOT / "docs" / "build_site.py"
        print(run("uv", "run", "python", build_site, "--out", out / "site", "--wheel", out, *more))
    print(write_sums(out))


if __name__ == "__main__":
    main()
