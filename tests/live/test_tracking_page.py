"""Pages of tracking: their Python runs, the source works as printed, the table can be read."""

from __future__ import annotations

import json
import math
import re
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest

from app.live.control.pose import Pose, seen, unseen
from app.live.sources.axes import NOSES, UNITS, UPS
from app.live.sources.feed import Feed
from app.live.sources.mocap import SYSTEMS
from app.live.sources.recorded_source import COLUMNS, SUFFIXES, RecordedSource
from app.live.sources.source_catalogue import OPENERS, open_source
from tests.live.natnet_emulator import free_port
from worlds.input_error import InputError

DOCS = Path(__file__).parents[2] / "docs"
PAGE = "\n".join(
    (DOCS / f"{name}.md").read_text(encoding="utf-8")
    for name in ("tracking", "tracking-recordings", "tracking-source")
)


def blocks(language):
    return re.findall(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


@pytest.fixture
def datagrams(tmp_path, monkeypatch):
    (tmp_path / "datagrams.py").write_text(blocks("python")[1], encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    import datagrams

    monkeypatch.setitem(OPENERS, "datagrams", datagrams.opened)
    yield
    del sys.modules["datagrams"]


@pytest.mark.usefixtures("datagrams")
def test_a_source_of_ones_own_is_one_like_any_other():
    with pytest.raises(InputError, match="port = 'x' is no whole number"):
        open_source("datagrams:x")
    port = free_port()
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender,
        Feed(open_source(f"datagrams:{port}")) as feed,
    ):
        give_up = time.monotonic() + 15.0
        while feed.latest() is None and time.monotonic() < give_up:
            sent = json.dumps({"car1": [1.0, 2.0, 0.5], "car2": None}).encode()
            sender.sendto(sent, ("127.0.0.1", port))
            time.sleep(0.02)
        assert feed.first(0.0).sightings == (
            seen("car1", Pose(1.0, 2.0, 0.5)),
            unseen("car2"),
        )
        sender.sendto(b"no JSON", ("127.0.0.1", port))
        while not feed.trouble and time.monotonic() < give_up:
            time.sleep(0.01)
        assert feed.trouble == (
            f"datagrams on port {port}: Expecting value: line 1 column 1 (char 0); "
            "it is opened again in 1 s"
        )


def test_the_python_of_the_page_prints_what_it_says(tmp_path):
    pytest.importorskip("motioncapture")
    code = blocks("python")[0]
    script = tmp_path / "script.py"
    script.write_text(f"import sys\nsys.path[:0] = {sys.path!r}\n{code}", encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, timeout=60, check=True
    )
    said = [line.partition("  # ")[2] for line in code.splitlines() if "print(" in line]
    assert done.stdout.splitlines() == said


def test_the_table_of_the_page_is_read(tmp_path):
    path = tmp_path / "poses.csv"
    [table] = blocks("csv")
    path.write_text(table, encoding="utf-8")
    first, second = RecordedSource(path).recording()
    assert first.sightings[0] == seen("car1", Pose(1.0, 2.0, 0.0))
    assert first.sightings[1].pose.yaw == pytest.approx(math.pi / 2)
    assert second.sightings[1] == unseen("car2")
    path.write_text(table.replace("1.100", "abc"), encoding="utf-8")
    with pytest.raises(InputError) as refused:
        RecordedSource(path).recording()
    assert f"`{str(refused.value).replace(str(path), 'poses.csv')}`" in PAGE


def test_the_refusal_of_the_page_is_what_is_said():
    with pytest.raises(InputError) as refused:
        open_source("optitrack:10.0.0.1?port=1510")
    assert f"    {refused.value}\n" in PAGE


def test_the_page_names_every_kind_option_and_column():
    for kind in OPENERS:
        assert f"`{kind}:" in PAGE
    for name in (*UPS, *UNITS, *NOSES, *COLUMNS, "factor=2", "again=yes", "body=NAME,REAR,FRONT"):
        assert f"`{name}`" in PAGE
    for system in SYSTEMS.values():
        for option in system.options:
            assert option in PAGE
    for suffix in SUFFIXES:
        assert suffix in PAGE
