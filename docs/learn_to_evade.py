"""An agent learns to evade three predators, by evolution of a policy; its curve in the docs.

    uv run python docs/learn_to_evade.py
    uv run python docs/learn_to_evade.py --out docs/learning.png
    uv run python docs/learn_to_evade.py --policy evade.py

The policy is a weighted sum of what the agent sees. CMA-ES (the package cma) looks for the weights
with which it lives longest. The printed lines are the generations: how long the best, the mean and,
on runs that it never saw, the found policy live, in ticks. `--policy` writes it as a file that
`flockscope lab --rule` flies.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import cma
import numpy as np

from flockscope import Kind, chase, gym_env

TICKS = 300
GENERATIONS = 16
NEAREST = 4
"""Of how many others the policy sees."""
SHARP = 0.1
"""The sharpest turn of a tick, in half turns: who turns at random on the spot is soon caught."""
SEEDS = range(4)
"""Runs in which a policy is tried; those from 1000 on are kept to judge it."""
UNSEEN = range(1000, 1030)


def make_env():
    """One agent, slower predators all around, and nobody else near."""
    prey = Kind("robot", 1, steered=True)
    hunters = Kind("shark", 3, v0=0.025, to={"robot": chase(3.0, 4.0, catch=0.15)})
    return gym_env(
        "vem", "robot", agents=1, size=4.0, eta=0.0, kinds=[prey, hunters],
        reward="evade", ticks=TICKS, k=NEAREST,
    )  # fmt: skip


def act(weights: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """How far the policy turns, in half turns."""
    return SHARP * np.tanh([weights[:-1] @ seen + weights[-1]])


def life(env, weights: np.ndarray, seed: int) -> int:
    """How many ticks an agent with this policy lives."""
    seen, _ = env.reset(seed=seed)
    for tick in range(TICKS):
        seen, _, is_over, has_ended, _ = env.step(act(weights, seen))
        if is_over or has_ended:
            return tick + 1
    return TICKS


def mean_life(env, weights: np.ndarray, seeds) -> float:
    """The mean over runs."""
    return float(np.mean([life(env, weights, seed) for seed in seeds]))


def learn(env) -> tuple[np.ndarray, list[tuple[float, float]]]:
    """The weights that were found, and the best and the mean of each generation."""
    size = env.observation_space.shape[0] + 1
    search = cma.CMAEvolutionStrategy(
        np.zeros(size), 0.3, {"seed": 1, "popsize": 12, "verbose": -9}
    )
    course = []
    for generation in range(GENERATIONS):
        tried = search.ask()
        lives = [mean_life(env, weights, SEEDS) for weights in tried]
        search.tell(tried, [-value for value in lives])
        course.append((max(lives), float(np.mean(lives))))
        print(f"generation {generation + 1:2d}: best {max(lives):5.0f}, mean {np.mean(lives):5.0f}")
    return search.result.xfavorite, course


POLICY = '''"""A policy that has learned to evade predators, by docs/learn_to_evade.py."""

import numpy as np

from flockscope import policy

WEIGHTS = np.array({weights})


@policy(k={k})
def evade(seen):
    """How far each agent turns, in half turns."""
    return {sharp} * np.tanh(seen @ WEIGHTS[:-1] + WEIGHTS[-1])
'''


def write_policy(weights: np.ndarray, out: Path) -> None:
    """Write the policy of these weights as a file."""
    numbers = [round(float(weight), 6) for weight in weights]
    out.write_text(POLICY.format(weights=numbers, k=NEAREST, sharp=SHARP), "utf-8")


def draw(course: list[tuple[float, float]], out: Path) -> None:
    """The curve, as a picture."""
    from app.figure import new_figure, write_figure

    best, mean = zip(*course, strict=True)
    generation = np.arange(1, len(course) + 1)
    with new_figure() as figure:
        figure.set_size_inches(5.0, 3.2)
        axes = figure.add_subplot()
        axes.plot(generation, best, label="best of a generation")
        axes.plot(generation, mean, label="mean")
        axes.set(xlabel="generation", ylabel="ticks that it lives", ylim=(0, TICKS * 1.05))
        axes.legend(loc="lower right")
        write_figure(figure, out)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--out", type=Path, help="where to draw the curve, PNG or SVG")
    parser.add_argument("--policy", type=Path, help="where to write the policy, FILE.py")
    options = parser.parse_args()
    env = make_env()
    begun = time.perf_counter()
    weights, course = learn(env)
    took = time.perf_counter() - begun
    before = mean_life(env, np.zeros(len(weights)), UNSEEN)
    after = mean_life(env, weights, UNSEEN)
    print(
        f"learned in {took:.0f} s; on {len(UNSEEN)} runs that it never saw it lives "
        f"{after:.0f} ticks of {TICKS}, and {before:.0f} where it flies straight on"
    )
    if options.policy:
        write_policy(weights, options.policy)
    if options.out:
        draw(course, options.out)


if __name__ == "__main__":
    main()
