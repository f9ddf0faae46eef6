"""What a step and a reset of many flocks in one call cost, beside single environments.

    uv run python benchmarks/learning.py
    uv run python benchmarks/learning.py --json

Three contestants take as many flocks through as many ticks, in turn, on one thread; the time of
each is the shortest of the rounds. `flocks`: `Flock.run(1)` of one after the other, nobody rewarded
and nothing seen. `single`: a loop over `gym_env`. `vector`: one `vector_env`. Flocks that end begin
anew. Then two contestants begin all flocks anew, in turn: `restart`, a `vector_env` whose flocks
somebody has asked for, so that each is made anew with all that belongs to it; `in place`, one of
which nobody has: where agents begin is written into the arrays that are there.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from flockscope import Kind, chase, gym_env, vector_env

ROUNDS = 5
STEPS = 300
"""Of each flock in a round, at most."""
NUMBERS = (1, 16, 64)
"""Flocks at once."""
ROBOT = Kind("robot", 1, steered=True)
SHARKS = Kind("shark", 3, v0=0.025, to={"robot": chase(3.0, 4.0, catch=0.15)})
CASES: dict[str, dict[str, Any]] = {
    "vem": {"run": "vem", "agents": 30, "kinds": [ROBOT]},
    "couzin": {"run": "couzin", "agents": 30, "dim": 2, "kinds": [ROBOT]},
    "evade": {
        **{"run": "vem", "agents": 1, "size": 4.0, "eta": 0.0, "k": 4},
        **{"kinds": [ROBOT, SHARKS], "reward": "evade", "ticks": 300},
    },
}


class StepCost(NamedTuple):
    """A step of so many flocks of a case, us for each flock."""

    case: str
    number: int
    flocks: float
    single: float
    vector: float
    restart: float
    """A reset of each flock, us, all of it made anew."""
    in_place: float
    """A reset of each flock, us, in its arrays alone."""

    @property
    def ratio(self) -> float:
        """How many times as long a loop over single environments takes."""
        return self.single / self.vector

    @property
    def reset_ratio(self) -> float:
        """How many times as long a reset takes in which all is made anew."""
        return self.restart / self.in_place


def run_flocks(words: dict[str, Any], number: int) -> Callable[[], None]:
    """A step of flocks by themselves, one after the other."""
    envs = [gym_env(kind="robot", seed=1 + e, **words) for e in range(number)]
    flocks = [one.flock for one in envs]
    for flock in flocks:
        flock.restart(flock.seed)

    def step() -> None:
        for flock in flocks:
            flock.run(1)
            if not len(flock.rows_of("robot")):
                flock.restart(flock.seed + 1)

    return step


def run_singles(words: dict[str, Any], number: int) -> Callable[[], None]:
    """A step of single environments, one after the other."""
    envs = [gym_env(kind="robot", seed=1 + e, **words) for e in range(number)]
    action = np.zeros(envs[0].action_space.shape or (), np.float32)
    for one in envs:
        one.reset()

    def step() -> None:
        for one in envs:
            _, _, is_over, has_ended, _ = one.step(action)
            if is_over or has_ended:
                one.reset()

    return step


def run_vector(words: dict[str, Any], number: int) -> Callable[[], None]:
    """A step of all flocks at once."""
    envs = vector_env(kind="robot", number=number, seed=1, **words)
    actions = np.zeros(envs.action_space.shape or (), np.float32)
    envs.reset()

    def step() -> None:
        envs.step(actions)

    return step


def reset_vector(words: dict[str, Any], number: int, is_shared: bool) -> Callable[[], None]:
    """A reset of all flocks at once; `is_shared`: after somebody has asked for them."""
    envs = vector_env(kind="robot", number=number, seed=1, **words)
    envs.reset()
    if is_shared:
        _ = envs.flocks

    def reset() -> None:
        envs.reset()

    return reset


def least_times(contestants: list[Callable[[], None]], times: int) -> list[float]:
    """The least time of each contestant of the rounds, in turn, s, called so many times."""
    least = [float("inf")] * len(contestants)
    for _ in range(ROUNDS):
        for k, call in enumerate(contestants):
            call()
            begin = time.process_time()
            for _ in range(times):
                call()
            least[k] = min(least[k], time.process_time() - begin)
    return least


def measure(case: str, number: int) -> StepCost:
    """The cost of a case, contestants in turn."""
    words = CASES[case]
    steps = max(20, STEPS // number)
    of_steps = [make(words, number) for make in (run_flocks, run_singles, run_vector)]
    of_resets = [reset_vector(words, number, is_shared) for is_shared in (True, False)]
    least = least_times(of_steps, steps) + least_times(of_resets, steps)
    return StepCost(case, number, *(seconds / steps / number * 1e6 for seconds in least))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="as JSON")
    options = parser.parse_args()
    costs = [measure(case, number) for case in CASES for number in NUMBERS]
    if options.json:
        ratios = [{"ratio": cost.ratio, "reset_ratio": cost.reset_ratio} for cost in costs]
        print(json.dumps([cost._asdict() | two for cost, two in zip(costs, ratios, strict=True)]))
        return
    print("us for each flock and step, then for each flock and reset")
    print(
        f"{'case':10s}{'flocks':>8s}{'alone':>9s}{'single':>9s}{'vector':>9s}{'single/vector':>15s}"
        f"{'restart':>10s}{'in place':>10s}{'restart/in place':>18s}"
    )
    for cost in costs:
        times = f"{cost.flocks:9.1f}{cost.single:9.1f}{cost.vector:9.1f}{cost.ratio:15.1f}"
        resets = f"{cost.restart:10.1f}{cost.in_place:10.1f}{cost.reset_ratio:18.1f}"
        print(f"{cost.case:10s}{cost.number:8d}{times}{resets}")


if __name__ == "__main__":
    main()
