"""Searches for the best point of a cube, by pymoo and cma; they know nothing of flocks.

A search follows from its seed and from the values that it is given: begun again, it proposes the
same points to the bit, so that whoever keeps the values can go on with it after any stop.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from worlds.plug_ins import demand

Algorithm = Literal["ga", "pso", "cma", "nsga2"]
ALGORITHMS: tuple[Algorithm, ...] = get_args(Algorithm)
TITLES = {
    "ga": "genetic algorithm",
    "pso": "particle swarm",
    "cma": "CMA-ES",
    "nsga2": "NSGA-II",
}
End = Literal["evaluations", "flat", "converged"]
"""Why a search is over: all evaluations are made; all it sees is equal; it proposes no other."""
PENALTY = 1e12
"""What stands for a value that is not there: searches end in nan where one is nan."""


class PointScores(NamedTuple):
    """What points (K, D) are worth."""

    objectives: np.ndarray
    """(K, M), the less the better, all finite."""
    violations: np.ndarray
    """(K, C), above 0 where a point is not allowed, and by how much."""


Judge = Callable[[np.ndarray], PointScores]


def search(
    algorithm: Algorithm,
    dimensions: int,
    objectives: int,
    constraints: int,
    judge: Judge,
    *,
    evaluations: int,
    population: int,
    seed: int,
) -> End:
    """Have points of the unit cube judged, generation by generation, and say why it is over.

    `judge` hears of each generation, (K, D), and may end the search by raising. Raises InputError
    where the package is not installed.
    """
    demand_package(algorithm)
    if algorithm == "cma":
        return search_with_cma(dimensions, judge, evaluations, population, seed)
    shape = dimensions, objectives, constraints
    return search_with_pymoo(algorithm, shape, judge, evaluations, population, seed)


def demand_package(algorithm: Algorithm) -> None:
    """Refuse an algorithm whose package is not installed. Raises InputError."""
    package = "cma" if algorithm == "cma" else "pymoo"
    demand(package, f"a search by {TITLES[algorithm]}", "experiments")


def search_with_pymoo(
    algorithm: Algorithm,
    shape: tuple[int, int, int],
    judge: Judge,
    evaluations: int,
    population: int,
    seed: int,
) -> End:
    """A search of pymoo's, asked and told."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.algorithms.soo.nonconvex.pso import PSO
    from pymoo.config import Config
    from pymoo.core.evaluator import Evaluator
    from pymoo.core.problem import Problem
    from pymoo.core.termination import NoTermination
    from pymoo.problems.static import StaticProblem

    Config.warnings["not_compiled"] = False
    dimensions, objectives, constraints = shape
    problem = Problem(n_var=dimensions, n_obj=objectives, n_ieq_constr=constraints, xl=0.0, xu=1.0)
    optimiser = {"ga": GA, "pso": PSO, "nsga2": NSGA2}[algorithm](pop_size=population)
    optimiser.setup(problem, termination=NoTermination(), seed=seed, verbose=False)
    left = evaluations
    while left > 0:
        candidates = optimiser.ask()
        if candidates is None or len(candidates) == 0:
            return "converged"
        points = np.clip(candidates.get("X").astype(float), 0.0, 1.0)[:left]
        scores = judge(points)
        left -= len(points)
        if left > 0:
            static = StaticProblem(problem, F=scores.objectives, G=scores.violations)
            Evaluator().eval(static, candidates)
            optimiser.tell(infills=candidates)
    return "evaluations"


def search_with_cma(
    dimensions: int, judge: Judge, evaluations: int, population: int, seed: int
) -> End:
    """A search of cma's; points that are not allowed are worse than all others, by how far."""
    import cma

    rng = np.random.default_rng(seed)  # its own would be NumPy's global one, which others use
    options: dict[str, Any] = {
        "bounds": [0.0, 1.0],
        "popsize": population,
        "seed": np.nan,
        "randn": lambda *size: rng.standard_normal(size),
        "tolflatfitness": 3,
        "verbose": -9,
        "verb_log": 0,
    }
    strategy = cma.CMAEvolutionStrategy(dimensions * [0.5], 0.3, options)
    left = evaluations
    while left > 0:
        candidates = strategy.ask()
        points = np.clip(np.array(candidates, float), 0.0, 1.0)[:left]
        scores = judge(points)
        left -= len(points)
        if left <= 0:
            break
        broken = np.maximum(scores.violations, 0.0).sum(axis=1)
        values = np.where(broken > 0.0, PENALTY * (1.0 + broken), scores.objectives[:, 0])
        strategy.tell(candidates, values.tolist())
        why = strategy.stop()
        if why:
            return "flat" if "tolflatfitness" in why or np.ptp(values) == 0.0 else "converged"
    return "evaluations"
