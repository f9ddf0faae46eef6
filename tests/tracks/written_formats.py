"""A small written file of every format of tracks, in the structure that its program gives it.

All hold the same walk: `PLACES` (T, N, 2) in metres or in the unit of the format, y up.
"""

from __future__ import annotations

import json
import pickle
import sqlite3
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.live.recordings import write_trial

FRAMES, COUNT, RATE = 12, 3, 25.0
_along = np.arange(FRAMES)[:, None]
PLACES = np.stack(
    [1.0 + 0.1 * _along + np.arange(COUNT), 2.0 + 0.05 * _along * (1 + np.arange(COUNT))], axis=2
)
"""(T, N, 2); individual 1 is not seen in frames 4 and 5."""
PLACES[4:6, 1] = np.nan
SEEN = np.isfinite(PLACES[..., 0])


@dataclass(frozen=True)
class WrittenFormat:
    """How the walk is written in a format, and what reading it takes and gives."""

    name: str
    file: str
    """Of the file, or of a folder if it has no dot."""
    write: Callable[[Path], None]
    options: dict[str, Any] = field(default_factory=dict)
    """What the file does not say."""
    unit: str = "m"
    scale: float = 1.0
    """The file's unit in PLACES' unit."""
    ids: tuple[str, ...] = ("1", "2", "3")
    dim: int = 2
    rate: float = RATE
    keeps_gap: bool = True
    y_down: bool = False
    tolerance: float = 1e-6

    def written(self, folder: Path) -> Path:
        """The file, written in a folder."""
        path = folder / self.file
        if "." not in self.file:
            path.mkdir()
        self.write(path)
        return path


def names() -> list[str]:
    """The names of the individuals."""
    return [str(n + 1) for n in range(COUNT)]


def rows_of_walk() -> list[tuple[int, int, float, float]]:
    """Frame, individual from 0, x, y of all that are seen, frame by frame."""
    return [(t, n, *PLACES[t, n]) for t in range(FRAMES) for n in range(COUNT) if SEEN[t, n]]


def lines(path: Path, *texts: str) -> None:
    """Write a text of lines."""
    path.write_text("\n".join(texts) + "\n", encoding="utf-8")


def down(places: np.ndarray) -> np.ndarray:
    """The same with y pointing down."""
    return places * [1.0, -1.0]


# idtracker.ai.


def attributes() -> dict[str, Any]:
    return {
        "frames_per_second": 25,
        "body_length": np.array(58.0),
        "length_unit": None,
        "video_path": "/home/somebody/Videos/fish.avi",
        "version": "6.0",
        "areas": {"mean": np.ones(COUNT), "median": np.ones(COUNT), "std": np.ones(COUNT)},
        "setup_points": {},
    }


def write_npy(path: Path) -> None:
    held = attributes() | {
        "trajectories": down(PLACES),
        "id_probabilities": np.full((FRAMES, COUNT, 1), 0.9),
    }
    np.save(path, held, allow_pickle=True)


def write_bare_npy(path: Path) -> None:
    np.save(path, down(PLACES))


def write_idtracker_h5(path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        file.create_dataset("trajectories", data=down(PLACES), compression="gzip")
        file.create_dataset("id_probabilities", data=np.full((FRAMES, COUNT, 1), 0.9))
        file.create_group("areas").create_dataset("mean", data=np.ones(COUNT))
        file.attrs.update(
            frames_per_second=25, body_length=58.0, length_unit=-1,
            video_path="/home/somebody/Videos/fish.avi",
        )  # fmt: skip


def tidy_rows() -> list[tuple[int, float, int, Any, Any, float]]:
    places = down(PLACES)
    return [(t, t / RATE, n, *places[t, n], 0.9) for t in range(FRAMES) for n in range(COUNT)]


def write_tidy_csv(path: Path) -> None:
    rows = [",".join("" if v != v else f"{v:.9g}" for v in row) for row in tidy_rows()]
    lines(path, "frame,time,individual,x,y,probability", *rows)
    told = {"frames_per_second": 25, "video_path": "/home/somebody/Videos/fish.avi"}
    (path.parent / "attributes_tidy.json").write_text(json.dumps(told))


def write_wide_csv(path: Path) -> None:
    names = ",".join(f"x{n + 1},y{n + 1}" for n in range(COUNT))
    rows = [
        ",".join([f"{t / RATE:.3f}", *(f"{v:.3f}" for v in down(PLACES[t]).ravel())])
        for t in range(FRAMES)
    ]
    lines(path, f"time,{names}", *rows)


def write_idtracker_parquet(path: Path) -> None:
    pa, pq = pytest.importorskip("pyarrow"), pytest.importorskip("pyarrow.parquet")
    names = ("frame", "time", "individual", "x", "y", "probability")
    columns = dict(zip(names, map(list, zip(*tidy_rows(), strict=True)), strict=True))
    table = pa.table(columns)
    told = json.dumps({"frames_per_second": 25, "version": "6.0"})
    pq.write_table(table.replace_schema_metadata({"idtrackerai_attributes": told}), path)


# SLEAP, DeepLabCut, movement, TRex.


def write_sleap(path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    nodes = np.stack([down(PLACES), down(PLACES) + 7.0], axis=2)  # (T, N, node, 2)
    with h5py.File(path, "w") as file:
        file["tracks"] = nodes.transpose(1, 3, 2, 0)
        file["node_names"] = np.array([b"thorax", b"head"])
        file["track_names"] = np.array([name.encode() for name in names()])
        file["point_scores"] = np.full((COUNT, 2, FRAMES), 0.8)
        file["track_occupancy"] = SEEN


def write_deeplabcut(path: Path) -> None:
    owners = [f"{n + 1}" for n in range(COUNT) for _ in range(6)]
    parts = [part for _ in range(COUNT) for part in ("snout",) * 3 + ("tail",) * 3]
    coords = ["x", "y", "likelihood"] * (2 * COUNT)
    rows = []
    for t in range(FRAMES):
        cells = [str(t)]
        for n in range(COUNT):
            sure = 0.95 if SEEN[t, n] else 0.1  # it is never blank: it guesses
            x, y = down(PLACES[t, n]) if SEEN[t, n] else (99.0, 99.0)
            cells += [f"{x:.9g}", f"{y:.9g}", f"{sure}", "5", "6", "0.9"]
        rows.append(",".join(cells))
    lines(
        path,
        ",".join(["scorer", *["DLC_resnet50"] * len(owners)]),
        ",".join(["individuals", *owners]),
        ",".join(["bodyparts", *parts]),
        ",".join(["coords", *coords]),
        *rows,
    )


def write_movement(path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        file["time"] = np.arange(FRAMES) / RATE
        file["space"] = np.array(["x", "y"], dtype=h5py.string_dtype())
        file["keypoints"] = np.array(["centroid"], dtype=h5py.string_dtype())
        file["individuals"] = np.array(names(), dtype=h5py.string_dtype())
        for name in ("time", "space", "keypoints", "individuals"):
            file[name].make_scale(name)
        places = down(PLACES).transpose(0, 2, 1)[:, :, None, :]  # time, space, keypoint, individual
        for name, array, axes in (
            ("position", places, ("time", "space", "keypoints", "individuals")),
            ("confidence", np.full((FRAMES, 1, COUNT), 0.9), ("time", "keypoints", "individuals")),
        ):
            file[name] = array
            for k, axis in enumerate(axes):
                file[name].dims[k].attach_scale(file[axis])
        file.attrs.update(fps=RATE, time_unit="seconds", source_software="SLEAP", ds_type="poses")


def write_trex(folder: Path) -> None:
    for n in range(COUNT):
        held = np.arange(n, FRAMES)  # files begin at different frames
        x, y = (np.where(SEEN[held, n], down(PLACES)[held, n, k], np.inf) for k in (0, 1))
        arrays = {
            "frame": held.astype(float), "time": held / RATE, "X#wcentroid": x, "Y#wcentroid": y,
            "X": x + 3.0, "Y": y, "missing": (~SEEN[held, n]).astype(float),
            "ANGLE": np.zeros(len(held)),
        }  # fmt: skip
        np.savez(folder / f"group_fish{n + 1}.npz", **arrays)


def write_trex_csv(folder: Path) -> None:
    for n in range(COUNT):
        rows = [
            f"{t},{t / RATE:.4f},{x:.9g},{y:.9g},{int(not SEEN[t, n])}"
            for t, (x, y) in enumerate(np.where(SEEN[:, n, None], down(PLACES)[:, n], np.inf))
        ]
        lines(folder / f"id{n + 1}.csv",
              "frame,time,X#wcentroid (cm),Y#wcentroid (cm),missing", *rows)  # fmt: skip


# GPS.

METRES = 1e-5 * 111_194.9
"""How far apart two fixes of the walk are, about: 1e-5 degrees a metre of PLACES."""


def fixes(n: int) -> list[tuple[str, float, float]]:
    return [
        (
            str(np.datetime64("2015-04-27T06:00:00") + np.timedelta64(t, "s")).replace("T", " "),
            10.0 + 1e-5 * PLACES[t, n, 0],
            47.0 + 1e-5 * PLACES[t, n, 1],
        )
        for t in range(FRAMES)
        if SEEN[t, n]
    ]


def write_movebank(path: Path) -> None:
    rows = [
        f'{k},true,{when}.000,{east:.9f},{north:.9f},"gps","{n + 1}","A study"'
        for n in range(COUNT)
        for k, (when, east, north) in enumerate(fixes(n))
    ]
    rows += ['90,false,2015-04-27 06:00:03.000,55.0,5.0,"gps","1","A study"',
             '91,true,2015-04-27 06:00:03.500,,,"gps","1","A study"']  # fmt: skip
    lines(path, "event-id,visible,timestamp,location-long,location-lat,sensor-type,"
                "individual-local-identifier,study-name", *rows)  # fmt: skip


def write_gps(folder: Path) -> None:
    for n in range(COUNT):
        rows = [
            ",".join([*when.split(), f"{e:.9f}", f"{north:.9f}"]) for when, e, north in fixes(n)
        ]
        if n == 0:  # what was seen in one such file
            rows += [rows[-1], "2015-04-27,25:00:01,10.0,47.0", "2015-04-27,06:00:09,NA,NA"]
        lines(folder / f"goat_{n + 1}.csv", "date,time,lon,lat", *rows)


# Crowds.


def write_petrack(path: Path) -> None:
    rows = [f"{n + 1} {t} {100 * x:.6f} {100 * y:.6f} 176" for t, n, x, y in
            sorted(rows_of_walk(), key=lambda row: (row[1], row[0]))]  # fmt: skip
    lines(
        path,
        "# PeTrack project: walk.pet",
        "# framerate: 25 fps",
        "# z: can be 3d position or height of person",
        "# id frame x/cm y/cm z/cm",
        *rows,
    )


def write_plain_crowd(path: Path) -> None:
    rows = [f"{n + 1}\t{t}\t{x:.6f}\t{y:.6f}\t1.76" for t, n, x, y in
            sorted(rows_of_walk(), key=lambda row: (row[1], row[0]))]  # fmt: skip
    lines(path, *rows)


def write_obsmat(path: Path) -> None:
    rows = [
        f"   {10 * t:.7e}   {n + 1:.7e}   {x:.7e}   0.0000000e+00   {y:.7e}   {0.1 * RATE / 10:.7e}"
        f"   0.0000000e+00   {0.05 * (1 + n) * RATE / 10:.7e}"
        for t, n, x, y in rows_of_walk()
    ]
    lines(path, *rows)


def write_pedpy(path: Path) -> None:
    rows = [f"{n + 1},{t},{x:.9f},{y:.9f},0.1,0.2" for t, n, x, y in rows_of_walk()]
    lines(path, "ID,Frame,x,y,v_x,v_y", *rows)


def write_citr(folder: Path) -> None:
    for n in range(COUNT):
        rows = [f"{t},{n + 1},{x:.9f},{-y:.9f},ped" for t, m, x, y in rows_of_walk() if m == n]
        lines(folder / f"p{n + 1}.csv", "frame,id,x,y,type", *rows)
    lines(folder / "ratio_pixel2meter_ground.txt", "45.763")


def write_jupedsim(version: int) -> Callable[[Path], None]:
    def write(path: Path) -> None:
        database = sqlite3.connect(path)
        database.execute("CREATE TABLE trajectory_data (frame INTEGER NOT NULL, id INTEGER NOT "
                         "NULL, pos_x REAL NOT NULL, pos_y REAL NOT NULL, ori_x REAL NOT NULL, "
                         "ori_y REAL NOT NULL)")  # fmt: skip
        database.execute("CREATE TABLE metadata (key TEXT NOT NULL UNIQUE, value TEXT NOT NULL)")
        rows = [(t, n + 1, x, y, 0.0 if n == 0 else 1.0, 0.0) for t, n, x, y in rows_of_walk()]
        database.executemany("INSERT INTO trajectory_data VALUES (?,?,?,?,?,?)", rows)
        database.executemany("INSERT INTO metadata VALUES (?,?)",
                             [("version", str(version)), ("fps", "25.0")])  # fmt: skip
        area = "POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0))"
        if version == 1:
            database.execute("CREATE TABLE geometry (wkt TEXT NOT NULL)")
            database.execute("INSERT INTO geometry VALUES (?)", (area,))
        else:
            database.execute("CREATE TABLE geometry (hash INTEGER NOT NULL, wkt TEXT NOT NULL)")
            database.execute("INSERT INTO geometry VALUES (?,?)", (7, area))
            database.execute("CREATE TABLE frame_data (frame INTEGER, geometry_hash INTEGER)")
        database.commit()
        database.close()

    return write


def write_archive(path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    kind = [("id", "i8"), ("frame", "i8"), ("x", "f8"), ("y", "f8"), ("z", "f8")]
    rows = np.array([(n + 1, t, x, y, 1.76) for t, n, x, y in rows_of_walk()], kind)
    with h5py.File(path, "w") as file:
        file["trajectory"] = rows
        file["trajectory"].attrs.update(fps=25.0, x="x-coordinate in meter")
        file.attrs.update(file_version="1.0.0",
                          wkt_geometry="POLYGON ((0 0, 10 0, 10 10, 0 10, 0 0))")  # fmt: skip


def write_pathfinder(path: Path) -> None:
    rows = [f'{t / RATE:.6f},{n + 1},"Anna Person",{int(SEEN[t, n])},{x:.9f},{y:.9f},0.02,0,0,'
            '"Room07","level",0'
            for t in range(FRAMES) for n in range(COUNT)
            for x, y in [PLACES[t, n] if SEEN[t, n] else (0.0, 0.0)]]  # fmt: skip
    lines(
        path,
        '"t","id","name","active","x","y","z","v","distance","location","terrain type",'
        '"last_goal_started"',
        '"s","","","","m","m","m","m/s","m","","",""',
        *rows,
    )


def write_pathfinder_json(path: Path) -> None:
    told: dict[str, dict[str, Any]] = {}
    for t in range(FRAMES):
        for n in range(COUNT):
            x, y = PLACES[t, n] if SEEN[t, n] else (0.0, 0.0)
            told.setdefault(str(n + 1), {})[f"{t / RATE}"] = {
                "name": "Anna Person",
                "isActive": bool(SEEN[t, n]),
                "position": {"x": x, "y": y, "z": 0.0},
            }
    path.write_text(json.dumps(told, indent=2))


def write_viswalk(path: Path) -> None:
    rows = [f"{n + 1};{t / RATE:.2f};{x:.6f};{y:.6f};" for t, n, x, y in rows_of_walk()]
    lines(path, "$VISION", "* File: walk.inpx", "* PTV Vissim",
          "$PEDESTRIAN:NO;SIMSEC;COORDCENTX;COORDCENTY;", *rows)  # fmt: skip


def write_crowdit(path: Path) -> None:
    rows = [f"{t / RATE:.2f},{n + 1},{x:.6f},{y:.6f}" for t, n, x, y in rows_of_walk()]
    lines(path, "time,pedID,posX,posY", *rows)


def write_vadere(path: Path) -> None:
    rows = []
    for n in range(COUNT):
        for t in range(FRAMES - 1):
            x, y = PLACES[t, n] if SEEN[t, n] else (1.0 + 0.1 * t + n, 2.0 + 0.05 * t * (1 + n))
            rows.append(
                f"{n + 1} {t / RATE!r} {(t + 1) / RATE!r} {x:.9f} {y:.9f} {x + 0.1:.9f} {y:.9f} 8"
            )
    lines(path, "#IDXCOL=2,DATACOL=6,SEP=' '",
          "pedestrianId simTime endTime-PID1 startX-PID1 startY-PID1 endX-PID1 endY-PID1 "
          "targetId-PID2", *rows)  # fmt: skip


# Rooms: z up, a metre above the floor.


def in_space() -> np.ndarray:
    return np.concatenate([PLACES, np.where(SEEN, 1.0, np.nan)[..., None]], axis=2)


def cells(values: Any, form: str = "{:.6f}") -> str:
    return ",".join("" if v != v else form.format(v) for v in np.ravel(values))


def write_c3d(path: Path) -> None:
    write_trial(path, names(), 1000.0 * in_space().transpose(2, 1, 0), rate=RATE)


def write_motive(path: Path) -> None:
    places = in_space()[..., [0, 2, 1]] * [1.0, 1.0, -1.0]  # y up, as Motive has it
    bodies = [name for n in names() for name in [n] * 8]
    rows = []
    for t in range(FRAMES):
        row = [f"{t},{t / RATE:.6f}"]
        for n in range(COUNT):
            turn = (0.0, 0.0, 0.0, 1.0) if SEEN[t, n] else (np.nan,) * 4
            row.append(cells([*turn, *(1000.0 * places[t, n]), 0.1]))
        rows.append(",".join(row))
    lines(
        path,
        "Format Version,1.23,Take Name,walk,Take Notes,,Capture Frame Rate,25.000000,Export Frame "
        "Rate,25.000000,Rotation Type,Quaternion,Length Units,Millimeters,Coordinate Space,Global",
        "",
        ",".join([",Type", *["Rigid Body"] * len(bodies)]),
        ",".join([",Name", *bodies]),
        ",".join([",ID", *["7B"] * len(bodies)]),
        ",".join([",", *(["Rotation"] * 4 + ["Position"] * 3 + ["Mean Marker Error"]) * COUNT]),
        ",".join(["Frame,Time (Seconds)", *(["X", "Y", "Z", "W", "X", "Y", "Z", ""] * COUNT)]),
        *rows,
    )


def write_nexus(path: Path) -> None:
    rows = [f"{t},0,{cells(1000.0 * in_space()[t])}" for t in range(FRAMES)]
    lines(
        path,
        "Trajectories",
        "25",
        ",," + ",,,".join(names()) + ",,",
        "Frame,Sub Frame," + ",".join(["X,Y,Z"] * COUNT),
        ",," + ",".join(["mm"] * (3 * COUNT)),
        *rows,
    )


def write_tracker(path: Path) -> None:
    rows = [
        ",".join([f"{t},0", *(cells([0, 0, 0.5, *(1000.0 * in_space()[t, n])] if SEEN[t, n]
                                    else [np.nan] * 6) for n in range(COUNT))])
        for t in range(FRAMES)
    ]  # fmt: skip
    lines(path, "Objects", "25", ",," + ",,,,,,".join(f"{n}:{n}" for n in names()) + ",,,,,",
          "Frame,Sub Frame," + ",".join(["RX,RY,RZ,TX,TY,TZ"] * COUNT),
          ",," + ",".join(["rad,rad,rad,mm,mm,mm"] * COUNT), *rows)  # fmt: skip


def write_trc(path: Path) -> None:
    rows = [
        "\t".join([str(t + 1), f"{t / RATE:.6f}", *cells(1000.0 * in_space()[t]).split(",")])
        for t in range(FRAMES)
    ]
    lines(
        path,
        "PathFileType\t4\t(X/Y/Z)\twalk.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t"
        "OrigNumFrames",
        f"25.00\t25.00\t{FRAMES}\t{COUNT}\tmm\t25.00\t1\t{FRAMES}",
        "Frame#\tTime\t" + "\t\t\t".join(names()) + "\t\t",
        "\t\t" + "\t".join(f"X{n}\tY{n}\tZ{n}" for n in names()),
        *rows,
    )


def write_qtm(path: Path) -> None:
    rows = ["\t".join(cells(1000.0 * in_space()[t]).split(",")) for t in range(FRAMES)]
    lines(
        path,
        f"NO_OF_FRAMES\t{FRAMES}",
        "NO_OF_CAMERAS\t8",
        f"NO_OF_MARKERS\t{COUNT}",
        "FREQUENCY\t25",
        "NO_OF_ANALOG\t0",
        "ANALOG_FREQUENCY\t0",
        "DESCRIPTION\t--",
        "TIME_STAMP\t2024-04-15, 10:39:38.777\t406646.66",
        "DATA_INCLUDED\t3D",
        "\t".join(["MARKER_NAMES", *names()]),
        "\t".join(["TRAJECTORY_TYPES", *["Measured"] * COUNT]),
        *rows,
    )


def write_rosbag(folder: Path) -> None:
    for n in range(COUNT):
        rows = [
            f"{t * 40_000_000 + 10**18},{t},{t * 40_000_000 + 10**18},map,"
            f"{cells(in_space()[t, n])},0,0,0,1"
            for t in range(FRAMES)
            if SEEN[t, n]
        ]
        lines(folder / f"{n + 1}.csv", "%time,field.header.seq,field.header.stamp,"
              "field.header.frame_id,"
              + ",".join(f"field.pose.position.{a}" for a in "xyz") + ","
              + ",".join(f"field.pose.orientation.{a}" for a in "xyzw"), *rows)  # fmt: skip


def write_tum(folder: Path) -> None:
    for n in range(COUNT):
        rows = [f"{1.5e9 + t / RATE:.6f} {cells(in_space()[t, n]).replace(',', ' ')} 0 0 0 1"
                for t in range(FRAMES) if SEEN[t, n]]  # fmt: skip
        lines(folder / f"{n + 1}.txt", "# timestamp tx ty tz qx qy qz qw", *rows)


# Ours.


def write_plain(path: Path) -> None:
    rows = [f"{n + 1};{t};{x:.9f};{y:.9f}" for t, n, x, y in reversed(rows_of_walk())]
    lines(path, "who;when;px;py", *rows)  # frames fall, which is no matter


def write_recording(path: Path) -> None:
    from agents.flock import Flock
    from agents.recordings.recorder import Recorder

    flock = Flock("vem", agents=COUNT, size=5.0, rng=1)
    with Recorder(path, flock) as recorder:
        for _ in range(FRAMES):
            recorder.write()
            flock.step()


PLAIN_COLUMNS = {"frame": "when", "id": "who", "x": "px", "y": "py"}
PIXELS: dict[str, Any] = {"unit": "px", "y_down": True}
SPACE: dict[str, Any] = {"dim": 3, "options": {"up": "z"}}
FORMATS = (
    WrittenFormat("idtracker-npy", "fish.npy", write_npy, **PIXELS),
    WrittenFormat("idtracker-npy", "bare.npy", write_bare_npy,
                  {"rate": RATE, "unit": "px", "origin": "top-left"}, **PIXELS),
    WrittenFormat("idtracker-h5", "fish.h5", write_idtracker_h5, **PIXELS),
    WrittenFormat("idtracker-tidy", "trajectories.csv", write_tidy_csv, **PIXELS),
    WrittenFormat("idtracker-wide", "wide.csv", write_wide_csv, tolerance=1e-3, **PIXELS),
    WrittenFormat("idtracker-parquet", "fish.parquet", write_idtracker_parquet, **PIXELS),
    WrittenFormat("sleap", "mice.analysis.h5", write_sleap,
                  {"rate": RATE, "node": "thorax"}, **PIXELS),
    WrittenFormat("deeplabcut", "miceDLC.csv", write_deeplabcut,
                  {"rate": RATE, "node": "snout"}, **PIXELS),
    WrittenFormat("movement", "mice.nc", write_movement, **PIXELS),
    WrittenFormat("trex", "trex", write_trex, unit="cm", y_down=True),
    WrittenFormat("trex", "trexcsv", write_trex_csv, unit="cm", y_down=True),
    WrittenFormat("movebank", "storks.csv", write_movebank, rate=1.0, tolerance=np.inf),
    WrittenFormat("gps", "goats", write_gps, rate=1.0, tolerance=np.inf),
    WrittenFormat("petrack", "walk.txt", write_petrack, unit="cm", scale=100.0, tolerance=1e-4),
    WrittenFormat("petrack", "bare.txt", write_plain_crowd, {"rate": RATE, "unit": "m"}),
    WrittenFormat("obsmat", "obsmat.txt", write_obsmat, {"rate": RATE}, rate=2.5),
    WrittenFormat("pedpy", "file.csv", write_pedpy, {"rate": RATE}),
    WrittenFormat("citr", "citr", write_citr, {"rate": RATE, "origin": "top-left"}),
    WrittenFormat("jupedsim", "v1.sqlite", write_jupedsim(1)),
    WrittenFormat("jupedsim", "v2.sqlite", write_jupedsim(2)),
    WrittenFormat("pedestrian-archive", "archive.h5", write_archive),
    WrittenFormat("pathfinder", "pathfinder.csv", write_pathfinder),
    WrittenFormat("pathfinder-json", "pathfinder.json", write_pathfinder_json),
    WrittenFormat("viswalk", "walk.pp", write_viswalk),
    WrittenFormat("crowdit", "crowdit.csv", write_crowdit),
    WrittenFormat("vadere", "postvis.traj", write_vadere, {"rate": RATE}, keeps_gap=False),
    WrittenFormat("c3d", "walk.c3d", write_c3d, unit="mm", scale=1000.0, tolerance=1e-2, **SPACE),
    WrittenFormat("motive", "take.csv", write_motive, {"up": "y"}, "mm", 1000.0, dim=3,
                  tolerance=1e-5),
    WrittenFormat("nexus", "nexus.csv", write_nexus, unit="mm", scale=1000.0, tolerance=1e-5,
                  **SPACE),
    WrittenFormat("tracker", "tracker.csv", write_tracker, unit="mm", scale=1000.0,
                  tolerance=1e-5, **SPACE),
    WrittenFormat("trc", "walk.trc", write_trc, unit="mm", scale=1000.0, tolerance=1e-5, **SPACE),
    WrittenFormat("qtm", "walk.tsv", write_qtm, unit="mm", scale=1000.0, tolerance=1e-5, **SPACE),
    WrittenFormat("rosbag", "bags", write_rosbag, **SPACE),
    WrittenFormat("tum", "tum", write_tum, **SPACE),
    WrittenFormat("table", "plain.csv", write_plain,
                  {"rate": RATE, "unit": "m", "origin": "bottom-left", "columns": PLAIN_COLUMNS}),
)  # fmt: skip
"""Every format; a recording of ours apart, which does not hold the walk."""


def hostile_pickle(value: object) -> bytes:
    """The bytes of a .npy file that holds a pickle of any value."""
    import io

    file = io.BytesIO()
    array = np.empty((), object)
    np.lib.format.write_array_header_1_0(file, np.lib.format.header_data_from_array_1_0(array))
    return file.getvalue() + pickle.dumps(value, protocol=2)
