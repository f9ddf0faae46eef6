"""More replicates where the interval is wide, in rounds that follow from the values alone."""

import math

from app.studies.judge.judge import ranges_of
from app.studies.judge.statistics import summary
from app.studies.sweeps.sweep_file import Replicates
from app.studies.sweeps.sweep_runner import Rounds, half_width, is_precise


def test_the_half_interval_is_the_wider_side_of_that_of_papers():
    values = [1.0, 2.0, 4.0, 8.0]
    low, high = summary(ranges_of(values)).interval
    assert half_width(values) == max(3.75 - low, high - 3.75)
    assert math.isnan(half_width([1.0]))
    assert math.isnan(half_width([2.0, 2.0]))
    assert math.isnan(half_width([]))


def rounds(**precision):
    asked = {"observable": "x", "within": 0.1, "most": 30, "step": 4} | precision
    return Rounds(Replicates(count=2, precision=asked), [1, 2, 3])


def noisy(cell, replicates):
    """Cell 1 never varies, cell 2 does a little, cell 3 a lot."""
    spread = {1: 0.0, 2: 0.05, 3: 5.0}[cell]
    return [spread * (-1.0) ** k for k in range(replicates)]


def test_wide_cells_get_more_until_they_are_narrow_or_have_the_most():
    made = rounds()
    while made.ask_for_more(noisy):
        pass
    assert made.wanted == {1: 10, 2: 10, 3: 30}, "nothing is looked at before ten runs"
    assert is_precise(noisy(2, 10), made.asked.precision)


def test_a_budget_is_kept_to():
    made = rounds(budget=18)
    while made.ask_for_more(noisy):
        pass
    assert (made.wanted, made.total) == ({1: 10, 2: 6, 3: 2}, 18)


def test_a_relative_precision_is_a_share_of_the_mean():
    values = [100.0, 101.0, 99.0, 100.0, 100.5] * 2
    asked = {"observable": "x", "within": 0.02, "most": 19}
    narrow, wide = (
        Replicates(count=2, precision=asked | {"relative": relative}).precision
        for relative in (True, False)
    )
    assert is_precise(values, narrow)
    assert not is_precise(values, wide)


def test_cells_without_values_are_not_precise():
    made = rounds()
    assert made.ask_for_more(lambda *_: [])
    assert made.wanted == {1: 10, 2: 10, 3: 10}
