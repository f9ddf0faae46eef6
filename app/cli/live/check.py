"""`flockscope live check`: is a laboratory ready, is a recording sound? It sends nothing."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.error_messages import refuse
from app.cli.live import recording_check
from app.cli.live.live_options import LinkName, SourceName
from app.cli.outcome_table import as_json
from app.cli.rule_option import Rules
from worlds.input_error import InputError

if TYPE_CHECKING:
    from app.live.laboratory.lab_file import Lab
    from app.live.links.link import CarLink
    from app.live.sources.pose_source import Source

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
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    rule: Rules = None,  # noqa: ARG001 - taken into the catalogue before this is called
    quiet: Annotated[bool, typer.Option("--quiet", help="Only what is amiss.")] = False,
) -> None:
    """Check a laboratory or a recording.

    Of a laboratory: its file, its rule, who is seen, whether the link is fast enough. Of a
    recording: which axis of each body points up, whether yaw agrees with the direction of motion,
    jumps that no car can make, bodies that change places. Sends nothing to the cars. Exit code 2,
    and one line, if anything is amiss.
    """
    if recording_check.names_recording(file):
        if source is not None or link is not None or not devices:
            raise InputError("--source, --link and --file-only are for a laboratory's file")
        found = recording_check.check_recording(file, speed)
        report(found, recording_check.lines, json_asked, quiet)
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
    found = {
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
        look_at_devices(lab, within, found)
    report(found, lines, json_asked, quiet)


def report(
    found: dict[str, Any],
    describe: Callable[[dict[str, Any]], list[str]],
    json_asked: bool,
    quiet: bool,
) -> None:
    """Print what was found; end with exit code 2, and one line, if anything is amiss."""
    if json_asked:
        typer.echo(as_json(found))
    elif not quiet:
        typer.echo("\n".join(describe(found)))
    if found["amiss"]:
        refuse("; ".join(found["amiss"]))


def look_at_devices(lab: Lab, within: float, found: dict[str, Any]) -> None:
    """Open the source and the link."""
    from app.live.operating.loop_components import source_and_link

    poses, commands = source_and_link(lab)
    look_at_link(lab, commands, found)
    look_at_source(lab, poses, within, found)


def look_at_link(lab: Lab, link: CarLink, found: dict[str, Any]) -> None:
    """Send nothing through an open link, work out whether it can carry the commands, close it."""
    from app.live.links.link import shortage

    short = shortage(link, len(lab.cars), lab.rate)
    link.close()
    found["link"] = {"text": lab.link, "shortage": short}
    if short:
        found["amiss"].append(short)


def look_at_source(lab: Lab, source: Source, within: float, found: dict[str, Any]) -> None:
    """Watch the tracking for a second: its rate, and which bodies it sees."""
    from app.live.control.plausibility import judge_bodies
    from app.live.sources.feed import Feed
    from app.live.sources.recorded_frames import RecordedFrame, tracks_of

    with Feed(source, within) as feed:
        first = feed.first(within)
        time.sleep(WATCHED)
        frames = feed.since(first.number)
        seen = feed.last_seen()
    bodies: dict[str, dict[str, Any]] = {
        name: {
            "called": lab.bodies.get(name, ""),
            "x": at.pose.x,
            "y": at.pose.y,
            "yaw": at.pose.yaw,
        }
        for name, at in sorted(seen.items())
    }
    found["source"] = {
        "text": lab.source,
        "what": source.describe(),
        "rate": len(frames) / WATCHED,
        "bodies": bodies,
    }
    cars = {body: lab.cars[name] for body, name in lab.bodies.items() if name in lab.cars}
    tracks = tracks_of(RecordedFrame(one.received, one.number, one.sightings) for one in frames)
    followed = [track for track in tracks if track.name in cars]
    fastest = {body: car.fastest for body, car in cars.items()}
    reports, swaps = judge_bodies(followed, "", fastest, lab.limits.leap)
    for body, report_of_body in reports.items():
        found["amiss"] += [f"{lab.bodies[body]}: {fault}" for fault in report_of_body.faults]
    found["amiss"] += [f"{lab.bodies[a]} and {lab.bodies[b]} change places" for _, a, b in swaps]
    why = {one.name: one.why for frame in frames for one in frame.sightings if one.why}
    for body, name in lab.bodies.items():
        if body in why:
            found["amiss"].append(f"{name} is not tracked: {why[body]}")
        elif body not in seen:
            there = ", ".join(map(repr, sorted(seen))) or "nobody"
            found["amiss"].append(f"{name} is not seen: no body {body!r}, only {there}")
        elif name in lab.cars and lab.area.inside(bodies[body]["x"], bodies[body]["y"]) <= 0.0:
            found["amiss"].append(f"{name} is not within the fence")


def lines(found: dict[str, Any]) -> list[str]:
    """What was found, for people."""
    cars = ", ".join(f"{name} at address {address}" for name, address in found["cars"].items())
    made = [f"{found['title'] or found['file']}: {found['rule']}", f"  cars: {cars}"]
    if "link" in found:
        made.append(f"  link: {found['link']['text']} opens")
    if "source" in found:
        source = found["source"]
        made.append(f"  source: {source['what']}, {source['rate']:.0f} frames per second")
        for body, at in source["bodies"].items():
            called = f"is {at['called']}" if at["called"] else "is none of ours"
            where = f"x {at['x']:.3f} m, y {at['y']:.3f} m, yaw {at['yaw']:.3f} rad"
            made.append(f"    {body!r} {called}: {where}")
    made.append("  may be chosen:")
    for kind, names in found["choices"].items():
        made.append(f"    {kind}: {', '.join(names)}")
    return made
