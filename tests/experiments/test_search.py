"""Searches: they find known points, propose the same points again, and end where all is equal."""

import numpy as np
import pytest

from app.studies.search import PointScores, search

PLACE = np.array([0.3, 0.9])


class Judging:
    """Points are worth their squared distance from a place; x may be at most `most`."""

    def __init__(self, most=1.0):
        self.most = most
        self.points = np.empty((0, 2))

    def worth(self, points):
        return ((points - PLACE) ** 2).sum(axis=1)

    def __call__(self, points):
        self.points = np.concatenate([self.points, points])
        return PointScores(self.worth(points)[:, None], points[:, :1] - self.most)

    @property
    def best(self):
        allowed = self.points[self.points[:, 0] <= self.most]
        return allowed[self.worth(allowed).argmin()]


def run(algorithm, judge, seed=1, evaluations=160, objectives=1):
    sizes = {"evaluations": evaluations, "population": 8}
    return search(algorithm, 2, objectives, 1, judge, seed=seed, **sizes)


@pytest.mark.parametrize("algorithm", ["ga", "pso", "cma"])
def test_the_best_point_is_found_within_its_evaluations(algorithm):
    free, bound = Judging(), Judging(most=0.2)
    assert run(algorithm, free) == "evaluations"
    assert len(free.points) == 160
    assert ((free.points >= 0.0) & (free.points <= 1.0)).all()
    assert free.best == pytest.approx(PLACE, abs=0.05)
    run(algorithm, bound)
    assert bound.best == pytest.approx([0.2, 0.9], abs=0.05)


@pytest.mark.parametrize("algorithm", ["ga", "pso", "cma"])
@pytest.mark.parametrize("seed", [0, 7])
def test_the_same_seed_proposes_the_same_points_to_the_bit(algorithm, seed):
    once, again, other = Judging(), Judging(), Judging()
    before = np.random.get_state()[1].tobytes()  # noqa: NPY002
    run(algorithm, once, seed)
    after = np.random.get_state()[1].tobytes()  # noqa: NPY002
    assert after == before, "NumPy's own generator is nobody's"
    np.random.seed(3)  # noqa: NPY002
    run(algorithm, again, seed)
    run(algorithm, other, seed + 1)
    assert once.points.tobytes() == again.points.tobytes()
    assert once.points.tobytes() != other.points.tobytes()


def test_cma_ends_on_a_plateau():
    flat = lambda points: PointScores(np.ones((len(points), 1)), np.zeros((len(points), 1)))  # noqa: E731
    assert run("cma", flat) == "flat"
    assert run("pso", flat) == "evaluations"


def test_a_front_reaches_both_ends():
    seen = []

    def two(points):
        seen.append(points)
        x, y = points.T
        return PointScores(np.column_stack([x + y, 1.0 - x + y]), np.zeros((len(points), 1)))

    run("nsga2", two, objectives=2)
    x, y = np.concatenate(seen)[-40:].T
    assert x.min() < 0.15
    assert x.max() > 0.85
    assert np.median(y) < 0.1, "what helps neither objective goes"
