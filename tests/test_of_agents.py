"""Numbers of each agent: the signals of its model, and what is measured of any flock."""

import numpy as np

from agents import Flock
from agents.observables.of_agents import measurable, measured


def test_neighbours_are_counted_for_each_agent():
    start = {
        "position": [[1.0, 1.0], [1.5, 1.0], [2.2, 1.0], [8.0, 8.0]],
        "heading": [[1.0, 0.0]] * 4,
    }
    flock = Flock("ivem", start=start, world="open", rng=1, interpret=True)
    assert measured(flock, "neighbours").tolist() == [1.0, 2.0, 1.0, 0.0]


def test_a_model_offers_its_own_signals_and_no_other_has_them():
    flock = Flock("ivem", agents=5, rng=1, interpret=True)
    assert measurable(flock.model.columns) == ("neighbours", "angle")
    angles = np.arctan2(flock.heading[:, 1], flock.heading[:, 0])
    assert np.allclose(measured(flock, "angle"), angles % (2 * np.pi))
    assert measured(Flock("vem", agents=5, rng=1), "angle") is None
