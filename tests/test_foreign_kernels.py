"""Kernels that somebody else may have written are neither executed nor written over."""

from __future__ import annotations

import hashlib
import os
import pickle
import shutil
import subprocess
import sys
import zlib
from pathlib import Path

import pytest

from worlds.owned_files import NotOwned, open_in, owned_folder, read_owned, write_owned

SCRIPT = """
import os
os.umask(0)
from agents.engine.cache import compile_to_disk, is_kept

def doubled(x):
    return 2.0 * x

def trebled(x):
    return 3.0 * x

made = compile_to_disk(doubled), compile_to_disk(trebled)
print(is_kept(made[0]), made[0](3.0), made[1](3.0), sum(made[0].stats.cache_misses.values()))
"""
STRANGER = 12345
AS_ROOT = pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a file to another user")
LEVELS = ["base", "kernels", "digest", "file"]
"""What there is from the cache down to a file that is unpickled."""


class Attack:
    """A pickle of it leaves a file when it is read."""

    def __init__(self, marker: Path):
        self.marker = marker

    def __reduce__(self):
        return os.mkdir, (str(self.marker),)


def start(script: Path, cache: Path) -> tuple[list[str], list[str]]:
    """What two kernels print, and what is told, in a process of their own."""
    done = subprocess.run(
        [sys.executable, str(script)],
        env={
            **os.environ,
            "FLOCKSCOPE_CACHE": str(cache),
            "PYTHONPATH": os.getcwd(),
            "PYTHONDONTWRITEBYTECODE": "1",
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split(), done.stderr.splitlines()


def poison(cache: Path, marker: Path) -> list[Path]:
    """Replace every kernel by an attack with a right checksum; the files."""
    content = zlib.compress(pickle.dumps(Attack(marker)))
    found = sorted(cache.rglob("*.kernel"))
    for path in found:
        path.write_bytes(hashlib.sha256(content).digest() + content)
    return found


def level(cache: Path, kernel: Path, name: str) -> Path:
    """One of LEVELS on the way to a kernel's file."""
    return [cache, *reversed(kernel.parents[:2]), kernel][LEVELS.index(name)]


def state(folder: Path) -> dict[str, object]:
    """All that lies in a folder, with its content."""
    return {str(path): path.read_bytes() if path.is_file() else None for path in folder.rglob("*")}


@pytest.fixture(scope="module")
def warm(tmp_path_factory) -> tuple[Path, Path]:
    """A script, and the cache that it has filled: nobody but us may write to it."""
    folder = tmp_path_factory.mktemp("warm")
    script, cache = folder / "script.py", folder / "cache"
    script.write_text(SCRIPT)
    assert start(script, cache) == (["False", "6.0", "9.0", "1"], [])
    assert start(script, cache) == (["True", "6.0", "9.0", "0"], [])
    return script, cache


@pytest.fixture
def poisoned(warm, tmp_path: Path) -> list[Path]:
    """The kernels of such a cache that somebody has written to."""
    shutil.copytree(warm[1], tmp_path / "cache")
    kernels = poison(tmp_path / "cache", tmp_path / "attacked")
    assert len(kernels) == 2
    return kernels


def demand_unread(script: Path, tmp_path: Path, name: str) -> None:
    """The kernels are compiled instead, one line says so, and a foreign folder stays as it was."""
    before = state(tmp_path / "cache")
    printed, told = start(script, tmp_path / "cache")
    assert printed == ["False", "6.0", "9.0", "1"]
    assert len(told) == 1
    assert told[0].startswith(f"flockscope: compiled kernels in {tmp_path / 'cache'} are not used")
    assert not (tmp_path / "attacked").exists()
    if name != "file":
        assert state(tmp_path / "cache") == before


def test_the_attack_is_one(tmp_path, poisoned):
    """What the other tests hold against would be executed in a cache of our own."""
    pickle.loads(zlib.decompress(poisoned[0].read_bytes()[32:]))
    assert (tmp_path / "attacked").exists()


@pytest.mark.parametrize(
    ("name", "bits"), [*((name, 0o020) for name in LEVELS), ("base", 0o002), ("file", 0o002)]
)
def test_what_others_may_write_to_is_not_executed(warm, tmp_path, poisoned, name, bits):
    for kernel in poisoned:
        path = level(tmp_path / "cache", kernel, name)
        path.chmod(path.stat().st_mode | bits)
    demand_unread(warm[0], tmp_path, name)


@AS_ROOT
@pytest.mark.parametrize("name", LEVELS)
def test_what_another_user_owns_is_not_executed(warm, tmp_path, poisoned, name):
    for kernel in poisoned:
        os.chown(level(tmp_path / "cache", kernel, name), STRANGER, STRANGER)
    demand_unread(warm[0], tmp_path, name)


@pytest.mark.parametrize("name", LEVELS[1:])
def test_a_link_in_the_place_of_what_is_kept_is_not_followed(warm, tmp_path, poisoned, name):
    for number, path in enumerate({level(tmp_path / "cache", one, name) for one in poisoned}):
        elsewhere = tmp_path / f"elsewhere-{number}"
        path.rename(elsewhere)
        path.symlink_to(elsewhere)
    demand_unread(warm[0], tmp_path, name)


def test_what_is_made_is_for_its_user_alone(warm):
    """Also where the process lets everybody write to what it makes."""
    made = [warm[1], *warm[1].rglob("*")]
    assert {path.stat().st_mode & 0o777 for path in made} == {0o700, 0o600}


def test_a_folder_that_is_exchanged_after_the_check_is_not_read(tmp_path):
    write_owned(b"ours", tmp_path, "kernels", "one")
    with owned_folder(tmp_path, "kernels") as folder:
        (tmp_path / "kernels").rename(tmp_path / "before")
        write_owned(b"theirs", tmp_path, "kernels", "one")
        with open(open_in(folder, tmp_path / "kernels" / "one", os.O_RDONLY), "rb") as file:
            assert file.read() == b"ours"


def test_a_pipe_is_refused_and_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "one", 0o600)
    with pytest.raises(NotOwned, match="is no file"):
        read_owned(tmp_path, "one")
