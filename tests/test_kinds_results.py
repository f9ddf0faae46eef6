"""What kinds of agents do together, against another implementation with other random numbers."""

import numpy as np
import pytest

from agents.flock import Flock
from agents.kinds import Kind
from agents.spec import Spec

SEEDS = range(6)


def polarisation_of_two(seed, first, second):
    """Polarisation of each kind and of all, mean of ticks 500 to 1500, of 100 + 100 agents."""
    other = Kind("other", 100, parameters=second, to={"flock": "own"})
    parameters = {"r": 1.0, **first}
    spec = Spec("vem", agents=100, seed=seed, size=7.0, parameters=parameters,
                kinds=[other], to={"other": "own"})  # fmt: skip
    flock = Flock(spec)
    rows = [flock.rows_of("flock"), flock.rows_of("other"), np.arange(200)]
    flock.run(500)
    total = np.zeros(3)
    for _ in range(1000):
        flock.run(1)
        total += [np.linalg.norm(flock.heading[of].mean(axis=0)) for of in rows]
    return total / 1000


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("first", "second", "expected", "sd"),
    [
        ({"eta": 1.0}, {"eta": 1.0}, (0.949, 0.949, 0.949), 0.001),
        ({"eta": 0.5}, {"eta": 3.0}, (0.955, 0.630, 0.791), 0.005),
        ({"eta": 2.0, "v0": 0.03}, {"eta": 2.0, "v0": 0.3}, (0.809, 0.811, None), 0.003),
    ],
    ids=["alike", "two noises", "two speeds"],
)
def test_two_kinds_of_vicseks_agents_are_as_ordered_as_in_naive_numpy(first, second, expected, sd):
    """Means of six seeds here and there, each with standard deviation sd: 4.5 standard errors."""
    found = np.mean([polarisation_of_two(seed, first, second) for seed in SEEDS], axis=0)
    bound = 4.5 * sd * np.sqrt(2.0 / len(SEEDS)) + 0.0005  # the expected ones are rounded
    for value, other in zip(found, expected, strict=True):
        assert other is None or abs(value - other) < bound
