"""The terminal of a laboratory: keys in, events and one line of state out."""

from __future__ import annotations

import sys
import time
from dataclasses import asdict
from typing import Any

import typer

from app.cli.live.keys import Keys
from app.cli.outcome import as_json
from app.cli.stopping import Stopping
from app.live.control.arm import Request, Wish
from app.live.control.events import Event
from app.live.control.look import Look
from app.live.links.link import EMERGENCY, RUN
from app.live.operating.desk import Desk
from worlds.counting import counted
from worlds.refusal import Refusal

KEYS: dict[str, Wish] = {"a": "arm", "d": "disarm", "r": "reset"}
"""Every other key but q is the emergency stop."""
LEAVES = "q"
HELP = "a arms, space or any other key: EMERGENCY STOP, r resets it, d disarms, q leaves"
EVERY = 0.05
"""Seconds between two looks."""
SILENCE = 1.0
"""Seconds without a new look after which the loop is said not to answer."""


class Terminal:
    """Operates a desk until the operator leaves; `seconds` 0 is for ever.

    `arms`: arm once, as soon as nothing speaks against it. `said`: events and state are shown.
    """

    def __init__(
        self,
        desk: Desk,
        stopping: Stopping,
        seconds: float,
        arms: bool,
        json_asked: bool,
        said: bool,
    ):
        self.desk = desk
        self.stopping = stopping
        self.seconds = seconds
        self.arms = arms
        self.json_asked = json_asked
        self.said = said
        self.shown = 0
        self.began = time.monotonic()
        self.last: Look | None = None
        self.heard = self.began
        """When the loop was last heard of."""
        self.silent = False
        """Whether it was said that it is not."""
        self.wide = 0

    def operate(self) -> None:
        """Until q, Ctrl-C, SIGTERM or the time is up. Raises Refusal if the loop ends by itself."""
        with Keys() as keys:
            if self.said and keys.there:
                typer.echo(HELP, err=True)
            while not self.stopping.asked and not self.over():
                pressed = keys.pressed(EVERY)
                if LEAVES in pressed:
                    break
                self.obey(pressed)
                self.see()
        if self.said and self.wide:
            typer.echo("", err=True)

    def over(self) -> bool:
        """Whether the time is up."""
        return 0.0 < self.seconds <= time.monotonic() - self.began

    def obey(self, pressed: str) -> None:
        """Do what was typed; among several keys an emergency stop goes first."""
        wishes: list[Wish] = [KEYS.get(key, "emergency") for key in pressed]
        if "emergency" in wishes:
            wishes = ["emergency"]
        for wish in wishes:
            self.desk.ask(Request(wish, "terminal"))

    def see(self) -> None:
        """Look at the loop, show what is new. Raises Refusal if it is gone."""
        look = self.desk.look()
        if self.desk.trouble:
            raise Refusal(self.desk.trouble)
        self.shown, new = self.desk.events.since(self.shown)
        for event in new:
            self.tell(event)
        if look is None or look is self.last:
            self.listen()
            return
        self.last, self.heard, self.silent = look, time.monotonic(), False
        if self.arms and look.arm == "safe" and not look.reasons:
            self.arms = False
            self.desk.ask(Request("arm", "--arm"))
        if self.said and not self.json_asked and sys.stderr.isatty():
            self.wide = rewritten(state_line(look), self.wide)

    def listen(self) -> None:
        """Say so, once, if the loop has not been heard of for too long."""
        if self.silent or self.last is None or time.monotonic() - self.heard < SILENCE:
            return
        self.silent = True
        if self.said:
            self.wide = rewritten("", self.wide) if self.wide else 0
            typer.echo("the control loop does not answer: the cars stop themselves", err=True)

    def tell(self, event: Event) -> None:
        """Print an event."""
        if not self.said:
            return
        if self.wide:
            self.wide = rewritten("", self.wide)
        at = event.time - self.began
        if self.json_asked:
            typer.echo(as_json(asdict(event) | {"seconds": at}))
        else:
            cause = f" ({event.cause})" if event.cause else ""
            typer.echo(f"{at:8.2f} s  {event.kind:<9} {event.words}{cause}")

    def summary(self) -> dict[str, Any]:
        """What there is to say in the end; times in s."""
        made: dict[str, Any] = {
            "seconds": time.monotonic() - self.began,
            "events": len(self.desk.events),
        }
        if self.last is not None:
            made |= {
                "ticks": self.last.tick + 1,
                "missed": self.last.missed,
                "period": asdict(self.last.period),
                "latency": asdict(self.last.latency),
            }
        return made


def rewritten(line: str, wide: int) -> int:
    """Write over the line before, which was so wide; how wide this one is."""
    typer.echo("\r" + line.ljust(wide) + ("" if line else "\r"), nl=False, err=True)
    return len(line)


def state_line(look: Look) -> str:
    """The laboratory in a line."""
    state = {RUN: "RUN", EMERGENCY: "EMERGENCY STOP"}.get(look.mode, "stop")
    cars = ", ".join(
        f"{car.name} {car.state}" + (f" {1000 * car.age:.0f} ms" if car.age < 10.0 else "")
        for car in look.cars
    )
    times = f"loop {1000 * look.period.median:.1f} ms, latency {1000 * look.latency.median:.1f} ms"
    why = f" | {look.reasons[0].words}" if look.reasons else ""
    return f"{look.arm} {state} | {cars} | {times}{why}"[:200]


def closing(made: dict[str, Any]) -> str:
    """The summary for people."""
    line = f"{made['seconds']:.1f} s, {counted(made['events'], 'event')}"
    if "ticks" in made:
        line += (
            f", {counted(made['ticks'], 'tick')} of {1000 * made['period']['median']:.2f} ms"
            f" (one in a hundred {1000 * made['period']['late']:.2f} ms or more),"
            f" {made['missed']} left out"
        )
    if "recording" in made:
        line += f"; recorded in {made['recording']}"
    return line
