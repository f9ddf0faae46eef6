"""Files from browsers are read by a process of their own, and cost the page nothing but a wait."""

from __future__ import annotations

import os
import time

import pytest

from app import sandboxed_reader
from app.sandboxed_reader import read_in_sandbox, read_toml
from app.viewer.editing import layout_file
from app.viewer.editing.layout_file import layout_from_browser
from app.viewer.gallery import saved_scene
from app.viewer.gallery.file_opener import open_file
from worlds.input_error import InputError
from worlds.obstacles import Disc
from worlds.world import World

HERE = __name__
WORLD = World(
    "mine", (20.0, 10.0), ("solid", "wrap"), obstacles=(Disc(centre=(5.0, 5.0), radius=1.0 / 3.0),)
)


def echo_process(name: str, content: bytes) -> bytes:
    """Which process reads."""
    return f"{os.getpid()} {name} {len(content)}".encode()


def take_memory(name: str, content: bytes) -> bytes:  # noqa: ARG001
    """More than a reader may have."""
    return bytes(2 * sandboxed_reader.MEMORY)


def read_for_ever(name: str, content: bytes) -> bytes:  # noqa: ARG001
    """A file that has no end."""
    while True:
        time.sleep(1.0)


def end_at_once(name: str, content: bytes) -> bytes:  # noqa: ARG001
    """A parser that crashes."""
    os._exit(0)


def test_a_file_is_read_by_another_process():
    process, name, size = read_in_sandbox(f"{HERE}:echo_process", "a.toml", b"123").split()
    assert (int(process) != os.getpid(), name, size) == (True, b"a.toml", b"3")


@pytest.mark.parametrize("reader", ["take_memory", "end_at_once"])
def test_a_reader_that_dies_is_a_refusal(reader):
    with pytest.raises(InputError, match=r"a\.dxf cannot be read: it is broken, or takes too much"):
        read_in_sandbox(f"{HERE}:{reader}", "a.dxf", b"")


def test_a_reader_that_takes_too_long_is_ended(monkeypatch):
    monkeypatch.setattr(sandboxed_reader, "TIMEOUT", 0.5)
    with pytest.raises(InputError, match=r"a.toml cannot be read within 0\.5 s"):
        read_in_sandbox(f"{HERE}:read_for_ever", "a.toml", b"")


def test_the_page_s_own_process_parses_nothing(monkeypatch):
    def parse(*_):
        raise AssertionError("parsed here")

    for module in (layout_file, saved_scene, sandboxed_reader):
        monkeypatch.setattr(module, "toml", parse)
    monkeypatch.setattr(layout_file, "read_geometry", parse)
    world = layout_from_browser("mine.toml", WORLD.to_toml().encode())
    assert world == WORLD, "to the bit"
    room = layout_from_browser("room.wkt", b"POLYGON ((0 0, 8 0, 8 8, 0 8, 0 0))")
    assert room.size == (8.0, 8.0)
    assert open_file("scene.toml", b'[run]\nmodel = "vem"\nagents = 30\n').spec.agents == 30


def test_what_is_wrong_is_said_as_before():
    disc = b'[[obstacle]]\nshape = "disc"\ncentre = [5.0, 5.0]\nradius = 1.0\n'
    with pytest.raises(InputError, match=r"big\.toml has 501 obstacles"):
        layout_from_browser("big.toml", b"size = 10.0\n" + 501 * disc)
    with pytest.raises(InputError, match=r"a\.toml is not TOML"):
        read_toml("a.toml", b"= 3")
    with pytest.raises(InputError, match=r"a\.toml is not a text file"):
        open_file("a.toml", b"\xff\xfe\xff" * 30)
    with pytest.raises(InputError, match="unknown kind of layout file"):
        layout_from_browser("a.exe", b"")
