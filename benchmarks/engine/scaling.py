"""How cost grows: an agent-step over agents, density, neighbours, obstacles and threads; memory.

    uv run --group bench python benchmarks/engine/scaling.py [--quick] [--only PART] [--picture PNG]

CPU time of one thread, but of threads wall time; least of several rounds in which all who meet the
same value take turns. Nobody is run where a tick would last longer than `--longest`. Neighbours are
those that each density brings: a longer range is a denser flock in other units. A knee is where an
agent costs more than 1.3 times the least of smaller flocks. `--only` measures some of it.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import sys
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict
from pathlib import Path

import memory
from pairs import MODELS, Pairs, pairs
from scaling_picture import draw
from sweeps import AMONG, HOMES, MANY, Point, Sweep, all_sweeps, run
from turns import with_progress

SIZES = (100, 1_000, 10_000, 100_000, 1_000_000, 4_000_000, 10_000_000)
PARTS = ("agents", "density", "obstacles", "gathering", "threads", "pairs", "memory")
KNEE = 1.3
"""Times the least cost of an agent-step in smaller flocks from which on it is a knee."""
FEW = 1_000
"""Agents from which on it counts: smaller flocks share the cost of a call among few."""
LEAST_HELD, MOST_HELD = 100_000, 1_000_000
"""Agents whose memory is measured, and at most with all of Mesa's agents."""


def table(sweep: Sweep, points: list[Point], left_out: list[str]) -> str:
    """Nanoseconds of an agent-step: a line for each name, a column for each value."""
    lines = [f"ns per agent-step over {sweep.title}"]
    lines += [f"{sweep.axis:22}" + "".join(f"{value:11,.8g}" for value in sweep.values)]
    for name in sweep.makers:
        by_value = {point.value: point for point in points if point.name == name}
        if by_value:
            lines += [
                name.ljust(22) + row({x: point.least for x, point in by_value.items()}, sweep)
            ]
        near = {
            x: point.neighbours for x, point in by_value.items() if point.neighbours is not None
        }
        if near:
            lines += [f"{'  its neighbours':22}" + row(near, sweep)]
            of_pair = {x: by_value[x].least / near[x] for x in near}
            lines += [f"{'  ns per neighbour':22}" + row(of_pair, sweep)]
    return "\n".join([*lines, *(f"left out: {name}" for name in left_out)])


def knees(points: list[Point]) -> list[str]:
    """For each of our models what an agent costs at most, in times the least of smaller flocks."""
    lines = []
    for name in HOMES:
        costs = {p.value: p.least for p in points if p.name == name and p.value >= FEW}
        if len(costs) > 1:
            growth = {n: costs[n] / min(costs[m] for m in costs if m <= n) for n in costs}
            value, times = max(growth.items(), key=lambda item: item[1])
            verdict = "a knee" if times > KNEE else "no knee"
            lines.append(f"{name}: {verdict}, at most {times:.2f} times the least, at {value:,}")
    return lines


def row(numbers: dict[float, float], sweep: Sweep) -> str:
    """A number in each column that has one."""
    return "".join(
        f"{numbers[value]:11,.1f}" if value in numbers else f"{'':11}" for value in sweep.values
    )


def table_of_pairs(rows: list[Pairs]) -> str:
    """Cost of a pair of neighbours in one cell and in many."""
    lines = [f"{'ns per pair of neighbours':26}{'pairs':>11}{'one cell':>10}{'many':>8}   agents"]
    for row in rows:
        agents = f"{row.agents[0]:,} and {row.agents[1]:,}"
        lines.append(f"{row.name:26}{row.pairs:11,}{row.one:10.2f}{row.many:8.2f}   {agents}")
    return "\n".join(lines)


def in_fresh_process[Answer](measure: Callable[[int], Answer], agents: int) -> Answer:
    """What `memory.py` measures, in a process of its own."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as fresh:
        return fresh.submit(measure, agents).result()


def measured_memory(largest: int) -> dict[str, float]:
    """Bytes of an agent of vem in a plane, by what they are of."""
    some = max(LEAST_HELD, min(largest, MOST_HELD))
    arrays, members = in_fresh_process(memory.bytes_per_agent, some)
    held = {f"{some:,} agents": arrays, f"{some:,} agents, each one of Mesa's": members}
    for agents in (n for n in SIZES if MOST_HELD <= n <= largest):
        held[f"{agents:,} agents, at most"] = in_fresh_process(memory.peak_per_agent, agents)
    return held


def main() -> None:
    """Measure, print, draw."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--quick", action="store_true", help="3 rounds, up to 10 000 agents")
    arguments.add_argument("--largest", type=int, default=SIZES[-1], help="agents at most")
    arguments.add_argument("--rounds", type=int, default=7)
    arguments.add_argument("--turn", type=float, default=0.1, help="seconds of a turn, about")
    arguments.add_argument("--longest", type=float, default=8.0, help="seconds of a tick at most")
    arguments.add_argument("--only", action="append", choices=PARTS, help="measure this alone")
    arguments.add_argument("--picture", type=Path, help="PNG or SVG to draw")
    arguments.add_argument("--json", action="store_true", help="print JSON")
    options = arguments.parse_args()
    rounds = min(options.rounds, 3) if options.quick else options.rounds
    largest = min(options.largest, MANY) if options.quick else options.largest
    many, among = min(MANY, largest), min(AMONG, largest)
    parts = options.only or PARTS
    if options.picture and not {"agents", "density", "obstacles"} <= {*parts}:
        arguments.error("--picture draws agents, density and obstacles: measure all three")
    sweeps = all_sweeps([n for n in SIZES if n <= largest], many, among)
    sweeps = {name: sweep for name, sweep in sweeps.items() if name in parts}
    points: dict[str, list[Point]] = {}
    left_out: dict[str, list[str]] = {}
    for name, sweep in sweeps.items():
        points[name], left_out[name] = run(sweep, rounds, options.turn, options.longest, name)
        if not options.json:
            more = knees(points[name]) if name == "agents" else []
            print("\n".join([table(sweep, points[name], left_out[name]), *more]), end="\n\n")
            sys.stdout.flush()
    of_pairs = MODELS if "pairs" in parts else ()
    rows = [pairs(model, among, rounds) for model in with_progress(of_pairs, "pairs")]
    held = measured_memory(largest) if "memory" in parts else {}
    if options.picture:
        draw(sweeps, points, options.picture)
    if options.json:
        json.dump(
            {
                "sweeps": {
                    name: [asdict(point) for point in some] for name, some in points.items()
                },
                "left_out": left_out,
                "pairs": [asdict(row) for row in rows],
                "bytes_per_agent": held,
            },
            sys.stdout,
        )
        return
    if rows:
        print(table_of_pairs(rows), end="\n\n")
    for what, size in held.items():
        print(f"bytes per agent, {what}: {size:.0f}")


if __name__ == "__main__":
    main()
