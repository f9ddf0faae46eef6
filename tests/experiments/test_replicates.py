"""More replicates where the interval is wide, in rounds that follow from the values alone."""

import numpy as np
import pytest

from app.experiments.sweeps.given.file import Replicates
from app.experiments.sweeps.replicates import Rounds, half_width, is_precise


def test_the_interval_is_students():
    values = [1.0, 2.0, 4.0, 8.0]
    error = np.std(values, ddof=1) / 2.0
    assert half_width(values) == pytest.approx(3.182446 * error, rel=1e-6)
    assert half_width([1.0]) == np.inf


def rounds(**precision):
    asked = {"observable": "x", "within": 0.1, "most": 12, "step": 4} | precision
    return Rounds(Replicates(count=2, precision=asked), [1, 2, 3])


def noisy(cell, replicates):
    """Cell 1 never varies, cell 2 does a little, cell 3 a lot."""
    spread = {1: 0.0, 2: 0.05, 3: 5.0}[cell]
    return [spread * (-1.0) ** k for k in range(replicates)]


def test_wide_cells_get_more_until_they_are_narrow_or_have_the_most():
    made = rounds()
    while made.more(noisy):
        pass
    assert made.wanted == {1: 2, 2: 6, 3: 12}
    assert is_precise(noisy(2, 6), made.asked.precision)


def test_a_budget_is_kept_to():
    made = rounds(budget=10)
    while made.more(noisy):
        pass
    assert (made.wanted, made.total) == ({1: 2, 2: 6, 3: 2}, 10)


def test_a_relative_precision_is_a_share_of_the_mean():
    values = [100.0, 101.0, 99.0, 100.0, 100.5]
    asked = {"observable": "x", "within": 0.02, "most": 9}
    narrow, wide = (
        Replicates(count=2, precision=asked | {"relative": relative}).precision
        for relative in (True, False)
    )
    assert is_precise(values, narrow)
    assert not is_precise(values, wide)


def test_cells_without_values_are_not_precise():
    made = rounds()
    assert made.more(lambda *_: [])
    assert made.wanted == {1: 6, 2: 6, 3: 6}
