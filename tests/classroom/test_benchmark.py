"""What a result costs is printed."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_the_benchmark_prints_the_time_of_a_result():
    command = [sys.executable, str(ROOT / "benchmarks" / "pages" / "collect.py"), "--students", "3"]
    said = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT).stdout
    assert len(re.findall(r"\d ms a result", said)) == 2
    assert re.search(r"the class's file: saved in \d+ ms, opened in \d+ ms", said)


def test_the_benchmark_of_a_class_prints_what_students_get():
    command = [
        sys.executable,
        str(ROOT / "benchmarks" / "pages" / "classroom.py"),
        "--students",
        "2",
    ]
    few = ("--seconds", "8", "--idle", "1")
    said = subprocess.run([*command, *few], check=True, capture_output=True, text=True).stdout
    assert "2 students, flocks of 300 agents" in said
    assert float(re.search(r"pictures/s +(\S+)", said)[1]) > 1.0
    assert re.search(r"a button answers +\d+\.\d\d s", said)
    assert re.search(r"nobody looks, cores each +\d", said)


def test_the_benchmark_of_an_attack_prints_how_long_the_honest_wait():
    command = [
        sys.executable,
        str(ROOT / "benchmarks" / "pages" / "class_attack.py"),
        "--honest",
        "2",
    ]
    few = ("--dishonest", "1", "--seconds", "6")
    said = subprocess.run([*command, *few], check=True, capture_output=True, text=True).stdout
    assert "2 honest, 1 dishonest and one slow student" in said
    assert re.search(r"before +\d+ results waited for +\S+ s", said)
    assert re.search(r"attacked +\d+ results waited for +\S+ s", said)
    assert re.search(r"honest without a result +0\n", said)
    assert re.search(r"not kept +0\n", said)


def test_the_benchmark_of_flocks_in_browsers_prints_what_each_part_takes():
    command = [sys.executable, str(ROOT / "benchmarks" / "pages" / "classroom.py")]
    few = ("--in-browser", "--students", "3", "--over", "1")
    said = subprocess.run([*command, *few], check=True, capture_output=True, text=True).stdout
    assert "3 students, flocks of 300 agents in their browsers" in said
    for part in ("all come", "a question is asked", "all hand in", "nothing happens"):
        took = r"cores \d+\.\d\d \(the front \d+\.\d\d\), sent \d+\.\d MB"
        assert re.search(rf"{part} .*{took}", said)
    assert re.search(r"results +3\n", said)
    assert float(re.search(r"memory, MB +(\d+)", said)[1]) > 0
