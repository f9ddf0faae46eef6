"""How many pictures a second there are while somebody drags the time line of tracks.

    uv run python benchmarks/pages/scrub.py [--individuals 500] [--frames 3000] [--browser]

Tracks of individuals in two mills, of whom a fifth is not seen at any time. Measured are: making
them ready for play; the simulation's own thread from a place on the time line to a frame of it,
with what is measured of it; the drawing of that frame into the scene; and, with --browser, how many
different frames are drawn in a second for a Chromium that looks on, while the line is moved 60
times a second.
"""

from __future__ import annotations

import argparse
import math
import statistics
import sys
import time
from pathlib import Path

import numpy as np
import viser

sys.path.insert(0, str(Path(__file__).parents[2]))

from app.tracks.playing.played_tracks import PlayedTracks
from app.tracks.tracks import Tracks
from app.viewer.lab.laboratory import Laboratory
from app.viewer.run.simulation import Simulation
from app.viewer.run.stored_tracks import StoredTracks
from app.viewer.scene.scene import Scene
from app.viewer.scene.shown.drawing_style import DrawingStyle

RATE = 25.0
LOST = 0.2
MOVES = 200
SECONDS = 10.0


def mills(individuals: int, frames: int) -> Tracks:
    """Individuals that go round two centres, with gaps."""
    rng = np.random.default_rng(1)
    radius, phase = rng.uniform(4.0, 12.0, individuals), rng.uniform(0.0, 2 * np.pi, individuals)
    time_of = np.arange(frames) / RATE
    angle = phase + 4.0 * time_of[:, None] / radius
    place = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    place[:, individuals // 2 :, 0] += 30.0
    begins = rng.integers(0, frames, (individuals, max(1, int(frames * LOST / 50))))
    for row, gaps in enumerate(begins):
        for begin in gaps:
            place[begin : begin + 50, row] = np.nan
    ids = tuple(map(str, range(individuals)))
    return Tracks(place, np.arange(frames), time_of, ids, "m", name="mills.csv")


def print_times(title: str, times: list[float]) -> None:
    """Median, worst, and how many of the median there are in a second."""
    median = statistics.median(times)
    print(f"{title:34}{1e3 * median:10.1f} ms{1e3 * max(times):10.1f} ms{1.0 / median:10.0f} /s")


def wait_for(simulation: Simulation, tick: int) -> None:
    """Wait until a frame of a tick is there."""
    while simulation.frame is None or simulation.frame.tick != tick:
        simulation.news.wait(0.1)
        simulation.news.clear()


def measure_threads(stored: StoredTracks) -> None:
    """Print what the simulation's thread and the drawing take."""
    simulation = Simulation(stored.spec, None, 30.0, running=False, stored=stored)
    simulation.ready.wait(60)
    ticks = np.random.default_rng(2).integers(1, len(stored.recording.ticks), MOVES).tolist()
    took, apart = [], simulation.keeping.frame_interval
    for tick in ticks:
        time.sleep(apart)
        began = time.perf_counter()
        simulation.time_line.seek(tick)
        wait_for(simulation, tick)
        took.append(time.perf_counter() - began)
    print_times("from the time line to a frame", took)
    server = viser.ViserServer(port=0, verbose=False)
    scene, look, drawn = Scene(server), DrawingStyle(), []
    for tick in ticks[:50]:
        simulation.time_line.seek(tick)
        wait_for(simulation, tick)
        began = time.perf_counter()
        scene.show(simulation.frame, look)  # type: ignore[arg-type]
        drawn.append(time.perf_counter() - began)
    print_times("drawn into the scene", drawn[1:])
    server.stop()
    simulation.close()


def measure_page(stored: StoredTracks) -> None:
    """Print how many frames are drawn for a browser while the line is moved."""
    from playwright.sync_api import sync_playwright

    from tests.browser.conftest import ARGUMENTS, CHROMIUM

    laboratory = Laboratory(port=0, opened=stored, running=False)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        page = browser.new_page(viewport={"width": 1000, "height": 640})
        page.goto(laboratory.address)
        page.wait_for_selector("canvas")
        while laboratory.drawing.drawn is None:
            time.sleep(0.1)
        time.sleep(3.0)
        shown: set[int] = set()
        begin, last = time.perf_counter(), len(stored.recording.ticks) - 1
        while (now := time.perf_counter() - begin) < SECONDS:
            share = 0.5 - 0.5 * math.cos(2.0 * math.pi * now / SECONDS)
            laboratory.simulation.time_line.seek(int(share * last))
            drawn = laboratory.drawing.drawn
            if drawn is not None:
                shown.add(id(drawn[0]))
                keep.append(drawn[0])
            time.sleep(1.0 / 60.0)
        print(f"{'drawn while the line is moved':34}{'':23}{len(shown) / SECONDS:13.0f} /s")
        browser.close()
    laboratory.close()


keep: list[object] = []
"""Frames that were drawn: of what is forgotten another may have the address."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--individuals", type=int, default=500)
    parser.add_argument("--frames", type=int, default=3000)
    parser.add_argument("--browser", action="store_true")
    asked = parser.parse_args()
    tracks = mills(asked.individuals, asked.frames)
    began = time.perf_counter()
    stored = StoredTracks(PlayedTracks(tracks))
    print(f"{asked.individuals} individuals, {asked.frames} frames, "
          f"{100 * (1 - tracks.seen.mean()):.0f} % not seen")  # fmt: skip
    print(f"{'made ready for play':34}{time.perf_counter() - began:10.2f} s")
    print(f"{'':34}{'median':>13}{'worst':>13}")
    measure_threads(stored)
    if asked.browser:
        measure_page(stored)


if __name__ == "__main__":
    main()
