"""A model as plain Python: the same functions, the same numbers up to rounding."""

from __future__ import annotations

import os
import subprocess
import sys

import numpy as np
import pytest

from agents import Flock

RUNS = [
    {"model": "vem", "dim": 3, "eta": 0.4, "noise": "vectorial"},
    {"model": "hwvem", "eta": 0.4},
    {"model": "couzin"},
    {"model": "guarded"},
    {"model": "hwvem-cars"},
    {"model": "ivem", "activation": "random", "eta": 0.3},
    {"model": "boundary-points"},
]
CLOSE, CLOSE_THROUGH_ARCCOS = 1e-9, 1e-7
"""How far two roundings may come apart; of cosines near 1 the angle keeps half of the digits."""


@pytest.mark.parametrize("settings", RUNS, ids=lambda settings: settings["model"])
def test_plain_python_gives_the_same_numbers_up_to_rounding(settings):
    compiled, plain = (Flock(**settings, agents=9, rng=5, interpret=asked) for asked in (0, 1))
    for flock in (compiled, plain):
        flock.run(4)
    close = CLOSE_THROUGH_ARCCOS if settings["model"] == "guarded" else CLOSE
    assert np.abs(compiled.heading - plain.heading).max() < close
    assert np.abs(compiled.position - plain.position).max() < close
    assert np.allclose(compiled.signals(), plain.signals(), atol=close, equal_nan=True)
    near, same = compiled.inspect(1), plain.inspect(1)
    assert np.array_equal(near.neighbours, same.neighbours)
    assert np.allclose(near.weights, same.weights, atol=close)


def test_members_step_alike():
    whole, single = (Flock("vem", agents=7, eta=0.3, rng=5, interpret=True) for _ in range(2))
    whole.step()
    single.agents.shuffle_do("step")
    assert np.array_equal(whole.position, single.position)
    assert whole.is_compiled, "there is nothing to wait for"


SCRIPT = """
import sys, warnings
warnings.simplefilter("error")
from agents import Flock
from agents.rules.vicsek import VEM
sys.breakpointhook = lambda: print("stopped")
flock = Flock("vem", agents=5, size=1.0, rng=1, eta=0.2)
flock.run(2)
flock.inspect(0)
flock.observe("consistency")
print(flock.position.tolist())
"""


def test_without_numba_all_of_it_is_plain_python(tmp_path):
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "FLOCKSCOPE_CACHE": str(tmp_path)}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True
    )
    here = Flock("vem", agents=5, size=1.0, rng=1, eta=0.2, interpret=True)
    here.run(2)
    assert done.stdout.strip() == str(here.position.tolist())
    assert not list(tmp_path.rglob("*.kernel"))
