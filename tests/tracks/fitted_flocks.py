"""Simulated tracks whose parameters are known, and naive versions of what a fit computes."""

from __future__ import annotations

import functools
import math

import numpy as np

from agents import Flock
from app.tracks.tracks import Tracks
from worlds.world import World

TAU, SPEED = 0.1, 3.0
"""Time of a tick and speed of Couzin's zones by default."""
MOST_TURN = math.radians(40.0) * TAU
"""How far one turns in a tick."""


def tracks_of(place, step=1.0, name="run", unit="m", period=(), heading=None):
    """Tracks of places (T, N, dim), a frame every `step` s."""
    frames, individuals = place.shape[:2]
    return Tracks(
        position=place,
        frame=np.arange(frames),
        time=step * np.arange(frames),
        ids=tuple(map(str, range(individuals))),
        unit=unit,
        name=name,
        period=period,
        heading=heading,
    )


@functools.cache
def mill_places(seed=3, frames=240, agents=60, **parameters):
    """Places (T, N, 2) of Couzin's zones once they have settled: by default a mill, (3, 10)."""
    world = World(size=(12.0, 12.0), edges=("open",))
    flock = Flock("couzin", agents=agents, world=world, rng=seed, **parameters)
    flock.run(1500)
    return np.concatenate([flock.position[None], flock.trace(frames - 1)])


def mill(noise=0.0, seed=3, frames=240, noise_seed=5, **parameters):
    """The same as tracks, with noise of places as a share of the way of a tick."""
    place = mill_places(seed, frames, **parameters)
    rng = np.random.default_rng(noise_seed)
    return tracks_of(place + noise * SPEED * TAU * rng.normal(size=place.shape), TAU, "mill")


@functools.cache
def vicsek_run(model="vem", r=1.0, eta=1.0, frames=302, agents=200, side=7.0, seed=1, v0=0.1):
    """Places and headings (T, N, 2) of the Vicsek family, settled."""
    flock = Flock(model, agents=agents, world="wrap", size=side, rng=seed, r=r, eta=eta, v0=v0)
    flock.run(100)
    place = np.empty((frames, agents, 2))
    heading = np.empty_like(place)
    for k in range(frames):
        place[k], heading[k] = flock.position, flock.heading
        flock.advance(1)
    return place, heading


def vicsek_tracks(model="vem", with_headings=False, side=7.0, **parameters):
    """The same as tracks; headings are those of the flock, or left to the steps."""
    place, heading = vicsek_run(model, side=side, **parameters)
    return tracks_of(
        place, 1.0, model, period=(side, side), heading=heading if with_headings else None
    )


# Naive versions, agent by agent.


def capped_square(predicted, following, most=0.5):
    """min(angle, most)^2 of two vectors, the angle by arctangent."""
    cross = np.linalg.norm(np.cross(np.append(predicted, 0.0)[:3], np.append(following, 0.0)[:3]))
    return min(math.atan2(cross, float(np.dot(predicted, following))), most) ** 2


def apart(place, i, j, period):
    """From i to j by the shortest way."""
    way = place[j] - place[i]
    return np.array([
        d - side * round(d / side) if side else d for d, side in zip(way, period, strict=True)
    ])  # fmt: skip


def vem_headings(place, heading, r, period):
    """The mean heading of all within r, itself among them."""
    predicted = []
    for i in range(len(place)):
        near = [
            heading[j] for j in range(len(place)) if np.linalg.norm(apart(place, i, j, period)) <= r
        ]
        mean = np.sum(near, axis=0)
        predicted.append(mean / np.linalg.norm(mean))
    return np.array(predicted)


def couzin_headings(place, heading, dr_o, dr_a, r_r=1.0, alpha=270.0, most=MOST_TURN):
    """Couzin et al. 2002, (1) to (3), without error, and the turn of a tick in the plane."""
    predicted = []
    for i in range(len(place)):
        away, along, towards, near = np.zeros(2), np.zeros(2), np.zeros(2), 0
        for j in range(len(place)):
            way = place[j] - place[i]
            distance = np.linalg.norm(way)
            if i == j:
                continue
            direction = way / distance
            sees = np.dot(direction, heading[i]) >= math.cos(math.radians(alpha / 2))
            if distance < r_r:
                away -= direction
                near += 1
            elif distance < r_r + dr_o and sees:
                along += heading[j]
            elif distance < r_r + dr_o + dr_a and sees:
                towards += direction
        want = away if near else along + towards
        if np.linalg.norm(want) < 1e-12:
            want = heading[i]
        now = math.atan2(heading[i][1], heading[i][0])
        turn = math.remainder(math.atan2(want[1], want[0]) - now, 2.0 * math.pi)
        turn = min(max(turn, -most), most)
        predicted.append([math.cos(now + turn), math.sin(now + turn)])
    return np.array(predicted)
