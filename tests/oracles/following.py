"""Follow a flock tick by tick, comparing each tick with one oracle step from where it was."""

import math
from dataclasses import dataclass

import numpy as np
from hypothesis import assume, currently_in_test_context

from . import noise as hashing
from . import vicsek_family as family
from .scenes import SEED, apart, contacts_are_clear
from .topology import contact, layers

CLOSE = 1e-9


def state_of(flock, model):
    """The oracle's view of a flock: copies of its arrays."""
    n = len(flock.position)
    layer = np.full(n, n + 1)
    if model == "hwvem":
        signal = flock.signal("layer")
        assert signal.dtype == np.float64
        layer = signal.astype(int)
        assert (layer == signal).all()
    return family.State(
        flock.position.copy(), flock.heading.copy(), layer, flock.informed.astype(bool).copy()
    )


def noise_of(flock, kind, eta, seed=SEED):
    """The noise of the flock's next tick, as keyword arguments of the oracle's step."""
    if eta == 0 and kind == "angular":
        return {}
    if kind == "angular":
        return {"turn": hashing.turns(seed, flock.tick, flock.ids, eta)}
    return {"xi": hashing.directions(seed, flock.tick, flock.ids)}


@dataclass(frozen=True)
class Clear:
    """Agents whose decision does not hang on the last bits of a number, (N,) bool."""

    rows: np.ndarray

    @classmethod
    def of(cls, model, state, p, size, edges, xi=None):
        """IVEM compares raw angles: ties and angles at 0 are unclear unless equal to the bit."""
        touch = contact(state.position, p.r, size, edges)
        instant = family.searches(model, p)
        layer = layers(touch, state.informed) if instant else state.layer
        clear = [
            cls.is_clear(model, i, state, layer, touch, p, xi) for i in range(len(state.informed))
        ]
        return cls(np.array(clear) | state.informed)

    @staticmethod
    def is_clear(model, i, state, layer, touch, p, xi):
        wish = family.wish(model, i, state, layer, touch, p)
        if xi is not None:
            wish = wish + p.eta * xi[i]
        if math.hypot(*wish) < 1e-6:
            return False
        if not model.startswith("ivem"):
            return True
        if model == "ivem-a" and (touch[i] & state.informed).any():
            return True
        seen = np.flatnonzero(touch[i])
        theta = np.array([family.angle(u) for u in state.heading])
        near_zero = np.minimum(theta, math.tau - theta)[[*seen, i]] < CLOSE
        tie = [
            abs(theta[i] - theta[j]) < CLOSE and (state.heading[i] != state.heading[j]).any()
            for j in seen
        ]
        return not (near_zero.any() or any(tie))


def compare(model, flock, expected, rows, size, edges):
    """The flock's heading, position and layer are the oracle's, for the rows that are clear."""
    assert apart(flock.heading[rows], expected.heading[rows]) < CLOSE or not rows.any()
    box = np.asarray(size) if edges != "open" else None
    assert apart(flock.position[rows], expected.position[rows], box) < CLOSE or not rows.any()
    if model == "hwvem":
        assert flock.signal("layer").tolist() == expected.layer.tolist()


def demand_clear_contacts(position, p, scene):
    """Let hypothesis look for another example if a contact hangs on the last bits."""
    clear = contacts_are_clear(position, p.r, scene.size, scene.edges)
    if currently_in_test_context():
        assume(clear)
    else:
        assert clear, "this scene has a pair at just r: choose another seed"


def follow(flock, model, scene, p, ticks, noise="angular"):
    """Compare `ticks` synchronous ticks; gives the share of agents that could be compared."""
    clear_rows = []
    for _ in range(ticks):
        before = state_of(flock, model)
        demand_clear_contacts(before.position, p, scene)
        told = noise_of(flock, noise, p.eta)
        expected = family.step(model, before, p, scene.size, scene.edges, **told)
        rows = Clear.of(model, before, p, scene.size, scene.edges, told.get("xi")).rows
        tick = flock.tick
        flock.step()
        assert flock.tick == tick + 1
        if p.layers == "instant":
            demand_clear_contacts(expected.position, p, scene)
        compare(model, flock, expected, rows, scene.size, scene.edges)
        check_invariants(flock, before, scene)
        clear_rows.append(rows)
    return float(np.mean(clear_rows))


def check_invariants(flock, before, scene):
    """Unit headings, positions in the box, information agents that never turn."""
    assert np.allclose(np.linalg.norm(flock.heading, axis=1), 1, atol=1e-12)
    assert np.array_equal(flock.heading[before.informed], before.heading[before.informed])
    assert np.array_equal(flock.informed.astype(bool), before.informed)
    if scene.edges != "open":
        assert (flock.position >= 0).all()
        assert (flock.position < np.asarray(scene.size)).all()
