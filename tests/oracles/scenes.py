"""Random flocks for tests: few or many agents, crowded or cut off, boxes small and large."""

import math
from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st

from .topology import EDGES, distances

ARRANGEMENTS = ("uniform", "clusters", "one spot", "two spots", "border", "far apart")
BOXES = (0.4, 0.9, 1.3, 1.99, 2.0, 2.6, 3.0, 3.7, 5.5, 12.0)  # in units of r; radius over half the
# box, cells narrower than r, one, two and three cells across, many

SEED = 3  # of every flock that is followed


@dataclass(frozen=True)
class Scene:
    """A start (positions and headings (N, dim), information agents (N,)) in a box (dim,)."""

    position: np.ndarray
    heading: np.ndarray
    informed: np.ndarray
    size: tuple
    edges: str
    r: float
    v0: float

    @property
    def start(self):
        """What `Flock(start=...)` takes."""
        return {"position": self.position, "heading": self.heading, "informed": self.informed}

    @property
    def dim(self):
        return self.position.shape[1]


def unit_vectors(rng, n, dim):
    """n directions uniform on the circle or the sphere, (n, dim)."""
    u = rng.normal(size=(n, dim))
    return u / np.linalg.norm(u, axis=1, keepdims=True)


def places(rng, arrangement, n, size, r, edges):
    """Positions (n, dim) of one of the ARRANGEMENTS."""
    dim = len(size)
    if arrangement == "uniform":
        x = rng.uniform(0, 1, (n, dim)) * size
    elif arrangement == "clusters":
        centre = rng.uniform(0, 1, (3, dim)) * size
        x = centre[rng.integers(0, 3, n)] + rng.normal(size=(n, dim)) * 0.3 * r
    elif arrangement == "one spot":
        x = np.tile(rng.uniform(0, 1, dim) * size, (n, 1))
    elif arrangement == "two spots":
        spot = rng.uniform(0, 1, dim) * size
        x = spot + np.outer(rng.integers(0, 2, n), 0.6 * r * unit_vectors(rng, 1, dim)[0])
    elif arrangement == "border":
        x = rng.normal(size=(n, dim)) * 0.4 * r
    else:  # so far apart that hardly anybody has a neighbour: the plane, or its wrapped image
        x = rng.normal(size=(n, dim)) * 30 * r
    if edges != "open":
        x = np.mod(x, size)
        x[x >= size] = 0.0
    return x


def scene(rng, n, dim, edges, arrangement="uniform", box=3.7, informed=1, r=1.0, v0=0.11):
    """One Scene; `box` and `v0` in units of r, `informed` the number of information agents."""
    size = box * r * np.array([1.0, 1.17, 0.83][:dim])
    mask = np.zeros(n, bool)
    mask[rng.permutation(n)[:informed]] = True
    return Scene(
        position=places(rng, arrangement, n, size, r, edges),
        heading=unit_vectors(rng, n, dim),
        informed=mask,
        size=tuple(float(s) for s in size),
        edges=edges,
        r=r,
        v0=v0 * r,
    )


@st.composite
def scenes(draw, dims=(2, 3), edges=EDGES, most=60):
    """Scenes of 1 to `most` agents. Numbers come from a drawn seed, shapes from hypothesis."""
    n = draw(st.one_of(st.integers(1, 6), st.integers(1, most)))
    return scene(
        np.random.default_rng(draw(st.integers(0, 2**32 - 1))),
        n,
        draw(st.sampled_from(dims)),
        draw(st.sampled_from(edges)),
        draw(st.sampled_from(ARRANGEMENTS)),
        draw(st.sampled_from(BOXES)),
        draw(st.integers(0, min(n, 3))),
        draw(st.sampled_from((0.25, 1.0, 1.4))),
        draw(st.sampled_from((0.03, 0.11, 0.37, 0.7))),
    )


def contacts_are_clear(position, r, size, edges, margin=1e-9):
    """No pair is within `margin` of the radius, or of one spot without being on it."""
    distance = distances(position, size, edges)
    on_the_edge = np.abs(distance - r) < margin
    nearly_one = (distance > 0) & (distance < margin)
    return not (on_the_edge | nearly_one).any()


def apart(a, b, size=None):
    """Largest distance between rows of a and b (N, dim); across the border if `size` is given."""
    offset = np.asarray(a) - np.asarray(b)
    if size is not None:
        offset = offset - size * np.round(offset / size)
    return float(np.sqrt((offset**2).sum(axis=1)).max()) if len(offset) else math.inf
