"""The oracle of the noise against published numbers."""

import math

import numpy as np

from oracles import noise


def test_mix_is_the_splitmix64_finaliser():
    # the first outputs of splitmix64 for seeds 0 and 1234567 (reference C code of S. Vigna)
    assert noise.mix(noise.G) == 0xE220A8397B1DCDAF
    outputs = [noise.mix(1234567 + k * noise.G) for k in (1, 2)]
    assert outputs == [6457827717110365317, 3203168211198807973]


def test_uniform_fills_the_unit_interval():
    u = np.array([noise.uniform(3, t, i, d) for t in range(20) for i in range(50) for d in (0, 1)])
    assert (u >= 0).all()
    assert (u < 1).all()
    assert len(np.unique(u)) == len(u)
    assert abs(u.mean() - 0.5) < 4 / math.sqrt(12 * len(u))


def test_noise_has_its_range_and_length():
    turn = noise.turns(3, 5, np.arange(1000), 0.4)
    assert np.abs(turn).max() <= 0.2
    assert turn.max() - turn.min() > 0.39
    xi = noise.directions(3, 5, np.arange(1000))
    assert np.allclose(np.hypot(xi[:, 0], xi[:, 1]), 1)
    assert np.hypot(*xi.mean(axis=0)) < 0.1
