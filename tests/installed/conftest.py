"""A wheel of this checkout, and environments in which nothing but it and its neighbours is."""

from __future__ import annotations

import os
import runpy
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ONE_NAME = runpy.run_path(str(ROOT / "packing" / "one_name.py"))
NEIGHBOUR = "openai-agents"
"""A package whose own name on the import path is `agents`."""
NEEDED = "3.12"
"""The Python that must be there: that of the checkout; another one that is not is left out."""
MESAS_FILES = ("agents.py", "app.py", "model.py")
"""The files of Mesa's own examples, as they may lie where somebody starts Python."""
PART = (
    "cli/calling.py", "cli/test_plug_ins.py",
    "experiments/small.py", "experiments/test_experiment.py",
    "live/recordings.py", "live/waiting.py", "live/test_recorded.py",
    "worlds/scenes.py", "worlds/test_layout.py", "test_refusals.py", "test_sources.py",
)  # fmt: skip
"""The part of the tests that is run against the wheel, with what it imports."""


def demand(*words, **more):
    """Run a program that has to succeed; what it printed on stdout."""
    words = [str(word) for word in words]
    ran = subprocess.run(words, capture_output=True, text=True, check=False, **more)
    assert ran.returncode == 0, f"{' '.join(words)}: {ran.returncode}\n{ran.stdout}\n{ran.stderr}"
    return ran.stdout


def uv(*words):
    """Run uv in the checkout; interpreters of pyenv are found wherever one is chosen."""
    versions = Path(os.environ.get("PYENV_ROOT", "~/.pyenv")).expanduser() / "versions"
    there = [str(path) for path in sorted(versions.glob("3.*/bin"))]
    path = os.pathsep.join([os.environ["PATH"], *there])
    return demand("uv", *words, cwd=ROOT, env={**os.environ, "PATH": path})


@pytest.fixture(scope="session")
def wheel(tmp_path_factory):
    """The wheel, made from the source distribution as an index would have it."""
    folder = tmp_path_factory.mktemp("dist")
    uv("build", "--quiet", "--out-dir", folder)
    [source] = folder.glob("*.tar.gz")
    assert source.stat().st_size < 8e6, "pictures of the docs are left out"
    [made] = folder.glob("*.whl")
    return made


class Installed:
    """An environment with the wheel in it, and a folder with Mesa's file names."""

    def __init__(self, version: str, wheel: Path, folder: Path):
        self.python = folder / "env" / "bin" / "python"
        self.folder = folder / "mine"
        self.environment = {
            name: value for name, value in os.environ.items()
            if name not in ("PYTHONPATH", "VIRTUAL_ENV")
        } | {"FLOCKSCOPE_CACHE": str(folder / "cache")}  # fmt: skip
        uv("venv", "--quiet", "--python", version, folder / "env")
        locked = folder / "locked.txt"
        locked.write_text(uv("export", "--quiet", "--locked", "--no-hashes", "--no-emit-project"))
        whole = f"flockscope[parquet] @ {wheel.as_uri()}"
        uv("pip", "install", "--quiet", "--python", self.python, "--constraints", locked,
           whole, NEIGHBOUR, "pytest", "hypothesis")  # fmt: skip
        self.folder.mkdir()
        for name in MESAS_FILES:
            (self.folder / name).write_text("raise SystemExit('this is mine')\n")

    def run(self, *words, cwd=None):
        """Run a program of the environment, in that folder: its stdout."""
        program, *rest = words
        return demand(self.python.with_name(program), *rest,
                      cwd=cwd or self.folder, env=self.environment)  # fmt: skip

    def start(self, *words):
        """Start the command `flockscope` in that folder."""
        return subprocess.Popen(
            [self.python.with_name("flockscope"), *words],
            cwd=self.folder, env=self.environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip


@pytest.fixture(scope="session", params=["3.12", "3.13"])
def installed(request, wheel, tmp_path_factory):
    """The wheel in an environment of one Python."""
    version = request.param
    try:
        uv("python", "find", version)
    except AssertionError as missing:
        try:
            uv("python", "install", version)
        except AssertionError:
            if version == NEEDED:
                raise missing from None
            pytest.skip(f"there is no Python {version} here, and none can be had")
    return Installed(version, wheel, tmp_path_factory.mktemp(f"python{version}-"))


@pytest.fixture(scope="session")
def released(tmp_path_factory):
    """The wheel of a release, which brings the kernels of vem, in an environment of its own."""
    out = tmp_path_factory.mktemp("release")
    script = (
        "packing/release.py",
        "--python",
        NEEDED,
        "--parts",
        "kernels",
        "--models",
        "vem",
        "--out",
        out,
    )
    line = uv("run", "python", *script)
    [wheel] = out.glob("*.whl")
    assert line.startswith(str(wheel))
    return Installed(NEEDED, wheel, tmp_path_factory.mktemp("released-"))


@pytest.fixture(scope="session")
def part_of_the_tests(tmp_path_factory):
    """Tests, their imports written as those of the wheel are, away from the checkout."""
    folder = tmp_path_factory.mktemp("part")
    for name in PART:
        target = folder / "tests" / name
        target.parent.mkdir(parents=True, exist_ok=True)
        source = (ROOT / "tests" / name).read_text(encoding="utf-8")
        target.write_text(ONE_NAME["rewritten"](source, name), encoding="utf-8")
    (folder / "pytest.ini").write_text("[pytest]\npythonpath = . tests\n")
    return folder
