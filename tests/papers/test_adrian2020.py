"""Adrian et al. 2020 in small: a crowd before a bottleneck, and the flow that tracks give."""

import subprocess
import sys
from pathlib import Path

import pytest

from papers.flying import flown, values

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "studies" / "measured_flow.py"


def test_the_walls_of_1995_let_nobody_through_and_nearer_ones_do(tmp_path):
    _, made = flown("adrian2020-bottleneck", tmp_path, 2, limit=60.0)
    out = {label: numbers for (label, _), numbers in values(made, "out").items()}
    flow = {label: numbers for (label, _), numbers in values(made, "flow").items()}
    assert set(out["as published"]) == {0}
    assert set(flow["as published"]) == {0.0}
    assert min(out["walls felt at half"]) >= 20
    assert min(out["walls felt at a quarter"]) >= 65
    assert all(1.0 < one < 2.0 for one in flow["walls felt at a quarter"])


def measured(tmp_path, text, *more):
    path = tmp_path / "tracks.txt"
    path.write_text(text)
    command = [sys.executable, str(SCRIPT), str(path), *more]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_the_measured_flow_counts_everybody_once(tmp_path):
    """Three cross y = 0 at frames 2, 4 and 8 of 10 a second, one of them twice: 2 / 0.6 s."""
    rows = [
        *[(1, 0, 0, 1.0), (1, 1, 0, 0.1), (1, 2, 0, -0.1), (1, 3, 0, 0.2), (1, 4, 0, -0.2)],
        *[(2, 3, 1, 0.5), (2, 4, 1, 0.0), (2, 5, 1, -1.0)],
        *[(3, 7, 1, 0.5), (3, 8, 1, -0.5)],
        *[(4, 0, 1, -0.5), (4, 1, 1, -0.6)],
        *[(5, 0, 1, 0.5), (5, 9, 1, 0.4)],
    ]
    text = "# framerate: 10 fps\n" + "".join("\t".join(map(str, row)) + "\n" for row in rows[::-1])
    done = measured(tmp_path, text, "--line", "0")
    assert done.stdout == "3 people, from 0.2 s to 0.8 s: 3.3333 people per second\n"


@pytest.mark.parametrize(
    "text", ["1 0 0 1\n1 1 0 -1\n", "# framerate: 10 fps\n1 0 0 1\n1 1 0 -1\n"]
)
def test_tracks_without_a_rate_or_with_fewer_than_two_people_have_no_flow(tmp_path, text):
    done = measured(tmp_path, text, "--line", "0")
    assert done.returncode == 2
    assert not done.stdout
