"""`flockscope live check`: is a laboratory ready? It looks, and sends nothing."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.live.options import LinkName, SourceName
from app.cli.outcome import as_json
from app.cli.refusals import refuse
from app.cli.rule_option import Rules
from worlds.refusal import Refusal

if TYPE_CHECKING:
    from app.live.laboratory.lab import Lab
    from app.live.links.link import CarLink
    from app.live.sources.source import Source

WATCHED = 1.0
"""Seconds for which frames are counted."""


def check(
    file: Annotated[Path, typer.Argument(help="The laboratory's file, LAB.toml.")],
    source: SourceName = None,
    link: LinkName = None,
    within: Annotated[float, typer.Option(help="Seconds that the first frame may take.")] = 10.0,
    devices: Annotated[
        bool, typer.Option("--devices/--file-only", help="Open the source and the link too.")
    ] = True,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    rule: Rules = None,  # noqa: ARG001 - taken into the catalogue before this is called
    quiet: Annotated[bool, typer.Option("--quiet", help="Only what is amiss.")] = False,
) -> None:
    """Check a laboratory: its file, its rule, who is seen, whether the link is fast enough.

    Sends nothing to the cars. Exit code 2, and one line, if anything is amiss.
    """
    from app.live.operating.choices import laboratory
    from app.live.operating.flock_driver import FlockDriver

    if not 0.0 < within <= 600.0:
        raise Refusal(f"--within {within:g} s is outside (0, 600]")
    choices = laboratory(file, source, link)
    lab = choices.lab
    driver = FlockDriver(lab)
    found: dict[str, Any] = {
        "file": str(file),
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
    if json_asked:
        typer.echo(as_json(found))
    elif not quiet:
        typer.echo("\n".join(lines(found)))
    if found["amiss"]:
        refuse("; ".join(found["amiss"]))


def look_at_devices(lab: Lab, within: float, found: dict[str, Any]) -> None:
    """Open the source and the link."""
    from app.live.operating.ends import source_and_link

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
    from app.live.sources.feed import Feed

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
    for body, name in lab.bodies.items():
        if body not in seen:
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
