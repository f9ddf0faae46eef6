"""Flocks for tests, made with the public API."""

import numpy as np

from agents import Flock
from worlds.world import World

from . import vicsek_family as family
from .scenes import SEED
from .vicsek_family import Parameters


def build(model, where, seed=SEED, threads=1, noise="angular", activation="synchronous", **given):
    """A Flock in a Scene; `given` are the rule's parameters."""
    return Flock(
        model,
        start=where.start,
        size=where.size,
        dim=where.dim,
        world=where.edges,
        activation=activation,
        noise=noise,
        rng=seed,
        threads=threads,
        r=where.r,
        v0=where.v0,
        **given,
    )


def parameters(where, **given):
    """The oracle's parameters for a Scene."""
    return Parameters(r=where.r, v0=where.v0, **given)


def at_rest(model, position, angles, informed=(), world="open", v0=1e-9, **given):
    """A flock so slow that nothing but headings changes."""
    position = np.array(position, dtype=float)
    start = {
        "position": position,
        "heading": np.array([family.unit(a) for a in angles]),
        "informed": np.isin(np.arange(len(position)), informed),
    }
    return Flock(model, start=start, size=(10.0, 10.0), world=world, r=1.0, v0=v0, **given)


def in_open_space(model, position, velocity, **given):
    """A flock with these velocities, where nothing is in the way."""
    velocity = np.array(velocity, float)
    dim = velocity.shape[1]
    speed = np.linalg.norm(velocity, axis=1)
    heading = np.where(speed[:, None] > 0.0, velocity, np.eye(dim)[0])
    start = {"position": position, "heading": heading, "speed": speed}
    space = World("space", (9.0,) * dim, ("open",) * dim)
    return Flock(model, start=start, world=space, **given)


def velocity_of(flock):
    """Velocities (N, dim)."""
    return flock.heading * flock.speed[:, None]


def angles_of(flock):
    """Angles (list of N) of planar headings in [0, 2 pi)."""
    return [family.angle(u) for u in flock.heading]
