"""Today's tree beside another state of it: CPU time of an agent-tick, taking turns.

    uv run python benchmarks/engine/against.py COMMIT [--cases vem couzin-3d] [--rounds 9] [--json]

COMMIT is checked out into a folder that is removed afterwards; a folder that holds a checkout
already is used as it is, and what it compiles is kept. Each tree runs in one process of one thread,
both on the same core; while one flies the other waits. A round is the same ticks from the same
start. The ratio is of the leasts; half of the rounds have one between the two beside it.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tree import Tree
from turns import Contestant, quartiles, take_turns

ROOT = Path(__file__).resolve().parents[2]


@contextmanager
def check_out(commit: str) -> Iterator[Tree]:
    """The tree of a commit or of a folder."""
    if Path(commit).is_dir():
        with Tree(Path(commit).resolve()) as tree:
            yield tree
        return
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "tree"
        git = ["git", "-C", str(ROOT), "worktree"]
        if subprocess.run([*git, "add", "--quiet", "--detach", str(path), commit]).returncode:
            raise SystemExit(2)  # git has said why
        try:
            with Tree(path, Path(folder) / "cache") as tree:
                yield tree
        finally:
            subprocess.run([*git, "remove", "--force", str(path)], check=True)


def compare(
    then: Tree, now: Tree, name: str, changes: dict[str, int], rounds: int
) -> dict[str, Any]:
    """A case in both trees: least and median nanoseconds of an agent-tick, and their ratio."""
    started, states = then.prepare(name, changes), now.prepare(name, changes)
    _, agents, ticks = states
    both = [
        Contestant(label, agents, ticks, tree.fly) for label, tree in (("then", then), ("now", now))
    ]
    take_turns(both, rounds, name)
    row: dict[str, Any] = {"case": name, "agents": agents, "same_start": started == states}
    for clock in ("cpu", "wall"):
        for contestant in both:
            row[f"{contestant.name}_{clock}"] = contestant.least(clock)
            row[f"{contestant.name}_{clock}_median"] = contestant.median(clock)
        row[f"ratio_{clock}"] = both[0].least(clock) / both[1].least(clock)
        pairs = zip(both[0].per_step(clock), both[1].per_step(clock), strict=True)
        row[f"spread_{clock}"] = quartiles([old / new for old, new in pairs])
    return row


def main() -> None:
    """Compare each case, and print it as soon as it is there."""
    from cases import CASES  # here, since a process of a tree must import it from its own

    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("commit", help="a commit, or a folder with a checkout")
    arguments.add_argument("--cases", nargs="+", choices=CASES, default=[*CASES], metavar="CASE")
    arguments.add_argument("--rounds", type=int, default=9)
    arguments.add_argument("--agents", type=int, help="instead of the cases' own numbers")
    arguments.add_argument("--ticks", type=int, help="of a round, instead of the cases' own")
    arguments.add_argument("--json", action="store_true", help="print JSON")
    options = arguments.parse_args()
    changes = {
        key: value for key in ("agents", "ticks") if (value := getattr(options, key)) is not None
    }
    rows = []
    if not options.json:
        print("CPU time of an agent-tick, ns, least of the rounds (median in brackets)")
        print(f"{'case':18}{'agents':>9}{'then':>20}{'now':>20}{'ratio':>8}   half of the rounds")
    with check_out(options.commit) as then, Tree(ROOT) as now:
        for name in options.cases:
            row = compare(then, now, name, changes, options.rounds)
            rows.append(row)
            if not options.json:
                print(line(row), flush=True)
    if options.json:
        print(json.dumps(rows))


def line(row: dict[str, Any]) -> str:
    """A row of the table."""
    times = "".join(
        f"{row[f'{tree}_cpu']:11.1f} ({row[f'{tree}_cpu_median']:6.1f})" for tree in ("then", "now")
    )
    low, high = row["spread_cpu"]
    unlike = "" if row["same_start"] else "   (their starts differ)"
    name, agents, ratio = row["case"], row["agents"], row["ratio_cpu"]
    return f"{name:18}{agents:9}{times}{ratio:8.2f}   {low:.2f} to {high:.2f}{unlike}"


if __name__ == "__main__":
    main()
