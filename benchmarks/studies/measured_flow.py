"""The flow of people through a line, from a file of tracks: (N - 1) / (t_N - t_1).

Each person counts once, in the first frame at which it is beyond the line y = LINE, having been
above it. The file is one of PeTrack: rows `id frame x y [z]` in metres, a comment `# framerate: 25
fps`. That of `experiments/adrian2020-bottleneck.toml`, 040_c_56_h-.txt of
doi:10.34735/ped.2018.1, gives 1.1548 people per second at --line -1.1.

uv run python benchmarks/studies/measured_flow.py FILE [--line -1.1]
"""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import numpy as np


def crossing_frames(rows: np.ndarray, line: float) -> np.ndarray:
    """The frames (N,), in order, at which people come below y = `line`; rows (M, 4 or more)."""
    rows = rows[np.lexsort((rows[:, 1], rows[:, 0]))]
    identity, frame, _, y = rows[:, :4].T
    crosses = (identity[1:] == identity[:-1]) & (y[:-1] > line) & (y[1:] <= line)
    people, first = np.unique(identity[1:][crosses], return_index=True)
    assert len(people) == len(first)
    return np.sort(frame[1:][crosses][first])


def mean_flow(frames: np.ndarray, rate: float) -> float:
    """(N - 1) / (t_N - t_1) of N >= 2 passages at frames (N,), at `rate` frames per second."""
    return (len(frames) - 1) * rate / (frames[-1] - frames[0])


def main() -> None:
    """Print the flow of a file."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("--line", type=float, default=-1.1, help="y of the line, m")
    asked = parser.parse_args()
    rate = re.search(r"#\s*framerate:\s*([\d.]+)", asked.file.read_text())
    if rate is None:
        parser.error(f"{asked.file} has no comment `# framerate:`")
    frames = crossing_frames(np.loadtxt(asked.file), asked.line)
    if len(frames) < 2:
        parser.error(f"{len(frames)} people cross y = {asked.line:g} m in {asked.file}")
    fps = float(rate.group(1))
    print(
        f"{len(frames)} people, from {frames[0] / fps:g} s to {frames[-1] / fps:g} s: "
        f"{mean_flow(frames, fps):.4f} people per second"
    )


if __name__ == "__main__":
    main()
