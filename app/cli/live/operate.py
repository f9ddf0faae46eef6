"""The terminal of `flockscope live run`: keys in, events and one line of state out."""

from __future__ import annotations

import os
import select
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import typer

from app.cli.terminal.console import rewrite_line
from app.cli.terminal.outcome_table import as_json
from app.cli.terminal.progress import StopSignals
from app.live.control.arm import Action, OperatorRequest
from app.live.control.loop_status import Event, Status
from app.live.links.link import EMERGENCY, RUN
from app.live.operating.operator import Operator
from worlds.input_error import InputError
from worlds.number_text import counted


class Keys:
    """While entered, `read_keys` gives the keys; where there is no terminal there are none."""

    def __init__(self) -> None:
        self.before: Any = None
        self.fileno = -1

    @property
    def is_terminal(self) -> bool:
        """Whether keys can come."""
        return self.fileno >= 0

    def __enter__(self) -> Keys:
        try:
            import termios
            import tty

            fileno = sys.stdin.fileno()
            if os.isatty(fileno) and os.tcgetpgrp(fileno) == os.getpgrp():
                self.before = termios.tcgetattr(fileno)
                tty.setcbreak(fileno)
                self.fileno = fileno
        except (ImportError, OSError, ValueError):
            self.fileno = -1
        return self

    def __exit__(self, *_: object) -> None:
        if self.is_terminal:
            import termios

            termios.tcsetattr(self.fileno, termios.TCSADRAIN, self.before)
            self.fileno = -1

    def read_keys(self, within: float) -> str:
        """The keys pressed, "" if there are none within so many seconds."""
        if not self.is_terminal:
            time.sleep(within)
            return ""
        if not select.select([self.fileno], [], [], within)[0]:
            return ""
        data = os.read(self.fileno, 64)
        if not data:  # the terminal is gone
            self.fileno = -1
        return data.decode(errors="replace")


KEYS: dict[str, Action] = {"a": "arm", "d": "disarm", "r": "reset"}
"""Every other key but q is the emergency stop."""
LEAVES = "q"
HELP = "a arms, space or any other key: EMERGENCY STOP, r resets it, d disarms, q leaves"
EVERY = 0.05
"""Seconds between two looks at keys and status."""
SILENCE = 1.0
"""Seconds without a new status after which the loop is said not to answer."""


def actions_of(pressed: str) -> list[Action]:
    """What the keys ask for; an emergency stop among them is done alone.

    >>> actions_of("ra"), actions_of("ra ")
    (['reset', 'arm'], ['emergency'])
    """
    actions: list[Action] = [KEYS.get(key, "emergency") for key in pressed]
    return ["emergency"] if "emergency" in actions else actions


def handle_keys_until_over(
    obey: Callable[[str], None],
    refresh: Callable[[], None],
    over: Callable[[], bool],
    verbose: bool,
) -> None:
    """Pass on the keys and refresh what is shown, until q is pressed or it is over."""
    with Keys() as keys:
        if verbose and keys.is_terminal:
            typer.echo(HELP, err=True)
        while not over():
            pressed = keys.read_keys(EVERY)
            if LEAVES in pressed:
                break
            obey(pressed)
            refresh()


def event_line(event: Event, at: float) -> str:
    """An event, `at` so many seconds, as a line for people."""
    cause = f" ({event.cause})" if event.cause else ""
    return f"{at:8.2f} s  {event.kind:<9} {event.words}{cause}"


class OperatorConsole:
    """The terminal as an operator: keys in, events and one line of state out.

    `seconds`: how long, 0 is for ever. `arms`: arm once, as soon as nothing speaks against it.
    `verbose`: events and state are shown.
    """

    def __init__(
        self,
        operator: Operator,
        stopping: StopSignals,
        seconds: float,
        arms: bool,
        json_asked: bool,
        verbose: bool,
    ):
        self.operator = operator
        self.stopping = stopping
        self.seconds = seconds
        self.arms = arms
        self.json_asked = json_asked
        self.verbose = verbose
        self.shown = 0
        self.began = time.monotonic()
        self.last: Status | None = None
        self.heard = self.began
        """When the last status of the loop came."""
        self.silent = False
        """Whether the terminal has said that the loop does not answer."""
        self.wide = 0

    def operate(self) -> None:
        """Until q, Ctrl-C, SIGTERM or the time is up. Raises InputError if the loop ends by
        itself."""
        handle_keys_until_over(self.handle_key, self.print_news, self.is_over, self.verbose)
        if self.verbose and self.wide:
            typer.echo("", err=True)

    def is_over(self) -> bool:
        """Whether somebody has asked to stop, or the time is up."""
        return self.stopping.asked or 0.0 < self.seconds <= time.monotonic() - self.began

    def handle_key(self, pressed: str) -> None:
        """Ask the loop for what was typed."""
        for action in actions_of(pressed):
            self.operator.ask(OperatorRequest(action, "terminal"))

    def print_news(self) -> None:
        """Show what is new of the loop. Raises InputError if it is gone."""
        status = self.operator.status()
        if self.operator.trouble:
            raise InputError(self.operator.trouble)
        self.shown, new = self.operator.events.since(self.shown)
        for event in new:
            self.show(event)
        if status is None or status is self.last:
            self.check_silence()
            return
        self.last, self.heard, self.silent = status, time.monotonic(), False
        if self.arms and status.arm == "safe" and not status.reasons:
            self.arms = False
            self.operator.ask(OperatorRequest("arm", "--arm"))
        if self.verbose and not self.json_asked and sys.stderr.isatty():
            self.wide = rewrite_status(state_line(status), self.wide)

    def check_silence(self) -> None:
        """Say so, once, if the loop has sent no status for too long."""
        if self.silent or self.last is None or time.monotonic() - self.heard < SILENCE:
            return
        self.silent = True
        if self.verbose:
            self.wide = rewrite_status("", self.wide) if self.wide else 0
            typer.echo("the control loop does not answer: the cars stop themselves", err=True)

    def show(self, event: Event) -> None:
        """Print an event."""
        if not self.verbose:
            return
        if self.wide:
            self.wide = rewrite_status("", self.wide)
        at = event.time - self.began
        if self.json_asked:
            typer.echo(as_json(asdict(event) | {"seconds": at}))
        else:
            typer.echo(event_line(event, at))

    def summary(self) -> dict[str, Any]:
        """What there is to say in the end; times in s."""
        result: dict[str, Any] = {
            "seconds": time.monotonic() - self.began,
            "events": len(self.operator.events),
        }
        if self.last is not None:
            result |= {
                "ticks": self.last.tick + 1,
                "missed": self.last.missed,
                "period": asdict(self.last.period),
                "latency": asdict(self.last.latency),
            }
        return result


def rewrite_status(line: str, wide: int) -> int:
    """Write over the line before, which was so wide; how wide this one is."""
    rewrite_line(line.ljust(wide))
    if not line:
        rewrite_line("")
    return len(line)


def state_line(status: Status) -> str:
    """The laboratory in a line."""
    state = {RUN: "RUN", EMERGENCY: "EMERGENCY STOP"}.get(status.mode, "stop")
    cars = ", ".join(
        f"{car.name} {car.state}" + (f" {1000 * car.age:.0f} ms" if car.age < 10.0 else "")
        for car in status.cars
    )
    times = (
        f"loop {1000 * status.period.median:.1f} ms, latency {1000 * status.latency.median:.1f} ms"
    )
    why = status.reasons[0].words if status.reasons else ""
    if any(reason.kind == "moves" for reason in status.reasons):  # it comes first, and is read
        return f"!!! {why} !!! {status.arm} {state} | {cars} | {times}"[:200]
    return f"{status.arm} {state} | {cars} | {times}{' | ' if why else ''}{why}"[:200]


def format_summary(summary: dict[str, Any]) -> str:
    """The summary for people."""
    line = f"{summary['seconds']:.1f} s, {counted(summary['events'], 'event')}"
    if "ticks" in summary:
        line += (
            f", {counted(summary['ticks'], 'tick')} of {1000 * summary['period']['median']:.2f} ms"
            f" (one in a hundred {1000 * summary['period']['late']:.2f} ms or more),"
            f" {summary['missed']} left out"
        )
    if "recording" in summary:
        line += f"; recorded in {summary['recording']}"
    return line
