"""The time left: exact cases."""

import pytest

from app.studies.experiment_runner import guess_seconds
from app.studies.study_runner import StudyProgress


def expecting(guesses, left):
    progress = StudyProgress()
    progress.guesses = guesses
    progress.expect(cell for cell, runs in left.items() for _ in range(runs))
    return progress


def test_before_any_run_the_guesses_count():
    progress = expecting({0: 2.0, 1: 10.0}, {0: 3, 1: 1})
    assert progress.seconds == 16.0
    assert progress.share == 0.0


def test_measured_cells_count_as_measured_and_others_in_proportion():
    progress = expecting({0: 2.0, 1: 10.0}, {0: 3, 1: 1})
    progress.add(0, 1.0)
    assert progress.seconds == pytest.approx(2 * 1.0 + 0.5 * 10.0)
    assert progress.share == pytest.approx(1.0 / 8.0)


def test_without_guesses_other_cells_cost_the_mean_and_nothing_is_known_before_a_run():
    progress = expecting({}, {0: 2, 1: 3})
    assert (progress.seconds, progress.share) == (0.0, 0.0)
    progress.add(0, 4.0)
    assert progress.seconds == pytest.approx(1 * 4.0 + 3 * 4.0)


def test_runs_that_are_asked_for_later_cost_the_mean_too():
    progress = expecting({}, {0: 2})
    progress.later = 10
    progress.add(0, 3.0)
    assert progress.seconds == pytest.approx(3.0 + 30.0)
    assert progress.describe(0, 0).startswith("1 of 2 runs")
    progress.expect([0])
    assert progress.describe(0, 0).startswith("1 of 12 runs")


def test_at_the_end_nothing_is_ahead():
    progress = expecting({0: 2.0}, {0: 1})
    progress.add(0, 5.0)
    assert (progress.seconds, progress.share) == (0.0, 1.0)


def test_nothing_to_do_is_done():
    assert expecting({}, {}).share == 1.0


def test_long_runs_of_large_flocks_are_guessed_longest():
    slow, quick = guess_seconds(4060.0, 500, 2), guess_seconds(140.0, 100, 0)
    assert slow > 100 * quick
