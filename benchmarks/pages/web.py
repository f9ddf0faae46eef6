"""Flocks as web pages: what each takes to make, to load and to run, and how exact it is.

    uv run python benchmarks/pages/web.py [MODEL ...] [--quick] [--json]

Every model of the catalogue with its default scene, or those that are named. Each page is made in a
process of its own with an empty cache, so that nothing is compiled for it already. Needs Chromium;
Firefox (FLOCKSCOPE_FIREFOX, else firefox-esr or firefox) and node are compared with it where they
are there. Chromium and the flock here take turns; least of the rounds by the clock, since a browser
tells no CPU time. The ratio is of the leasts; half of the rounds have one between the two of
`ratio_spread` in the JSON.

"made": seconds of CPU for the page. "tick 1": seconds from opening the file until the first tick.
"after 20", "after 100": largest difference of any coordinate from the flock here. "bits": the start
of the SHA-256 of all positions in Chromium, after 20 and 100 ticks and after 20 from another start
with three agents more, and a letter for each runtime in turn: those with the same letter have the
same bits.
"""

from __future__ import annotations

import argparse
import base64
import gzip
import hashlib
import json
import os
import signal
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks" / "engine")]

from turns import Contestant, Taken, flight_of, quartiles, take_turns, with_progress  # noqa: E402
from web_runtimes import Chromium, Firefox, Node, RuntimeFault, other_runtimes  # noqa: E402

from agents.catalogue import MODELS  # noqa: E402
from agents.flock import Flock  # noqa: E402

SEED = 1
TICKS = (20, 100)
CLOSE = 1e-9
"""Difference after 20 ticks up to which a page flies as the flock here."""
LARGE = 300_000
"""Bytes of a page that are named."""
ROUNDS, TURN = 9, 0.05
"""How often each has its turn, and for how many seconds, about."""
OPENINGS = 3
"""How often a page is opened."""
QUICK = {"rounds": 2, "turn": 0.01, "openings": 1}
CHILD = """
import base64, json, sys, time
from pathlib import Path
import app.viewer.lab.flock_page as pages
from agents.flock import Flock
from worlds.input_error import InputError

model, seed, folder = sys.argv[1], int(sys.argv[2]), Path(sys.argv[3])
make_program, programs = pages.web_program, []

def keep_program(*given):
    programs.append(make_program(*given))
    return programs[-1]

pages.web_program = keep_program
flock = Flock(model, rng=seed)
begins = time.process_time()
try:
    page = pages.flock_page(flock)
except InputError as refusal:
    print(json.dumps({"refused": str(refusal)}))
else:
    seconds = time.process_time() - begins
    (folder / "page.html").write_text(page, "utf-8")
    (program,) = programs
    print(json.dumps({
        "seconds": seconds,
        "program": {
            "module": base64.b64encode(program.module).decode(),
            "image": base64.b64encode(program.memory).decode(),
            "manifest": program.manifest,
        },
    }))
"""
"""Makes a page in `folder`, and prints its program."""


def make_page(model: str, folder: Path) -> dict[str, Any]:
    """Make a model's page in a folder: seconds of CPU and its program, or why it is refused."""
    cache = folder / "cache"
    cache.mkdir()
    done = subprocess.run(
        [sys.executable, "-c", CHILD, model, str(SEED), str(folder)],
        env=os.environ | {"FLOCKSCOPE_CACHE": str(cache), "PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
    )
    if done.returncode:
        return {"refused": f"making it fails: {done.stderr.strip().splitlines()[-1]}"}
    return json.loads(done.stdout.splitlines()[-1])


def first_tick(chromium: Chromium, file: Path) -> float:
    """Seconds by the clock from opening a page until its flock has made a tick."""
    page = chromium.open()
    try:
        page.goto("about:blank")
        began = time.perf_counter()
        page.goto(file.as_uri(), wait_until="commit")
        page.locator("#go:enabled").wait_for()
        page.locator("#step").click()
        page.locator("#tick:not(:text-is('0'))").wait_for()
        return time.perf_counter() - began
    finally:
        page.close()


def largest_difference(flock: Flock, bits: bytes) -> float:
    """Of any coordinate from where the flock's agents are now; across a seam the short way."""
    away = np.frombuffer(bits).reshape(flock.position.shape) - flock.position
    size = np.where(flock.world.wraps, flock.world.size, np.inf)
    with np.errstate(invalid="ignore"):
        around = np.where(np.isfinite(size), size * np.round(away / size), 0.0)
    return float(np.abs(away - around).max())


def compare_speed(flock: Flock, page: Any, rounds: int, turn: float) -> dict[str, Any]:
    """Milliseconds per tick of a flock here and in a page, which take turns."""

    def fly_in_page(ticks: int) -> Taken:
        return Taken(float("nan"), page.evaluate("(ticks) => secondsOf(kernel, ticks)", ticks))

    fly_here = flight_of(flock)
    fly_here(20)
    for _ in range(20):  # Chromium makes its faster code while the loop is called
        fly_in_page(5)
    ticks = max(5, min(500, round(turn / (fly_here(20).wall / 20))))
    both = [
        Contestant(name, 1, ticks, fly)
        for name, fly in (("native", fly_here), ("chromium", fly_in_page))
    ]
    take_turns(both, rounds)
    native, chromium = (contestant.per_step("wall") for contestant in both)
    return {
        "native_ms": 1e-6 * min(native),
        "chromium_ms": 1e-6 * min(chromium),
        "ratio": min(chromium) / min(native),
        "ratio_spread": quartiles([b / a for a, b in zip(native, chromium, strict=True)]),
    }


def measure(
    model: str,
    chromium: Chromium,
    others: Sequence[Firefox | Node],
    options: argparse.Namespace,
) -> dict[str, Any]:
    """A row of the table, or why there is none."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        made = make_page(model, folder)
        if "refused" in made:
            return {"model": model, "refused": made["refused"]}
        program, file = made["program"], folder / "page.html"
        content = file.read_bytes()
        flock = Flock(model, rng=SEED)
        row: dict[str, Any] = {
            "model": model,
            "agents": len(flock.ids),
            "dim": flock.world.dim,
            "runner": program["manifest"]["runner"],
            "made_s": made["seconds"],
            "page_bytes": len(content),
            "page_gzipped_bytes": len(gzip.compress(content, mtime=0)),
            "module_bytes": len(base64.b64decode(program["module"])),
        }
        row["first_tick_s"] = statistics.median(
            first_tick(chromium, file) for _ in range(options.openings)
        )
    page = chromium.kernel_page(program)
    try:
        row["imports"] = page.evaluate("importsOf", program)
        found = page.evaluate("(ticks) => positionsAfter(kernel, ticks)", TICKS)
        there = [base64.b64decode(text) for text in found]
        for ticks, bits in zip(TICKS, there, strict=False):  # the last is of another start
            flock.run(ticks - flock.tick)
            row[f"difference_{ticks}"] = largest_difference(flock, bits)
        row |= compare_speed(flock, page, options.rounds, options.turn)
    finally:
        page.close()
    row["sha256"] = {chromium.name: hashlib.sha256(b"".join(there)).hexdigest()}
    row["faults"] = []
    for runtime in others:
        try:
            bits = b"".join(runtime.positions(program, TICKS))
            row["sha256"][runtime.name] = hashlib.sha256(bits).hexdigest()
        except RuntimeFault as fault:
            row["faults"].append(str(fault))
    return row


HEADING = (
    f"{'':17}{'agents':>7}{'made':>7}{'page':>7}{'gz':>7}{'module':>8}{'tick 1':>8}{'native':>9}"
    f"{'Chromium':>10}{'ratio':>7}{'after 20':>10}{'after 100':>10}  bits       imports\n"
    f"{'model':17}{'':>7}{'s CPU':>7}{'kB':>7}{'kB':>7}{'kB':>8}{'s':>8}{'ms/tick':>9}"
    f"{'ms/tick':>10}"
)


def line(row: dict[str, Any]) -> str:
    """A row of the table."""
    if "refused" in row:
        return f"{row['model']:17} refused: {row['refused']}"
    kilobytes = [row[f"{part}_bytes"] / 1e3 for part in ("page", "page_gzipped", "module")]
    text = f"{row['model']:17}{row['agents']:7}{row['made_s']:7.1f}"
    text += "{:7.1f}{:7.1f}{:8.1f}".format(*kilobytes)
    text += f"{row['first_tick_s']:8.2f}{row['native_ms']:9.4f}{row['chromium_ms']:10.4f}"
    text += f"{row['ratio']:7.2f}{row['difference_20']:10.0e}{row['difference_100']:10.0e}"
    hashes = [*row["sha256"].values()]
    letters = "".join("abc"[list(dict.fromkeys(hashes)).index(digest)] for digest in hashes)
    text += f"  {hashes[0][:6]} {letters:4}{' '.join(sorted(row['imports']))}"
    return "\n".join([text, *(f"  {fault}" for fault in row["faults"])])


def verdicts(rows: Sequence[dict[str, Any]]) -> list[str]:
    """What the rows say together, a line each."""
    refused = [row["model"] for row in rows if "refused" in row]
    pages = [row for row in rows if "refused" not in row]
    said = [f"pages: {len(pages)} of {len(rows)} models; refused: {listed(refused)}"]
    if not pages:
        return said
    runtimes = list(dict.fromkeys(name for row in pages for name in row["sha256"]))
    if len(runtimes) > 1:
        agree = [
            row["model"]
            for row in pages
            if len(row["sha256"]) == len(runtimes) and len(set(row["sha256"].values())) == 1
        ]
        others = [row["model"] for row in pages if row["model"] not in agree]
        said.append(
            f"the same bits, from another start too, in {', '.join(runtimes)}: "
            f"{len(agree)} of {len(pages)}; not: {listed(others)}"
        )
    else:
        said.append(f"bits are not compared: there is no Firefox and no node beside {runtimes[0]}")
    for ticks in TICKS:
        apart = [row["model"] for row in pages if not row[f"difference_{ticks}"] <= CLOSE]
        said.append(f"further than {CLOSE:g} from native after {ticks} ticks: {listed(apart)}")
    largest = max(pages, key=lambda row: row["page_bytes"])
    said.append(
        f"largest page: {largest['model']}, {largest['page_bytes'] / 1e3:.1f} kB, "
        f"{largest['page_gzipped_bytes'] / 1e3:.1f} kB by gzip"
    )
    large = [row["model"] for row in pages if row["page_bytes"] > LARGE]
    said.append(f"larger than {LARGE / 1e3:.0f} kB: {listed(large)}")
    ratios = {row["model"]: row["ratio"] for row in pages}
    worst = max(ratios, key=lambda model: ratios[model])
    said.append(
        f"Chromium over native, ms per tick: median {statistics.median(ratios.values()):.2f}, "
        f"largest {ratios[worst]:.2f} ({worst})"
    )
    faults = [fault for row in pages for fault in row["faults"]]
    return [*said, *([f"runtimes that did not run a flock: {len(faults)}"] if faults else [])]


def listed(names: Sequence[str]) -> str:
    """Names, or that there are none."""
    return ", ".join(names) or "none"


def main() -> None:
    """Measure each model, and print its row as soon as it is there."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("models", nargs="*", choices=[*MODELS, []], metavar="MODEL")
    arguments.add_argument("--quick", action="store_true", help="2 short rounds, opened once")
    arguments.add_argument("--rounds", type=int, default=ROUNDS)
    arguments.add_argument("--turn", type=float, default=TURN, help="seconds of a turn, about")
    arguments.add_argument("--openings", type=int, default=OPENINGS, help="of each page")
    arguments.add_argument("--json", action="store_true", help="print JSON")
    options = arguments.parse_args()
    if options.quick:
        vars(options).update(QUICK)
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))  # browsers are ended all the same
    chromium, others = Chromium(), other_runtimes()
    rows = []
    try:
        if not options.json:
            names = ", ".join(runtime.name for runtime in [chromium, *others])
            print(f"bits in {names}")
            print(HEADING, flush=True)
        for model in with_progress(options.models or [*MODELS], "pages"):
            rows.append(measure(model, chromium, others, options))
            if not options.json:
                print(line(rows[-1]), flush=True)
    finally:
        for runtime in others:
            runtime.close()
        chromium.close()
    if options.json:
        print(json.dumps({"rows": rows, "verdicts": verdicts(rows)}))
    else:
        print("\n" + "\n".join(verdicts(rows)))


if __name__ == "__main__":
    main()
