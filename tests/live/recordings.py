"""Recordings for the tests: a small table of poses, and trials in C3D."""

import numpy as np
import pytest

HEADER = "t,frame,name,x,y,z,qx,qy,qz,qw,valid"
ROWS = [
    "0.00,10,car1,1.0,2.0,0.05,0,0,0,1,1",
    "0.00,10,car2,3.0,4.0,0.05,0,0,0.7071067811865476,0.7071067811865476,true",
    "0.01,11,car1,1.1,2.0,0.05,0,0,0,1,1",
    "0.01,11,car2,,,,,,,,0",
    "0.04,14,car2,3.2,4.0,0.05,0,0,1,0,1",
]


def csv_of(folder, rows, header=HEADER):
    path = folder / "trial.csv"
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def write_trial(path, labels=(), points=None, matrices=None, names=(), units="mm", rate=100.0):
    """A C3D file with markers (3, M, F) and rotations (4, 4, B, F)."""
    ezc3d = pytest.importorskip("ezc3d")
    trial = ezc3d.c3d()
    frames = points.shape[2] if points is not None else matrices.shape[3]
    trial["parameters"]["POINT"]["RATE"]["value"] = [rate]
    trial["parameters"]["POINT"]["UNITS"]["value"] = [units]
    trial["parameters"]["POINT"]["LABELS"]["value"] = tuple(labels)
    if points is not None:
        trial["data"]["points"] = np.concatenate([points, np.ones((1, len(labels), frames))])
    if matrices is not None:
        trial.add_parameter("ROTATION", "LABELS", list(names))
        trial.add_parameter("ROTATION", "RATE", [rate])
        trial["data"]["rotations"] = matrices
    trial.write(str(path))
