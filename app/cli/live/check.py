"""`flockscope live check`: is a laboratory ready, is a recording sound? It sends nothing."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.live.live_options import LinkName, SourceName
from app.cli.terminal.console import refuse
from app.cli.terminal.outcome_table import as_json
from app.cli.terminal.usage import PrintJson, Rules
from worlds.input_error import InputError

if TYPE_CHECKING:
    from app.live.control.plausibility import BodyReport, Swap
    from app.live.laboratory.lab_file import Lab
    from app.live.links.link import CarLink
    from app.live.sources.pose_source import RecordedFrame, Source
    from app.live.sources.recorded_source import RecordedSource

# `flockscope live check RECORDING`: may cars be driven by what tracked these bodies?

KIND = "recorded:"
SUFFIXES = (".csv", ".parquet", ".c3d")


def is_recording_path(text: str) -> bool:
    """Whether an argument names a recording, and not a laboratory's file.

    >>> [is_recording_path(text) for text in ("lab.toml", "poses.csv?up=y", "recorded:trial.c3d")]
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
    from app.live.sources.recorded_source import recording_of
    from app.live.sources.source_address import parse_address

    if speed is not None and not 0.0 < speed <= 10.0:
        raise InputError(f"--speed {speed:g} m/s is outside (0, 10]")
    if Path(text).is_dir():
        return check_live_run(Path(text), speed)
    recorded = recording_of(parse_address(text if text.startswith(KIND) else KIND + text))
    frames = recorded.recording()
    reports, swaps = recorded.judge(frames, speed or CarLimits().speed)
    return summary(text, frames, reports, swaps, recorded)


def check_live_run(folder: Path, speed: float | None) -> dict[str, Any]:
    """What there is to say of the poses that a live run recorded; they hold yaw alone."""
    from app.live.control.plausibility import judge_bodies
    from app.live.control.safety_limits import CarLimits
    from app.live.recording.recording_replay import read
    from app.live.sources.pose_source import RecordedFrame, tracks_of

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


def recording_lines(findings: dict[str, Any]) -> list[str]:
    """What was found, for people; the last line is the verdict, if nothing is amiss."""
    lines = [f"{findings['recording']}: {findings['frames']} frames, {findings['seconds']:.2f} s"]
    for name, body in findings["bodies"].items():
        lines.append(f"  {name!r}: tracked in {body['frames']} frames")
        vertical, yaw, worst = body["vertical"], body["yaw"], body["worst_jump"]
        if vertical is None:
            lines.append("    vertical axis: not in this recording, which holds yaw alone")
        else:
            lines.append(
                f"    vertical axis: {vertical['axis']}, {vertical['tilt']:.1f} degrees from up; "
                f"upright in {100 * vertical['upright']:.0f} % of its frames"
            )
        lines.append(
            "    yaw: not judged, it moves too little"
            if yaw is None
            else f"    yaw: {yaw['difference']:z.1f} degrees from the direction of motion in the "
            f"mean; agrees in {100 * yaw['forwards']:.0f} % of its way, backwards in "
            f"{100 * yaw['backwards']:.0f} %"
        )
        lines.append(
            "    jumps: none"
            if worst is None
            else f"    jumps: {body['jumps']}, the furthest {worst['distance']:.2f} m in frame "
            f"{worst['number']}"
        )
    swaps = [
        f"{swap['one']!r} and {swap['other']!r} in frame {swap['number']}"
        for swap in findings["swaps"]
    ]
    lines.append(f"  changed places: {'; '.join(swaps[:5]) or 'none'}")
    if not findings["amiss"]:
        open_points = ", ".join(map(repr, findings["not_judged"]))
        but = f", but yaw is not judged of {open_points}" if open_points else ""
        lines.append(f"  nothing speaks against driving by this tracking{but}")
    return lines


WATCHED = 1.0
"""Seconds for which frames are counted."""


def check(
    file: Annotated[
        str,
        typer.Argument(
            help="The laboratory's file, LAB.toml; or a recording of tracking: a table of poses, a "
            "C3D file, with options as in poses.csv?up=y, or the folder of a live run."
        ),
    ],
    source: SourceName = None,
    link: LinkName = None,
    within: Annotated[float, typer.Option(help="Seconds that the first frame may take.")] = 10.0,
    devices: Annotated[
        bool, typer.Option("--devices/--file-only", help="Open the source and the link too.")
    ] = True,
    speed: Annotated[
        float | None, typer.Option(help="Top speed of the cars of a recording, m/s.")
    ] = None,
    json_asked: PrintJson = False,
    rule: Rules = None,  # noqa: ARG001 - taken into the catalogue before this is called
    quiet: Annotated[bool, typer.Option("--quiet", help="Only what is amiss.")] = False,
) -> None:
    """Check a laboratory or a recording.

    Of a laboratory: its file, its rule, who is seen, whether the link is fast enough. Of a
    recording: which axis of each body points up, whether yaw agrees with the direction of motion,
    jumps that no car can make, bodies that change places. Sends nothing to the cars. Exit code 2,
    and one line, if anything is amiss.
    """
    if is_recording_path(file):
        if source is not None or link is not None or not devices:
            raise InputError("--source, --link and --file-only are for a laboratory's file")
        findings = check_recording(file, speed)
        report(findings, recording_lines, json_asked, quiet)
        return
    if speed is not None:
        raise InputError(
            "--speed is for a recording: a laboratory's file has the speed of each car"
        )
    from app.live.operating.flock_driver import FlockDriver
    from app.live.operating.lab_choices import laboratory

    if not 0.0 < within <= 600.0:
        raise InputError(f"--within {within:g} s is outside (0, 600]")
    choices = laboratory(Path(file), source, link)
    lab = choices.lab
    driver = FlockDriver(lab)
    findings = {
        "file": file,
        "title": lab.title,
        "rule": driver.model.name,
        "cars": {name: car.address for name, car in lab.cars.items()},
        "choices": {
            "sources": choices.sources,
            "links": choices.links,
            "rules": choices.rules,
        },
        "amiss": [],
    }
    if devices:
        look_at_devices(lab, within, findings)
    report(findings, lines, json_asked, quiet)


def report(
    findings: dict[str, Any],
    describe: Callable[[dict[str, Any]], list[str]],
    json_asked: bool,
    quiet: bool,
) -> None:
    """Print what was found; end with exit code 2, and one line, if anything is amiss."""
    if json_asked:
        typer.echo(as_json(findings))
    elif not quiet:
        typer.echo("\n".join(describe(findings)))
    if findings["amiss"]:
        refuse("; ".join(findings["amiss"]))


def look_at_devices(lab: Lab, within: float, findings: dict[str, Any]) -> None:
    """Open the source and the link."""
    from app.live.operating.loop_process import source_and_link

    poses, commands = source_and_link(lab)
    look_at_link(lab, commands, findings)
    look_at_source(lab, poses, within, findings)


def look_at_link(lab: Lab, link: CarLink, findings: dict[str, Any]) -> None:
    """Send nothing through an open link, work out whether it can carry the commands, close it."""
    from app.live.links.link import shortage

    short = shortage(link, len(lab.cars), lab.rate)
    link.close()
    findings["link"] = {"text": lab.link, "shortage": short}
    if short:
        findings["amiss"].append(short)


def look_at_source(lab: Lab, source: Source, within: float, findings: dict[str, Any]) -> None:
    """Watch the tracking for a second: its rate, and which bodies it sees."""
    from app.live.control.plausibility import judge_bodies
    from app.live.sources.feed import Feed
    from app.live.sources.pose_source import RecordedFrame, tracks_of

    with Feed(source, within) as feed:
        first = feed.first(within)
        time.sleep(WATCHED)
        frames = feed.since(first.number)
        last_seen = feed.last_seen()
    bodies: dict[str, dict[str, Any]] = {
        name: {
            "called": lab.bodies.get(name, ""),
            "x": at.pose.x,
            "y": at.pose.y,
            "yaw": at.pose.yaw,
        }
        for name, at in sorted(last_seen.items())
    }
    findings["source"] = {
        "text": lab.source,
        "what": source.describe(),
        "rate": len(frames) / WATCHED,
        "bodies": bodies,
    }
    cars = {body: lab.cars[name] for body, name in lab.bodies.items() if name in lab.cars}
    tracks = tracks_of(
        RecordedFrame(frame.received, frame.number, frame.sightings) for frame in frames
    )
    followed = [track for track in tracks if track.name in cars]
    fastest = {body: car.fastest for body, car in cars.items()}
    reports, swaps = judge_bodies(followed, "", fastest, lab.limits.leap)
    for body, report_of_body in reports.items():
        findings["amiss"] += [f"{lab.bodies[body]}: {fault}" for fault in report_of_body.faults]
    findings["amiss"] += [f"{lab.bodies[a]} and {lab.bodies[b]} change places" for _, a, b in swaps]
    why = {
        sighting.name: sighting.why
        for frame in frames
        for sighting in frame.sightings
        if sighting.why
    }
    for body, name in lab.bodies.items():
        if body in why:
            findings["amiss"].append(f"{name} is not tracked: {why[body]}")
        elif body not in last_seen:
            body_names = ", ".join(map(repr, sorted(last_seen))) or "nobody"
            findings["amiss"].append(f"{name} is not seen: no body {body!r}, only {body_names}")
        elif (
            name in lab.cars
            and lab.area.distance_inside(bodies[body]["x"], bodies[body]["y"]) <= 0.0
        ):
            findings["amiss"].append(f"{name} is not within the fence")


def lines(findings: dict[str, Any]) -> list[str]:
    """What was found, for people."""
    cars = ", ".join(f"{name} at address {address}" for name, address in findings["cars"].items())
    lines = [f"{findings['title'] or findings['file']}: {findings['rule']}", f"  cars: {cars}"]
    if "link" in findings:
        lines.append(f"  link: {findings['link']['text']} opens")
    if "source" in findings:
        source = findings["source"]
        lines.append(f"  source: {source['what']}, {source['rate']:.0f} frames per second")
        for body, at in source["bodies"].items():
            called = f"is {at['called']}" if at["called"] else "is none of ours"
            where = f"x {at['x']:.3f} m, y {at['y']:.3f} m, yaw {at['yaw']:.3f} rad"
            lines.append(f"    {body!r} {called}: {where}")
    lines.append("  may be chosen:")
    for kind, names in findings["choices"].items():
        lines.append(f"    {kind}: {', '.join(names)}")
    return lines
