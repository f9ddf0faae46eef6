"""What the store of a sweep costs: `python benchmarks/studies/sweep_store.py [--rows 100000]`.

Writes so many runs of 100 cells with two columns, reads them again, and asks for the status as
`flockscope sweep status` does. Prints processor time, and bytes on disk.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from itertools import pairwise
from pathlib import Path

from app.studies.runs.database import FILE, Outcome
from app.studies.runs.store import Store
from app.studies.runs.store_reader import StoreReader

CELLS = 100
COLUMNS = ("k", "x")


def main() -> None:
    """Print what writing, reading and the status take."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--rows", type=int, default=100_000, help="runs")
    rows = arguments.parse_args().rows
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        marks = [time.process_time()]
        with Store(folder, COLUMNS) as store:
            cells = store.store_plan([(str(number), "{}") for number in range(CELLS)])
            for row in range(rows):
                seed = row // CELLS
                measures = {"k": seed, "x": 0.1 * seed}
                store.add(cells[row % CELLS], seed, Outcome("ok", measures, "", 0.01, 100))
        marks.append(time.process_time())
        count = len(StoreReader(folder).runs(COLUMNS))
        marks.append(time.process_time())
        counted = StoreReader(folder).counts["ok"]
        marks.append(time.process_time())
        size = (folder / FILE).stat().st_size
    write, load, status = (after - before for before, after in pairwise(marks))
    print(f"{count} runs written in {write:.2f} s, loaded in {load:.2f} s")
    print(f"{counted} of them counted for the status in {status:.3f} s")
    print(f"{size / rows:.0f} bytes a run")


if __name__ == "__main__":
    main()
