"""Flocks too dense for a laboratory."""

from __future__ import annotations

import numpy as np
import pytest

from agents.flock import Flock
from app.viewer.measuring.time_series import expected_pairs, refuse_too_dense, refuse_too_many_links
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation
from tests.viewer.stub_flock import StubFlock
from tests.viewer.waiting import until
from worlds.input_error import InputError


@pytest.mark.parametrize("dim", [2, 3])
def test_expected_pairs_are_those_of_an_even_flock(dim):
    flock = Flock("vem", agents=2000, size=10.0, dim=dim, rng=1)
    assert len(flock.links()) == pytest.approx(
        expected_pairs(2000, np.full(dim, 10.0), 1.0), rel=0.1
    )


def test_everybody_sees_everybody_in_a_tiny_world():
    assert expected_pairs(100, np.array([0.1, 0.1]), 1.0) == 5000


def test_a_flock_that_would_stall_the_laboratory_is_refused():
    refuse_too_dense(StubFlock(preset_spec(agents=19_000, size=1.0)))
    with pytest.raises(InputError, match="pairs of neighbours"):
        refuse_too_dense(StubFlock(preset_spec(agents=21_000, size=1.0)))


def test_links_that_would_fill_the_memory_are_not_listed():
    refuse_too_many_links(StubFlock(preset_spec(agents=4000, size=1.0)))
    refuse_too_many_links(StubFlock(preset_spec(agents=20_000, size=70.0)))
    with pytest.raises(InputError, match="too many neighbours"):
        refuse_too_many_links(StubFlock(preset_spec(agents=20_000, size=1.0)))


def test_a_setup_that_is_too_dense_leaves_the_old_flock():
    simulation = Simulation(preset_spec(agents=5), running=False, build=StubFlock)
    assert simulation.ready.wait(60)
    simulation.setup(preset_spec(agents=21_000, size=1.0))
    assert "pairs of neighbours" in simulation.notices.get(timeout=60)
    until(lambda: not simulation.state.busy)
    assert simulation.state.agents == 5
    simulation.close()
