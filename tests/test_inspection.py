"""An agent seen from close: the weights are those that its rule works with."""

from __future__ import annotations

import numpy as np
import pytest

from agents import Flock

LINEAR = ["vem", "vem-a", "wvem", "hwvem"]


@pytest.mark.parametrize("model", LINEAR)
@pytest.mark.parametrize("dim", [2, 3])
def test_the_weighted_mean_of_the_inspected_is_the_next_heading(model, dim):
    flock = Flock(model, agents=80, dim=dim, size=3.2, rng=4)
    for _ in range(4):
        before, heading = (
            [flock.inspect(row) for row in range(81 - (model == "vem"))],
            flock.heading,
        )
        heading = heading.copy()
        flock.run(1)
        for seen in before:
            if flock.informed[seen.row]:
                assert not seen.weights.any()
                continue
            wish = seen.weights @ heading[seen.neighbours]
            if model.startswith("vem"):
                wish = wish + heading[seen.row]
            if np.linalg.norm(wish) > 1e-3 * max(1e-9, seen.weights.sum()):
                expected = wish / np.linalg.norm(wish)
                assert np.allclose(flock.heading[seen.row], expected, atol=1e-9)


def test_only_the_extremes_count_in_ivem():
    heading = [[np.cos(a), np.sin(a)] for a in (0.5, 1.0, 2.0, 3.0)]
    position = [[1.0, 1.0], [1.1, 1.0], [1.2, 1.0], [1.3, 1.0]]
    flock = Flock("ivem", start={"position": position, "heading": heading}, size=9.0, rng=1)
    assert flock.inspect(0).weights.tolist() == [1.0, 0.0, 1.0]


def test_contact_with_the_information_agent_outweighs_all_in_ivem_a():
    position = [[1.0, 1.0], [1.1, 1.0], [1.2, 1.0]]
    heading = [[1.0, 0.0], [0.0, 1.0], [0.6, 0.8]]
    start = {"position": position, "heading": heading, "informed": [True, False, False]}
    flock = Flock("ivem-a", start=start, size=9.0, rng=1)
    assert flock.inspect(1).weights.tolist() == [100.0, 1.0]


@pytest.mark.parametrize("seed", range(12))
def test_every_tick_can_be_inspected(seed):
    """The key of a tick is any 64-bit number."""
    flock = Flock("hwvem", agents=20, size=2.0, rng=seed)
    flock.run(seed)
    assert flock.inspect(3).id == 4
