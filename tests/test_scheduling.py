"""Tests with appointments to keep run one at a time when all others have ended; cars one by one."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

pytest_plugins = ["pytester"]
CONFTEST = Path(__file__).with_name("conftest.py")
TEST = """
import time
from pathlib import Path

LOG = Path({log!r})

def note(word):
    with LOG.open("a") as file:
        file.write(f"{{word}} {{time.monotonic()}}\\n")
"""
CASE = """
def test_{name}():
    note("{kind}")
    time.sleep({seconds})
    note("{kind}-end")
"""
FILES = {
    "browser/test_page": 2,
    "live/test_car": 2,
    "live/test_link": 1,
    "experiments/test_cluster": 1,
    "test_rules": 3,
    "test_models": 1,
    "viewer/test_dials": 2,
}
"""File -> its tests."""
KINDS = {"browser": "serial", "experiments": "serial", "live": "live"}


@pytest.mark.parametrize("processes", [0, 1, 2, 3])
def test_what_is_serial_runs_alone_and_last_and_what_is_live_one_by_one(processes, pytester):
    folder = pytester.path / "tests"
    log = pytester.path / "log"
    for file, count in FILES.items():
        kind = KINDS.get(file.partition("/")[0], "other")
        path = folder / f"{file}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        name = file.replace("/", "_")
        cases = [CASE.format(name=f"{name}_{at}", kind=kind, seconds=0.05) for at in range(count)]
        path.write_text(TEST.format(log=str(log)) + "".join(cases))
    shutil.copy(CONFTEST, folder)
    pytester.runpytest_subprocess("-p", "no:cacheprovider", "--dist=loadfile",
                                  "--no-loadscope-reorder", f"-n{processes}", "tests"
                                  ).assert_outcomes(passed=sum(FILES.values()))  # fmt: skip
    noted = [line.split() for line in log.read_text().splitlines()]
    words = [word for word, _ in sorted(noted, key=lambda note: float(note[1]))]
    assert words.count("other") == 6
    assert words[-6:] == ["serial", "serial-end"] * 3
    assert [word for word in words if "live" in word] == ["live", "live-end"] * 3
