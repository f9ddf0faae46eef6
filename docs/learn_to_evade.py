"""An agent learns to evade three predators, by evolution of a policy; its curve in the docs.

    uv run python docs/learn_to_evade.py
    uv run python docs/learn_to_evade.py --out docs/learning.png
    uv run python docs/learn_to_evade.py --policy evade.py

The policy is a weighted sum of what the agent sees. CMA-ES (the package cma) looks for the weights
with which it lives longest. All policies of a generation are tried at once, each in several flocks:
`vector_env` takes them through a tick in one call. The printed lines are the generations: how long
the best, the mean and, on runs that it never saw, the found policy live, in ticks. `--policy`
writes it as a file that `flockscope lab --rule` flies.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import cma
import numpy as np

from flockscope import Kind, chase, vector_env

TICKS = 300
GENERATIONS = 30
POLICIES = 16
"""Tried in a generation."""
NEAREST = 4
"""Of how many others the policy sees."""
SHARP = 0.1
"""The sharpest turn of a tick, in half turns: who turns at random on the spot is soon caught."""
SEEDS = range(12)
"""Runs in which a policy is tried; those from 1000 on are kept to judge it."""
UNSEEN = range(1000, 1200)


def make_flocks(number: int):
    """In each flock one agent, slower predators all around, and nobody else near."""
    prey = Kind("robot", 1, steered=True)
    hunters = Kind("shark", 3, v0=0.025, to={"robot": chase(3.0, 4.0, catch=0.15)})
    return vector_env(
        "vem", "robot", number, agents=1, size=4.0, eta=0.0, kinds=[prey, hunters],
        reward="evade", ticks=TICKS, k=NEAREST,
    )  # fmt: skip


def act(weights: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """How far policies (N, W + 1) turn of what they see (N, W), in half turns, (N, 1)."""
    wish = (weights[:, :-1] * seen).sum(axis=1) + weights[:, -1]
    return SHARP * np.tanh(wish)[:, None]


def mean_lives(flocks, policies: np.ndarray, seeds) -> np.ndarray:
    """How many ticks an agent with each of the policies (P, W + 1) lives, the mean over runs."""
    weights = np.repeat(policies, len(seeds), axis=0)
    seen, _ = flocks.reset(seed=[*seeds] * len(policies))
    life, lives_on = np.zeros(len(weights)), np.ones(len(weights), bool)
    while lives_on.any():
        seen, _, is_over, has_ended, _ = flocks.step(act(weights, seen))
        life += lives_on
        lives_on &= ~(is_over | has_ended)
    return life.reshape(len(policies), -1).mean(axis=1)


def learn() -> tuple[np.ndarray, list[tuple[float, float]]]:
    """The weights that were found, and the best and the mean of each generation."""
    flocks = make_flocks(POLICIES * len(SEEDS))
    size = flocks.single_observation_space.shape[0] + 1
    search = cma.CMAEvolutionStrategy(
        np.zeros(size), 0.3, {"seed": 1, "popsize": POLICIES, "verbose": -9}
    )
    course = []
    for generation in range(GENERATIONS):
        tried = search.ask()
        lives = mean_lives(flocks, np.array(tried), SEEDS)
        search.tell(tried, -lives)
        course.append((float(lives.max()), float(lives.mean())))
        print(f"generation {generation + 1:2d}: best {lives.max():5.0f}, mean {lives.mean():5.0f}")
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
    begun = time.perf_counter()
    weights, course = learn()
    took = time.perf_counter() - begun
    policies = np.array([np.zeros(len(weights)), weights])
    before, after = mean_lives(make_flocks(2 * len(UNSEEN)), policies, UNSEEN)
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
