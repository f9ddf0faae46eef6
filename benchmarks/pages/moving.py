"""Seconds from the command to a moving flock: `python benchmarks/pages/moving.py [NAME ...]`.

`flockscope lab MODEL`, or `--scene NAME`, is started with an empty cache, and once more with what
that has compiled. A program stands for the browser: it asks for the page until it is answered, and
then reads what a browser is sent, until the places of agents have come twice and differ, and until
the page no longer says that it waits for the compiler. Without names: every scene and every model.
"CPU": what the laboratory's own process has worked until the flock moved, which a busy machine does
not change as much. "Libraries": the import of mesa, viser and numba in a process of its own, in
turns with the starts, as a measure of the machine. The last lines name the slowest, those beyond
what a page and a flock may take, and how many times as long as the libraries they take.
"""

from __future__ import annotations

import math
import os
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.request
from collections.abc import Iterator
from dataclasses import dataclass
from statistics import median
from typing import Any

import msgspec
import viser
import zstandard
from websockets.sync.client import connect

from agents.catalogue import MODELS
from app.viewer.gallery.scene_collection import scene_names
from benchmarks.pages.stream import CAMERA

PAGE, MOVING = 1.5, 3.0
"""Longest time that a page, and a flock of which nothing is compiled, may take, s."""
TIMEOUT = 300.0
"""Longest time until a run is compiled, s."""
LIBRARIES = "import mesa, numba, viser"
"""What the laboratory stands on, and cannot be there before."""
STATUS, WAITS = "fs-status", "fs-compiling"
"""What the page says of the run, and has within it while that is not compiled."""


@dataclass
class Start:
    """What happened when after the command, s."""

    page: float
    moving: float
    cpu: float
    """CPU of the laboratory until then, s; NaN on other systems than Linux."""
    compiled: float


def start(name: str, cache: str) -> Start:
    """Start the laboratory once, and watch it until its compiled run moves."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port = free.getsockname()[1]
    what = ["--scene", name] if name in scene_names() else [name]
    started = time.monotonic()
    server = subprocess.Popen(
        ["flockscope", "lab", *what, "--no-open", "--port", str(port)],
        env=os.environ | {"FLOCKSCOPE_CACHE": cache},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        wait_for_page(port, started + TIMEOUT)
        return watch(port, server.pid, started, time.monotonic())
    finally:
        server.terminate()
        server.wait()


def import_libraries() -> float:
    """How long the import of LIBRARIES takes, s."""
    started = time.monotonic()
    subprocess.run([sys.executable, "-c", LIBRARIES], check=True)
    return time.monotonic() - started


def wait_for_page(port: int, end: float) -> None:
    """Ask for the page until it is answered."""
    while time.monotonic() < end:
        try:
            with urllib.request.urlopen(f"http://localhost:{port}") as answer:
                answer.read()
            return
        except (urllib.error.URLError, ConnectionError):
            time.sleep(0.02)
    raise TimeoutError("no page")


def cpu(process: int) -> float:
    """What a process has worked so far, s."""
    return time.clock_gettime(~process << 3 | 2) if sys.platform == "linux" else math.nan


def watch(port: int, process: int, started: float, answered: float) -> Start:
    """Read what a browser is sent; the first places of a batch of agents are those at tick 0."""
    began: dict[str, bytes] = {}
    moving, worked, waits = 0.0, 0.0, True
    kind: Any = f"viser-v{viser.__version__}"
    with connect(f"ws://localhost:{port}", subprotocols=[kind], max_size=None) as page:
        page.send(msgspec.msgpack.encode(CAMERA))
        while time.monotonic() < started + TIMEOUT:
            for name, updates in decode_changes(page.recv(timeout=TIMEOUT)):
                places = updates.get("batched_positions") or updates.get("points")
                if places and began.setdefault(name, places) != places and not moving:
                    moving, worked = time.monotonic() - started, cpu(process)
                if STATUS in str(updates.get("content", "")):
                    waits = WAITS in updates["content"]
            if moving and not waits:
                return Start(answered - started, moving, worked, time.monotonic() - started)
    raise TimeoutError("nothing moves")


def decode_changes(packet: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    """What changes on the page: of what, and to what; arrays as bytes."""
    size = int.from_bytes(packet[8:16], "little")
    plain = zstandard.ZstdDecompressor().decompress(packet[16 : 16 + size])
    content = msgspec.msgpack.decode(plain)
    arrays, at = [], 16 + size
    for length in content["binaryBufferLengths"]:
        arrays.append(packet[at : at + length])
        at += length
    for message in content["messages"]:
        updates = {
            key: arrays[value["__binary_index"]]
            if isinstance(value, dict) and "__binary_index" in value
            else value
            for key, value in message.get("updates", {}).items()
        }
        yield message.get("name") or message.get("uuid", ""), updates


def main() -> None:
    """Print a line for each scene and model."""
    print(f"{'s after the command':20}{'nothing compiled':^34}{'everything compiled':^34}")
    columns = f"{'page':>8}{'moving':>8}{'CPU':>8}{'compiled':>10}"
    print(f"{'':20}{columns}{columns}{'libraries':>11}", flush=True)
    first: dict[str, Start] = {}
    libraries: dict[str, float] = {}
    for name in sys.argv[1:] or (*scene_names(), *MODELS):
        with tempfile.TemporaryDirectory() as cache:
            both = start(name, cache), start(name, cache)
        first[name], libraries[name] = both[0], import_libraries()
        row = "".join(
            f"{sample.page:8.1f}{sample.moving:8.1f}{sample.cpu:8.1f}{sample.compiled:10.1f}"
            for sample in both
        )
        print(f"{name:20}{row}{libraries[name]:11.1f}", flush=True)
    for what, most in (("page", PAGE), ("moving", MOVING)):
        seconds = {name: getattr(sample, what) for name, sample in first.items()}
        slowest = max(seconds, key=seconds.__getitem__)
        late = [name for name, taken in seconds.items() if taken > most]
        ratio = median(seconds[name] / libraries[name] for name in seconds)
        print(
            f"{what}: at most {seconds[slowest]:.1f} s ({slowest}); beyond {most} s: "
            f"{len(late)} of {len(first)} {' '.join(late)}; {ratio:.2f} times the libraries"
        )


if __name__ == "__main__":
    main()
