"""What it costs that many watch one run: `python benchmarks/pages/watching.py [agents] [browsers]`;
and that one watches many agents: `python benchmarks/pages/watching.py many [2 or 3]`.

A laboratory and its watching page in a process of their own, and clients that read all they get
(programs, not browsers), each of which inspects an agent of its own and plots the usual. Prints
what a client gets, before anything is packed, and the processor time that it takes. What is for the
panels, and what it comes to when it is packed, is told of one client, which takes its messages
apart.

`many` is of flocks of `MANY` agents of the model vem, each in a laboratory that one client watches;
`many 3` of such flocks in space.
It prints the pictures that come, the processor time beside the simulation and in its thread, and
how long it takes from the start of the laboratory until the picture has changed, in seconds and in
seconds of processor time: the latter on a machine that does other things.
"""

from __future__ import annotations

import multiprocessing
import sys
import threading
import time
import zlib
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

import msgspec
import zstandard
from stream import open_page
from websockets.exceptions import ConnectionClosed

SECONDS = 10.0
SETTLE = 8.0
"""Seconds for all to come, and for what they inspect to be compiled."""
SPEED = 15.0
"""Ticks per second."""


def serve(agents: int, pipe: Connection) -> None:
    """The laboratory; answers every message of the pipe with processor time, s, and the tick."""
    from app.viewer.lab.laboratory import Laboratory
    from app.viewer.run.run_preset import preset_spec
    from app.viewer.watching.watch_page import WatchPage
    from app.viewer.watching.watcher import AgentSelection

    start = preset_spec("hwvem", agents=agents, parameters={"eta": 0.3})
    laboratory = Laboratory(start, port=0, speed=SPEED)
    watching = WatchPage(laboratory)
    laboratory.simulation.ready.wait()
    pipe.send(watching.port)
    while (request := pipe.recv()) is not None:
        if request == "inspect":
            run = laboratory.simulation.state.run
            for row, watcher in enumerate(watching.now):
                watcher.choose(AgentSelection(row, run=run))
        frame = laboratory.simulation.frame
        assert frame is not None
        pipe.send((time.process_time(), frame.tick, len(frame.others)))
    watching.close()
    laboratory.close()


class Reader:
    """A client that counts what it gets; one that `looks` also what is for the panels, and what all
    of it comes to when a line packs it (deflate, level 1)."""

    def __init__(self, port: int, agents: int, looks: bool):
        self.picture = 12 * agents
        self.looks = looks
        self.pictures = self.bytes = self.panels = self.packed = 0
        self.packer = zlib.compressobj(1, wbits=-15)
        self.socket = open_page(port)
        threading.Thread(target=self.read, daemon=True).start()

    def read(self) -> None:
        """Read until the server closes."""
        try:
            for data in self.socket:
                assert isinstance(data, bytes)
                self.bytes += len(data)
                self.pictures += len(data) > self.picture
                if self.looks:
                    self.panels += panel_bytes(data)
                    packed = self.packer.compress(data) + self.packer.flush(zlib.Z_SYNC_FLUSH)
                    self.packed += len(packed)
        except ConnectionClosed:
            pass


def unpacked(data: bytes) -> tuple[Any, int, int]:
    """A window of viser's messages, and the bytes of its words: packed, and as they are."""
    packed = int.from_bytes(data[8:16], "little")
    inner = zstandard.ZstdDecompressor().decompress(data[16 : 16 + packed])
    return msgspec.msgpack.decode(inner), packed, len(inner)


def panel_bytes(data: bytes) -> int:
    """How many bytes of a window of viser's messages are for the panels."""
    window, packed, whole = unpacked(data)
    size = sum(
        len(msgspec.msgpack.encode(message))
        for message in window["messages"]
        if message["type"][:3] == "Gui"
    )
    lengths = window["binaryBufferLengths"]
    buffers = sum(
        lengths[at]
        for message in window["messages"]
        if message["type"][:3] == "Gui"
        for at in buffer_indices(message)
    )
    return round(size * packed / whole) + buffers


def buffer_indices(message: Any) -> list[int]:
    """The binary buffers that a message refers to."""
    if isinstance(message, dict):
        if "__binary_index" in message:
            return [message["__binary_index"]]
        return [at for item in message.values() for at in buffer_indices(item)]
    return (
        [at for item in message for at in buffer_indices(item)] if isinstance(message, list) else []
    )


def main(agents: int = 1000, browsers: int = 40) -> None:
    """Measure and print."""
    parent_end, child_end = multiprocessing.Pipe()
    server = multiprocessing.get_context("spawn").Process(target=serve, args=(agents, child_end))
    server.start()
    port = parent_end.recv()
    time.sleep(3.0)
    idle = cores_used(parent_end, 5.0)
    readers = [Reader(port, agents, number == 0) for number in range(browsers)]
    time.sleep(SETTLE)
    watched, *counts = measure_readers(parent_end, readers)
    ask_server(parent_end, "inspect")
    time.sleep(SETTLE)
    inspected, *more = measure_readers(parent_end, readers)
    looked_at = ask_server(parent_end)[2]
    print(f"{agents} agents at {SPEED:g} ticks/s, {browsers} clients")
    print(f"  nobody watches         {idle:6.3f} cores, the run and the laboratory's page")
    for title, cores, (pictures, all_of_it, panels, packed) in (
        ("all watch", watched, counts),
        (f"inspect {looked_at}", inspected, more),
    ):
        print(f"  {title:22} {cores:6.3f} cores")
        print(f"    pictures/s a client  {pictures:6.1f}")
        print(f"    sent a client        {all_of_it:6.2f} Mbit/s")
        print(f"      for the panels     {panels:6.3f} Mbit/s")
        print(f"      packed             {packed:6.2f} Mbit/s, of all {browsers * packed:.0f}")
    parent_end.send(None)
    server.join(10)


def measure_readers(pipe: Connection, readers: list[Reader]) -> tuple[float, ...]:
    """Cores; and of a client pictures/s, Mbit/s, and those of them for the panels."""
    before = [(reader.pictures, reader.bytes) for reader in readers]
    panels, packed = readers[0].panels, readers[0].packed
    cores = cores_used(pipe, SECONDS)
    pictures = sum(reader.pictures - was for reader, (was, _) in zip(readers, before, strict=True))
    sent = sum(reader.bytes - was for reader, (_, was) in zip(readers, before, strict=True))
    each = len(readers) * SECONDS
    unit = 8e-6 / SECONDS
    return (
        cores,
        pictures / each,
        8e-6 * sent / each,
        unit * (readers[0].panels - panels),
        unit * (readers[0].packed - packed),
    )


def cores_used(pipe: Connection, seconds: float) -> float:
    """The cores that the server takes."""
    before = ask_server(pipe)[0]
    time.sleep(seconds)
    return (ask_server(pipe)[0] - before) / seconds


def ask_server(pipe: Connection, what: str = "") -> tuple[float, int, int]:
    """Processor time of the server, s, the tick, and how many agents are looked at."""
    pipe.send(what)
    answer: tuple[float, int, int] = pipe.recv()
    return answer


# One client watches many agents.

MANY = (100_000, 1_000_000)
DRAWN = {"points", "_data", "batched_positions"}
"""What of a node changes where agents have moved."""


def serve_many(agents: int, dim: int, pipe: Connection) -> None:
    """A laboratory; answers every message with processor times, s: of all, of its run, and of what
    draws."""
    from app.viewer.lab.laboratory import Laboratory
    from app.viewer.run.run_preset import preset_spec

    pipe.send(time.monotonic())
    start = preset_spec("vem", agents=agents, dim=dim, parameters={"eta": 0.6})
    laboratory = Laboratory(start, port=0, speed=SPEED)
    pipe.send(laboratory.port)
    clock = time.pthread_getcpuclockid(laboratory.simulation.thread.ident or 0)
    drawing_clock = time.pthread_getcpuclockid(laboratory.drawing.thread.ident or 0)
    while pipe.recv():
        pipe.send(
            (time.process_time(), time.clock_gettime(clock), time.clock_gettime(drawing_clock))
        )
    laboratory.close()


class PictureReader:
    """A client that counts pictures and bytes, and notes when the second picture comes."""

    def __init__(self, port: int):
        self.pictures = self.bytes = 0
        self.moved = threading.Event()
        self.moved_at = 0.0
        self.socket = open_page(port)
        threading.Thread(target=self.read, daemon=True).start()

    def read(self) -> None:
        """Read until the server closes."""
        with suppress(ConnectionClosed):
            for data in self.socket:
                assert isinstance(data, bytes)
                self.bytes += len(data)
                self.pictures += any(  # a picture over all of the view has depths, the sky none
                    message.get("depth_data") or DRAWN.intersection(message.get("updates", ()))
                    for message in unpacked(data)[0]["messages"]
                )
                if self.pictures >= 2 and not self.moved.is_set():
                    self.moved_at = time.monotonic()
                    self.moved.set()


def watch_many(agents: int, dim: int) -> None:
    """Measure one flock, and print a line."""
    parent_end, child_end = multiprocessing.Pipe()
    server = multiprocessing.get_context("spawn").Process(
        target=serve_many, args=(agents, dim, child_end)
    )
    server.start()
    began = parent_end.recv()
    reader = PictureReader(parent_end.recv())
    reader.moved.wait()
    parent_end.send(True)
    start = parent_end.recv()[0]
    time.sleep(SETTLE)

    def look() -> tuple[float, float, float, int, int]:
        parent_end.send(True)
        return (*parent_end.recv(), reader.pictures, reader.bytes)

    before = look()
    time.sleep(SECONDS)
    cores, run, drawing, pictures, size = (
        (b - a) / SECONDS for a, b in zip(before, look(), strict=True)
    )
    print(
        f"{agents:9} {pictures:10.1f} {8e-6 * size:7.1f} {1e-3 * size / pictures:8.0f}"
        f" {cores - run:8.2f} {run:6.2f} {1e3 * drawing / pictures:8.0f}"
        f" {reader.moved_at - began:8.1f} {start:6.1f}"
    )
    parent_end.send(False)
    server.join(10)


def main_many(dim: int = 2) -> None:
    """Measure and print flocks in the plane, or in space."""
    print("   agents pictures/s  Mbit/s  kB each   server    run  drawing moves after")
    print("                                       cores  cores ms each        s  CPU s")
    for agents in MANY:
        watch_many(agents, dim)


if __name__ == "__main__":
    if sys.argv[1:2] == ["many"]:
        main_many(*(int(text) for text in sys.argv[2:3]))
    else:
        main(*(int(text) for text in sys.argv[1:3]))
