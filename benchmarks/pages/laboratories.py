"""What many laboratories cost in one process.

    python benchmarks/pages/laboratories.py [laboratories] [agents] [ticks/s] [dimension] [alone]

Each has a flock of its own, and what a class allows; all it wants, if `alone`. Prints what it takes
to start one, to keep one that nobody looks at, and to show one: clients in a process of their own
read every frame (programs, not browsers). What they read is also deflated as a websocket does, with
and without what went before.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import sys
import time
import zlib
from multiprocessing.connection import Connection
from pathlib import Path
from statistics import median

import msgspec
import viser
from stream import CAMERA
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed

SETTLE, SECONDS = 4.0, 8.0
"""Time before something is measured, and for which it is, s."""
KEPT = 100
"""Pictures of one laboratory that are deflated."""


def serve(count: int, agents: int, speed: float, dim: int, alone: bool, pipe: Connection) -> None:
    """Some laboratories; first sends for each what its start took, then answers messages with how
    they stand: processor time so far, s; ticks of all; memory in use, MB."""
    from app.viewer.lab.laboratory import Laboratory
    from app.viewer.run.allowance import Allowance
    from app.viewer.run.run_preset import preset_spec

    allowance = None if alone else Allowance()
    laboratories = []
    for _ in range(count):
        began, worked = time.perf_counter(), time.process_time()
        spec = preset_spec("hwvem", agents=agents, dim=dim, parameters={"eta": 0.3})
        laboratory = Laboratory(spec, port=0, speed=speed, allowance=allowance)
        laboratory.simulation.ready.wait()
        laboratories.append(laboratory)
        took = time.perf_counter() - began, time.process_time() - worked
        pipe.send((laboratory.port, *took, memory()))
    while pipe.recv():
        ticks = sum(
            laboratory.simulation.run.flock.tick
            for laboratory in laboratories
            if laboratory.simulation.run
        )
        pipe.send((time.process_time(), ticks, memory()))
    for laboratory in laboratories:
        laboratory.close()


def memory() -> float:
    """What this process has in memory, MB."""
    return 4.096e-3 * int(Path("/proc/self/statm").read_text().split()[1])


def look(ports: list[int], agents: int, pipe: Connection) -> None:
    """Looks at every laboratory; answers messages with pictures and bytes read so far by each.

    At last sends pictures of the first.
    """
    asyncio.run(look_on(ports, agents, pipe))


async def look_on(ports: list[int], agents: int, pipe: Connection) -> None:
    """The loop of `look`."""
    counted = [[0, 0] for _ in ports]
    packets: list[bytes] = []
    readers = [
        asyncio.create_task(read(port, 12 * agents, server_port, packets if k == 0 else None))
        for k, (port, server_port) in enumerate(zip(ports, counted, strict=True))
    ]
    while await asyncio.to_thread(pipe.recv):
        pipe.send([tuple(count) for count in counted])
    pipe.send(packets[-KEPT:])
    for reader in readers:
        reader.cancel()


async def read(port: int, least: int, counted: list[int], packets: list[bytes] | None) -> None:
    """Read what one laboratory sends; what is longer than `least` bytes holds a picture."""
    protocol = viser.__version__
    async with connect(
        f"ws://127.0.0.1:{port}",
        subprotocols=[f"viser-v{protocol}"],  # type: ignore[list-item]
        max_size=None,
        compression=None,
    ) as line:
        await line.send(msgspec.msgpack.encode(CAMERA))
        try:
            async for message in line:
                counted[0] += len(message) > least
                counted[1] += len(message)
                if packets is not None and len(message) > least:
                    packets.append(bytes(message))  # type: ignore[arg-type]
        except ConnectionClosed:
            pass


def deflated_size(pictures: list[bytes], takeover: bool) -> float:
    """Bytes of a picture after permessage-deflate at level 1, on the average."""
    if not pictures:
        return 0.0
    total, packer = 0, zlib.compressobj(1, zlib.DEFLATED, -15)
    for picture in pictures:
        if not takeover:
            packer = zlib.compressobj(1, zlib.DEFLATED, -15)
        total += len(packer.compress(picture) + packer.flush(zlib.Z_SYNC_FLUSH)) - 4
    return total / len(pictures)


def main(
    count: int = 20, agents: int = 300, speed: float = 15.0, dim: int = 2, alone: bool = False
) -> None:
    """Measure and print."""
    context = multiprocessing.get_context("spawn")
    parent_end, child_end = context.Pipe()
    server = context.Process(target=serve, args=(count, agents, speed, dim, alone, child_end))
    server.start()
    started = [parent_end.recv() for _ in range(count)]
    ports, wall, work, size = zip(*started, strict=True)
    print(
        f"{count} laboratories of {agents} agents, {dim}-D, {speed:g} ticks/s wanted, "
        f"{'alone' if alone else 'as in a class'}"
    )
    print(f"  the first, s           {wall[0]:8.2f}  {work[0]:.2f} of processor time")
    if count > 1:
        print(f"  each other, s          {median(wall[1:]):8.3f}  {median(work[1:]):.3f}, median")
        print(f"  all others, s          {sum(wall[1:]):8.2f}")
    time.sleep(SETTLE)
    worked, ticks, _ = measure_all(parent_end)
    print(f"  nobody looks: cores    {worked / count:8.4f}  each; {ticks / count:.1f} ticks/s")
    eyes, far = context.Pipe()
    looker = context.Process(target=look, args=(list(ports), agents, far))
    looker.start()
    time.sleep(2.0 * SETTLE)
    before = ask_server(eyes)
    worked, ticks, last = measure_all(parent_end)
    after = ask_server(eyes)
    pictures = [b[0] - a[0] for a, b in zip(before, after, strict=True)]
    sent = sum(b[1] - a[1] for a, b in zip(before, after, strict=True))
    rates = sorted(picture / SECONDS for picture in pictures)
    print(f"  one looks at each: cores {worked:6.2f}  all; {ticks / count:.1f} ticks/s each")
    print(f"    pictures/s each      {median(rates):8.1f}  worst {rates[0]:.1f}")
    print(f"    a picture, ms        {1e3 * worked * SECONDS / max(sum(pictures), 1):8.2f}")
    print(f"    sent, Mbit/s         {8e-6 * sent / SECONDS:8.1f}")
    eyes.send(False)
    received = eyes.recv()
    raw = sum(map(len, received)) / max(len(received), 1)
    sizes = [
        size / agents
        for size in (raw, deflated_size(received, False), deflated_size(received, True))
    ]
    print("    bytes of an agent    {:8.1f}  deflated {:.1f}, with takeover {:.1f}".format(*sizes))
    print(f"  memory, MB             {last:8.0f}  {(last - size[0]) / max(count - 1, 1):.1f} each")
    parent_end.send(False)
    looker.join(10)
    server.join(10)


def measure_all(pipe: Connection) -> tuple[float, float, float]:
    """Cores that work for the laboratories, ticks/s of all, and memory, MB."""
    first, began = ask_server(pipe), time.perf_counter()
    time.sleep(SECONDS)
    last, took = ask_server(pipe), time.perf_counter() - began
    return (last[0] - first[0]) / took, (last[1] - first[1]) / took, last[2]


def ask_server(pipe: Connection):  # type: ignore[no-untyped-def]
    """What is answered."""
    pipe.send(True)
    return pipe.recv()


if __name__ == "__main__":
    given = sys.argv[1:]
    counts = [int(text) for text in given[:2]]
    speed = [float(text) for text in given[2:3]]
    dim = [int(text) for text in given[3:4]]
    main(*counts, *speed, *dim, alone="alone" in given)
