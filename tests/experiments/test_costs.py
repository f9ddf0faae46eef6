"""The time left: exact cases."""

import pytest

from app.studies.experiment_runner import Costs, guess


def test_before_any_run_the_guesses_count():
    costs = Costs([2.0, 10.0], [3, 1])
    assert costs.ahead == 16.0
    assert costs.share == 0.0


def test_measured_cells_count_as_measured_and_others_in_proportion():
    costs = Costs([2.0, 10.0], [3, 1])
    costs.add(0, 1.0)
    assert costs.ahead == pytest.approx(2 * 1.0 + 0.5 * 10.0)
    assert costs.share == pytest.approx(1.0 / 8.0)


def test_at_the_end_nothing_is_ahead():
    costs = Costs([2.0], [1])
    costs.add(0, 5.0)
    assert (costs.ahead, costs.share) == (0.0, 1.0)


def test_nothing_to_do_is_done():
    assert Costs([], []).share == 1.0


def test_long_runs_of_large_flocks_are_guessed_longest():
    slow, quick = guess(4060.0, 500, 2), guess(140.0, 100, 0)
    assert slow > 100 * quick
