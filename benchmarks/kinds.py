"""What it costs that agents differ: a tick with own parameters over one in which all share them.

    uv run python benchmarks/kinds.py
    uv run python benchmarks/kinds.py --json

Each contestant runs as many ticks in turn with the others, on one thread; its time is the shortest
of the rounds. `one` has one parameter that differs, `all` every one that may, `kinds` one agent in
fifty that chases the others, who flee. `model` is the same with a model of its own for that kind:
its ticks are as many of those of `kinds`.
"""

from __future__ import annotations

import argparse
import json
import time
from typing import Any, NamedTuple

import numpy as np

from agents.flock import Flock
from agents.individuals import uniform
from agents.kinds import Kind, chase
from agents.models.declare import declared

ROUNDS = 7
SECONDS = 0.2
"""Of ticks that a contestant runs in a round, at least."""
ALLOWED = 1.15
"""How many times longer a tick may take where agents differ."""
OTHERS: dict[str, dict[str, Any]] = {
    "vem": {"model": "gregoire-chate"},
    "couzin": {"model": "reynolds", "dt": 0.1},
    "dorsogna": {"model": "cucker-smale"},
}
"""The model that hunters have of their own in a flock of a model, with a tick as long; a model that
is not here has none."""
CASES = (
    *(("vem", n, "v0") for n in (1_000, 100_000)),
    *(("couzin", n, "s") for n in (1_000, 100_000)),
    *(("hwvem", n, "v0") for n in (1_000, 100_000)),
    ("dorsogna", 1_000, "alpha"),
    ("reynolds", 1_000, "r"),
)


class Cost(NamedTuple):
    """A tick of a model with so many agents."""

    model: str
    agents: int
    nanoseconds: float
    """Of one agent and tick where all share their parameters."""
    one: float
    """How many times as long where one parameter differs."""
    all: float
    """How many times as long where all that may differ do."""
    kinds: float
    """How many times as long with hunters among them."""
    own_model: float | None
    """How many times as long as that where these have a model of their own."""


def spread(model: str, names: tuple[str, ...]) -> dict[str, Any]:
    """A spread of a tenth about the default of some parameters."""
    known = {one.name: one for one in declared(Flock(model, agents=2, rng=1).model.parameters)}
    words = {}
    for name in names:
        low, high = 0.95 * known[name].default, 1.05 * known[name].default
        words[name] = uniform(max(low, known[name].low), min(high, known[name].high))
    return words


def measure(model: str, agents: int, name: str) -> Cost:
    """The cost of one case, contestants in turn, in a box in which the density is the model's."""
    small = Flock(model, rng=1)
    box = (agents / len(small.ids)) ** (1.0 / small.world.dim) * np.array(small.world.size)
    individual = small.model.individual
    flocks = [
        Flock(model, agents=agents, size=tuple(box), world="wrap", rng=1, **spread(model, names))
        for names in ((), (name,), individual)
    ]
    hunters = Kind("hunter", agents // 50, to={"flock": chase(1.0)})
    words = {"size": tuple(box), "world": "wrap", "rng": 1, "kinds": [hunters]}
    flocks.append(Flock(model, agents=agents - hunters.agents, **words))
    if model in OTHERS:
        words["kinds"] = [Kind("hunter", hunters.agents, to=hunters.to, **OTHERS[model])]
        flocks.append(Flock(model, agents=agents - hunters.agents, **words))
    for flock in flocks:
        flock.run(2)
    begin = time.perf_counter()
    flocks[0].run(1)
    ticks = max(1, round(SECONDS / (time.perf_counter() - begin)))
    least = [float("inf")] * len(flocks)
    for _ in range(ROUNDS):
        for k, flock in enumerate(flocks):
            begin = time.process_time()
            flock.run(ticks)
            least[k] = min(least[k], time.process_time() - begin)
    shared = least[0] / ticks / agents * 1e9
    one, every, kinds = (seconds / least[0] for seconds in least[1:4])
    own_model = least[4] / least[3] if model in OTHERS else None
    return Cost(model, agents, shared, one, every, kinds, own_model)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--json", action="store_true", help="as JSON")
    options = parser.parse_args()
    costs = []
    if not options.json:
        heads = "".join(f"{name:>7s}" for name in ("one", "all", "kinds", "model"))
        print(f"{'model':10s}{'agents':>9s}{'ns':>9s}{heads}")
    for case in CASES:
        cost = measure(*case)
        costs.append(cost._asdict())
        if not options.json:
            ratios = cost.one, cost.all, cost.kinds, cost.own_model
            times = "".join(f"{'':7s}" if ratio is None else f"{ratio:7.2f}" for ratio in ratios)
            print(f"{cost.model:10s}{cost.agents:9d}{cost.nanoseconds:9.0f}{times}")
    most = max(max(cost["one"], cost["all"]) for cost in costs)
    if options.json:
        print(json.dumps({"costs": costs, "most": most, "allowed": ALLOWED}))
    else:
        print(f"most where agents differ: {most:.2f} times, {ALLOWED} allowed")


if __name__ == "__main__":
    main()
