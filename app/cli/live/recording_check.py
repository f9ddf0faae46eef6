"""`flockscope live check RECORDING`: may cars be driven by what tracked these bodies?"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from worlds.input_error import InputError

if TYPE_CHECKING:
    from app.live.control.plausibility import BodyReport, Swap
    from app.live.sources.recorded_frames import RecordedFrame
    from app.live.sources.recorded_source import RecordedSource

KIND = "recorded:"
SUFFIXES = (".csv", ".parquet", ".c3d")


def names_recording(text: str) -> bool:
    """Whether an argument names a recording, and not a laboratory's file.

    >>> [names_recording(text) for text in ("lab.toml", "poses.csv?up=y", "recorded:trial.c3d")]
    [False, True, True]
    """
    path = Path(text.removeprefix(KIND).partition("?")[0])
    return text.startswith(KIND) or path.suffix.lower() in SUFFIXES or path.is_dir()


def check_recording(text: str, speed: float | None) -> dict[str, Any]:
    """What there is to say of a recording: a table, a trial, or the folder of a live run.

    `speed` is the top speed of its cars, m/s; None: what the recorded laboratory says, or 1 m/s.
    Raises InputError if it cannot be read.
    """
    from app.live.control.safety_limits import CarLimits
    from app.live.sources.recorded_source import named
    from app.live.sources.source_address import parsed

    if speed is not None and not 0.0 < speed <= 10.0:
        raise InputError(f"--speed {speed:g} m/s is outside (0, 10]")
    if Path(text).is_dir():
        return check_live_run(Path(text), speed)
    recorded = named(parsed(text if text.startswith(KIND) else KIND + text))
    frames = recorded.recording()
    reports, swaps = recorded.judge(frames, speed or CarLimits().speed)
    return summary(text, frames, reports, swaps, recorded)


def check_live_run(folder: Path, speed: float | None) -> dict[str, Any]:
    """What there is to say of the poses that a live run recorded; they hold yaw alone."""
    from app.live.control.plausibility import judge_bodies
    from app.live.control.safety_limits import CarLimits
    from app.live.recording.recording_replay import read
    from app.live.sources.recorded_frames import RecordedFrame, tracks_of

    recorded = read(folder)
    frames: list[RecordedFrame] = []
    for tick in recorded.ticks():
        for frame in tick.frames:
            last = frames[-1] if frames else None
            number = max(frame.number, last.number + 1) if last else frame.number
            time = max(frame.received, last.time) if last else frame.received
            frames.append(RecordedFrame(time, number, frame.sightings))
    if not frames:
        raise InputError(f"{folder} has no frames of tracking")
    lab = recorded.lab
    tracks = tracks_of(frames)
    fastest = {track.name: speed or CarLimits().speed for track in tracks}
    if speed is None:
        fastest |= {
            body: lab.cars[name].fastest for body, name in lab.bodies.items() if name in lab.cars
        }
    return summary(str(folder), frames, *judge_bodies(tracks, "", fastest, lab.limits.leap), None)


def summary(
    text: str,
    frames: list[RecordedFrame],
    reports: dict[str, BodyReport],
    swaps: list[Swap],
    recorded: RecordedSource | None,
) -> dict[str, Any]:
    """The reports as values for JSON; `recorded` is asked for a cure of what is misread."""
    amiss = [f"{name}: {fault}" for name, report in reports.items() for fault in report.faults]
    if swaps:
        first = swaps[0]
        times = "once" if len(swaps) == 1 else f"{len(swaps)} times"
        amiss.append(
            f"bodies change places {times}, first {first.one!r} and {first.other!r} in frame "
            f"{first.number}"
        )
    misread = {name for name, report in reports.items() if report.misread}
    cure = recorded.find_cure(misread) if recorded is not None and misread else ""
    return {
        "recording": text,
        "frames": len(frames),
        "seconds": frames[-1].time - frames[0].time,
        "bodies": {name: body_values(report) for name, report in reports.items()},
        "swaps": [swap._asdict() for swap in swaps],
        "not_judged": [name for name, report in reports.items() if report.yaw is None],
        "cure": cure,
        "amiss": amiss + ([f"the poses make sense with ?{cure}"] if cure else []),
    }


def body_values(report: BodyReport) -> dict[str, Any]:
    """A report on one body as values for JSON; angles in degrees, lengths in m."""
    worst = max(report.jumps, key=lambda jump: jump.distance, default=None)
    return {
        "frames": report.frames,
        "vertical": None if report.vertical is None else vars(report.vertical),
        "yaw": None if report.yaw is None else vars(report.yaw),
        "jumps": len(report.jumps),
        "worst_jump": None if worst is None else worst._asdict(),
        "faults": report.faults,
    }


def lines(found: dict[str, Any]) -> list[str]:
    """What was found, for people; the last line is the verdict, if nothing is amiss."""
    made = [f"{found['recording']}: {found['frames']} frames, {found['seconds']:.2f} s"]
    for name, body in found["bodies"].items():
        made.append(f"  {name!r}: tracked in {body['frames']} frames")
        vertical, yaw, worst = body["vertical"], body["yaw"], body["worst_jump"]
        if vertical is None:
            made.append("    vertical axis: not in this recording, which holds yaw alone")
        else:
            made.append(
                f"    vertical axis: {vertical['axis']}, {vertical['tilt']:.1f} degrees from up; "
                f"upright in {100 * vertical['upright']:.0f} % of its frames"
            )
        made.append(
            "    yaw: not judged, it moves too little"
            if yaw is None
            else f"    yaw: {yaw['difference']:z.1f} degrees from the direction of motion in the "
            f"mean; agrees in {100 * yaw['forwards']:.0f} % of its way, backwards in "
            f"{100 * yaw['backwards']:.0f} %"
        )
        made.append(
            "    jumps: none"
            if worst is None
            else f"    jumps: {body['jumps']}, the furthest {worst['distance']:.2f} m in frame "
            f"{worst['number']}"
        )
    swaps = [
        f"{one['one']!r} and {one['other']!r} in frame {one['number']}" for one in found["swaps"]
    ]
    made.append(f"  changed places: {'; '.join(swaps[:5]) or 'none'}")
    if not found["amiss"]:
        open_points = ", ".join(map(repr, found["not_judged"]))
        but = f", but yaw is not judged of {open_points}" if open_points else ""
        made.append(f"  nothing speaks against driving by this tracking{but}")
    return made
