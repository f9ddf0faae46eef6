"""What it costs to play a recording, and to keep the last minutes of a run: `python
benchmarks/pages/replay.py [agents] [pictures/s]`.

A recording of so many agents is played by the laboratory, in this process, with a client that reads
every picture as fast as it can (a program, not a browser). Then random ticks are sought, and at
last live runs go as fast as they can, in turn with and without what is kept to look back.
"""

from __future__ import annotations

import math
import statistics
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from agents.flock import Flock
from agents.recordings.recorder import Recorder
from app.viewer.lab.laboratory import Laboratory
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from app.viewer.run.stored_flock import StoredFlock, read_stored
from benchmarks.pages.stream import Reader

TICKS = 600
SECONDS = 8.0
SEEKS = 100
LIVE = (("hwvem", 1_000), ("vem", 10_000))
TURNS, TURN = 4, 2.0
"""How often each live run has its turn with and without, and for how long, s."""


def main(agents: int = 500, speed: float = 30.0) -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "flight.parquet"
        flock = Flock("hwvem", agents=agents, rng=1, eta=0.3)
        with Recorder(path, flock) as recorder:
            for _ in range(TICKS):
                recorder.write()
                flock.run(1)
        began = time.perf_counter()
        opened = read_stored(path.name, path=path)
        print(f"{agents} agents, {TICKS} ticks, {path.stat().st_size / 1e6:.1f} MB")
        print(f"  opened in, s       {time.perf_counter() - began:8.2f}")
        play(opened, agents, speed)
    for model, count in LIVE:
        measure_recording(model, count)


def play(opened: StoredFlock, agents: int, speed: float) -> None:
    """Play it with a client, then seek in it."""
    laboratory = Laboratory(opened=opened, port=0, speed=speed)
    reader = Reader(laboratory.port, agents)
    time.sleep(3.0)
    laboratory.simulation.time_line.seek(0).result()
    frames, worked = reader.frames, time.process_time()
    time.sleep(SECONDS)
    print(f"  pictures/s         {(reader.frames - frames) / SECONDS:8.1f}  of {speed:g} recorded")
    print(f"  cores              {(time.process_time() - worked) / SECONDS:8.2f}")
    laboratory.simulation.pause().result()
    times = []
    for tick in np.random.default_rng(1).integers(0, TICKS, SEEKS).tolist():
        began = time.perf_counter()
        laboratory.simulation.time_line.seek(tick).result()
        while laboratory.simulation.frame.tick != tick:  # type: ignore[union-attr]
            time.sleep(0.0005)
        times.append(1e3 * (time.perf_counter() - began))
    print(f"  to any tick, ms    {statistics.median(times):8.1f}  at most {max(times):.1f}")
    laboratory.close()


def measure_recording(model: str, agents: int) -> None:
    """A live run at full speed, with and without what is kept of it."""
    simulation = Simulation(preset_spec(model, agents=agents), speed=math.inf)
    simulation.ready.wait()
    line, rates = simulation.time_line, {True: [], False: []}  # type: ignore[var-annotated]
    note = line.note
    clock = time.pthread_getcpuclockid(simulation.thread.ident or 0)
    for turn in range(2 * TURNS):
        keeps = turn % 2 == 0
        line.note = note if keeps else lambda _: None  # type: ignore[method-assign]
        time.sleep(0.2)
        began, done = time.clock_gettime(clock), simulation.pace.done
        time.sleep(TURN)
        rates[keeps].append((simulation.pace.done - done) / (time.clock_gettime(clock) - began))
    simulation.pause().result()
    history = line.history
    began = time.perf_counter()
    line.checkpoint(simulation.require_run())
    copied = 1e6 * (time.perf_counter() - began)
    simulation.close()
    with_it, without = (statistics.median(rates[keeps]) for keeps in (True, False))
    print(f"{model}, {agents} agents at full speed")
    print(f"  ticks/s of CPU     {with_it:8.1f}  and {without:.1f} when nothing is kept")
    print(f"  one moment, us     {copied:8.0f}")
    print(f"  kept               {len(history.moments):8d}  of {history.size / 1e6:.1f} MB")


if __name__ == "__main__":
    main(*(kind(text) for kind, text in zip((int, float), sys.argv[1:], strict=False)))
