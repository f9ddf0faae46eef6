"""How long tracks take: velocities, order, leadership, maps, a fit, and all that is measured.

    uv run python benchmarks/tracks.py

Individuals that wander in a box, with 2 % of gaps, at 25 frames a second; what is compiled is
compiled before. Each figure is the shortest of several.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from app.tracks.fit.frame_sample import FrameSample
from app.tracks.fit.one_step import OneStepPredictor
from app.tracks.fit.tick_scale import ScaledModel
from app.tracks.measures.measure_catalogue import track_measures
from app.tracks.measures.track_measure import MeasureInput, MeasureOptions
from app.tracks.motion import smoothed_motion
from app.tracks.tracks import Tracks
from worlds.world import World

ROUNDS = 3
FPS = 25.0


class TimedCase(NamedTuple):
    """Something that is timed."""

    name: str
    wanted: float
    """Seconds that it may take."""
    run: Callable[[], object]


def wanderers(individuals: int, frames: int, seed: int = 1) -> Tracks:
    """Individuals that turn at random, and all follow the first, some later than others."""
    rng = np.random.default_rng(seed)
    late = rng.integers(0, 40, individuals)
    shared = rng.normal(0.0, 0.1, frames + 40).cumsum()
    angle = np.stack([shared[40 - k :][:frames] for k in late], axis=1)
    angle += rng.normal(0.0, 0.1, angle.shape)
    step = 0.04 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    position = (rng.uniform(0.0, 20.0, (individuals, 2)) + np.cumsum(step, axis=0)) % 20.0
    position[rng.random((frames, individuals)) < 0.02] = np.nan
    frame = np.arange(frames)
    ids = tuple(map(str, range(individuals)))
    return Tracks(position, frame, frame / FPS, ids, "m", period=(20.0, 20.0))


def measured(tracks: Tracks, name: str) -> Callable[[], object]:
    """Measure one thing of tracks, of which the motion is at hand."""
    given = MeasureInput(tracks, smoothed_motion(tracks, 0.2), MeasureOptions(longest_delay=2.0))
    _ = given.spacing, given.motion.heading, given.motion.turn
    return lambda: track_measures()[name].compute(given, lambda _: None)


def cases() -> list[TimedCase]:
    """What is timed; the times are those that the work was given."""
    hundred, two_hundred = wanderers(100, 3000), wanderers(200, 3000)

    def velocity_and_order() -> None:
        given = MeasureInput(hundred, smoothed_motion(hundred, 0.2))
        track_measures()["polarisation"].compute(given, lambda _: None)

    wanted = {"leadership": 2.0, "neighbour-map": 5.0, "turning-map": 5.0}
    rest = [name for name in track_measures() if name not in wanted and not needs_room(name)]
    return [
        TimedCase("velocity and order, 100 x 3000", 0.1, velocity_and_order),
        TimedCase("leadership +-2 s, 100 x 3000", 2.0, measured(hundred, "leadership")),
        TimedCase("neighbour map, 200 x 3000", 5.0, measured(two_hundred, "neighbour-map")),
        TimedCase("turning map, 200 x 3000", 5.0, measured(two_hundred, "turning-map")),
        TimedCase("a fit's evaluation, couzin, 60 x 30", 0.05, fit_evaluation()),
        *(TimedCase(f"{name}, 100 x 3000", np.inf, measured(hundred, name)) for name in rest),
    ]


def fit_evaluation() -> Callable[[], object]:
    """The costs of 30 frames of 60 individuals, with parameters that are new each time."""
    frames, individuals = 30, 60
    rng = np.random.default_rng(1)
    angle = rng.uniform(0.0, 2.0 * np.pi, (2, frames, individuals))
    heading, following = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    place = rng.uniform(0.0, 12.0, (frames, individuals, 2))
    speed = np.ones((frames, individuals))
    sample = FrameSample(place, heading, speed, following, np.arange(frames))
    world = World(size=(12.0, 12.0), edges=("open",))
    predictor = OneStepPredictor(ScaledModel("couzin", {}, ()), world)
    radii = itertools.cycle(np.linspace(1.0, 8.0, 29))
    return lambda: predictor.costs(sample, {"dr_o": float(next(radii))})


def needs_room(name: str) -> bool:
    """Whether a measure is of people in a room."""
    return track_measures()[name].source == "PedPy"


def shortest(run: Callable[[], object]) -> float:
    """The shortest of several times, s, once what is compiled is there."""
    run()
    times = []
    for _ in range(ROUNDS):
        started = time.perf_counter()
        run()
        times.append(time.perf_counter() - started)
    return min(times)


def main() -> None:
    """Print a row for each case."""
    print(f"{'':40}{'s':>8}{'wanted':>9}")
    for case in cases():
        wanted = f"< {case.wanted:g}" if case.wanted < np.inf else ""
        print(f"{case.name:40}{shortest(case.run):>8.3f}{wanted:>9}", flush=True)


if __name__ == "__main__":
    main()
