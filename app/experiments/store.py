"""The runs that are done, one line of a CSV file each; what is in it is not run again."""

from __future__ import annotations

import csv
import json
import os
from pathlib import Path
from typing import NamedTuple, TextIO

from app.experiments.experiment import Case
from app.experiments.kinds.settings import Measure
from app.experiments.trial import Result
from worlds.refusal import Refusal
from worlds.writing import demand_writable

KEYS = ("model", "agents", "parameters", "seed", "fingerprint")
"""The first columns of a store; those of the measures follow, then the last ones."""
LAST = ("seconds", "astray")


class Key(NamedTuple):
    """What makes a run."""

    model: str
    agents: int
    parameters: str
    seed: int
    fingerprint: str


def key_of(case: Case, seed: int, fingerprint: str) -> Key:
    """The key of a case's run."""
    parameters = json.dumps(case.spec.parameters, sort_keys=True, separators=(",", ":"))
    return Key(case.spec.model, case.agents, parameters, seed, fingerprint)


class Store:
    """A context manager over `runs.csv`; lines are on the disk as soon as they are added.

    Its columns are the key of a run, the measures of the experiment's kind, the seconds, and which
    agent was seen where it cannot be. A last line without its end, as a kill leaves it, is cut off;
    a store of before there was the last column gets it. Raises Refusal if the file is not such a
    store or cannot be written.
    """

    def __init__(self, path: Path, measures: tuple[Measure, ...]):
        self.path = path
        self.measures = measures
        self.columns = (*KEYS, *(one.name for one in measures), *LAST)
        self.results: dict[Key, Result] = {}
        self.file: TextIO | None = None

    def __enter__(self) -> Store:
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            demand_writable("store of runs", self.path, overwrite=True)
            self.demand_ours()
            self.mend()
            self.widen()
            self.read()
            self.file = open(self.path, "a", buffering=1, newline="", encoding="utf-8")
            if self.path.stat().st_size == 0:
                csv.writer(self.file, lineterminator="\n").writerow(self.columns)
        except OSError as error:
            raise self.refused(error) from None
        return self

    def __exit__(self, *_: object) -> None:
        if self.file is not None:
            self.file.close()

    def refused(self, error: OSError) -> Refusal:
        """The refusal for a file that cannot be read or written."""
        return Refusal(f"{str(self.path)!r} cannot be kept: {error.strerror or error}")

    def head(self, last: int | None = None) -> bytes:
        """The first line, with the columns up to `last`."""
        return (",".join(self.columns[:last]) + "\n").encode()

    def demand_ours(self) -> None:
        """Refuse a file of anything else before a byte of it is changed. Raises Refusal."""
        if self.path.exists():
            head, before = self.head(), self.head(last=-1)
            with open(self.path, "rb") as file:
                begins = file.read(len(head))
            if begins != head[: len(begins)] and not begins.startswith(before):
                raise Refusal(f"{str(self.path)!r} is not a store of runs: move it away")

    def mend(self) -> None:
        """Cut off a torn last line."""
        if self.path.exists():
            whole = self.path.read_bytes().rpartition(b"\n")
            if whole[2]:
                with open(self.path, "r+b") as file:
                    file.truncate(len(whole[0]) + len(whole[1]))

    def widen(self) -> None:
        """Give a store of before there was the last column an empty one."""
        if not self.path.exists():
            return
        head = self.head(last=-1)
        before = self.path.read_bytes()
        if before.startswith(head):
            made = self.path.with_name(self.path.name + ".tmp")
            made.write_bytes(self.head())
            with open(made, "ab") as file:
                file.writelines(line + b",\n" for line in before[len(head) :].splitlines())
            os.replace(made, self.path)

    def read(self) -> None:
        """Take what is in the file."""
        if not self.path.exists():
            return
        try:
            with open(self.path, newline="", encoding="utf-8") as file:
                lines = csv.reader(file)
                next(lines, None)
                for number, line in enumerate(lines, 2):
                    self.take(number, line)
        except (UnicodeDecodeError, csv.Error):
            raise Refusal(f"{str(self.path)!r} is not a store of runs: move it away") from None

    def take(self, number: int, line: list[str]) -> None:
        """Take one line. Raises Refusal naming it if it is no run."""
        try:
            model, agents, parameters, seed, fingerprint, *texts, seconds, astray = line
            key = Key(model, int(agents), parameters, int(seed), fingerprint)
            pairs = zip(self.measures, texts, strict=True)
            measures = {one.name: one.read(text) for one, text in pairs}
            self.results[key] = Result(measures, float(seconds), astray)
        except ValueError:
            raise Refusal(f"line {number} of {str(self.path)!r} is not a run: remove it") from None

    def add(self, key: Key, result: Result) -> None:
        """Keep a result. Raises Refusal if it cannot be written."""
        assert self.file is not None
        values = [result.measures[one.name] for one in self.measures]
        try:
            writer = csv.writer(self.file, lineterminator="\n")
            writer.writerow([*key, *values, f"{result.seconds:.6f}", result.astray])
        except OSError as error:
            raise self.refused(error) from None
        self.results[key] = result
