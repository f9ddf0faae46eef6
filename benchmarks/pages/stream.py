"""What streaming a flock costs: `python benchmarks/pages/stream.py [agents] [browsers] [ticks/s]`.

Runs the laboratory in a process of its own, with clients that read every frame as fast as they can
(programs, not browsers, so that their drawing does not count). Prints the frames that arrive and
the processor time that the server takes, beside and in the simulation's thread, and its memory.
"""

from __future__ import annotations

import multiprocessing
import resource
import sys
import threading
import time
from multiprocessing.connection import Connection

import msgspec
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

SECONDS = 8.0
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [0.0, 0.0, 40.0],
    "fov": 0.3,
    "near": 0.1,
    "far": 100.0,
    "image_height": 900,
    "image_width": 800,
    "look_at": [0.0, 0.0, 0.0],
    "up_direction": [0.0, 0.0, 1.0],
}


def serve(agents: int, speed: float, pipe: Connection) -> None:
    """The laboratory; answers every message of the pipe with how it stands.

    Processor times so far, s; the tick; the most memory so far, MB.
    """
    from app.viewer.lab.laboratory import Laboratory
    from app.viewer.run.run_preset import preset_spec

    start = preset_spec("hwvem", agents=agents, parameters={"eta": 0.3})
    laboratory = Laboratory(start, port=0, speed=speed)
    laboratory.simulation.ready.wait()
    clock = time.pthread_getcpuclockid(laboratory.simulation.thread.ident or 0)
    pipe.send(laboratory.server.get_port())
    while pipe.recv():
        pipe.send(
            (
                time.process_time(),
                time.clock_gettime(clock),
                laboratory.simulation.frame.tick,
                1.024e-3 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
            )
        )
    laboratory.close()


def open_page(port: int) -> ClientConnection:
    """The connection of a page, introduced as viser's own page does."""
    socket = connect(
        f"ws://localhost:{port}",
        subprotocols=[f"viser-v{viser.__version__}"],  # type: ignore[list-item]
        max_size=None,
    )
    socket.send(msgspec.msgpack.encode(CAMERA))
    return socket


class Reader:
    """A client that counts what it gets."""

    def __init__(self, port: int, agents: int):
        self.frame_bytes = 12 * agents
        self.frames = self.bytes = 0
        self.socket = open_page(port)
        threading.Thread(target=self.read, daemon=True).start()

    def read(self) -> None:
        """Read until the server closes."""
        try:
            for message in self.socket:
                self.bytes += len(message)
                self.frames += len(message) > self.frame_bytes
        except ConnectionClosed:
            pass


def main(agents: int = 5000, browsers: int = 1, speed: float = 30.0) -> None:
    """Measure and print."""
    parent_end, child_end = multiprocessing.Pipe()
    server = multiprocessing.get_context("spawn").Process(
        target=serve, args=(agents, speed, child_end)
    )
    server.start()
    readers = [Reader(parent_end.recv(), agents)]
    port = readers[0].socket.remote_address[1]
    readers += [Reader(port, agents) for _ in range(browsers - 1)]
    time.sleep(3.0)
    first = ask_server(parent_end)
    counted = [(reader.frames, reader.bytes) for reader in readers]
    time.sleep(SECONDS)
    last = ask_server(parent_end)
    frames = [reader.frames - before for reader, (before, _) in zip(readers, counted, strict=True)]
    sent = sum(reader.bytes - before for reader, (_, before) in zip(readers, counted, strict=True))
    total, simulation, ticks, _ = (b - a for a, b in zip(first, last, strict=True))
    print(f"{agents} agents, {browsers} clients, {speed:g} ticks/s wanted")
    print(f"  ticks/s            {ticks / SECONDS:8.1f}")
    print(f"  frames/s a client  {sum(frames) / len(frames) / SECONDS:8.1f}")
    print(f"  sent, Mbit/s       {8e-6 * sent / SECONDS:8.1f}")
    print(f"  server, cores      {(total - simulation) / SECONDS:8.2f}  beside the simulation")
    print(f"  simulation, cores  {simulation / SECONDS:8.2f}")
    print(f"  memory, MB         {last[3]:8.0f}")
    parent_end.send(False)
    server.join(10)


def ask_server(pipe: Connection) -> tuple[float, float, float, float]:
    """Processor time of the server, of its simulation (s), ticks run, and memory (MB)."""
    pipe.send(True)
    answer: tuple[float, float, float, float] = pipe.recv()
    return answer


if __name__ == "__main__":
    given = sys.argv[1:]
    main(*(int(text) for text in given[:2]), *(float(text) for text in given[2:3]))
