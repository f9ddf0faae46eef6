"""Agents that a controller in another process steers, by a datagram of JSON each way and tick.

It is sent what the agents of a kind are and see, and answers what they do: see docs/steer.md. The
socket is connected, so that the system drops what anybody else sends. A controller that is late,
or answers what it may not, costs a few ticks their wait; then nobody waits for it until it answers
again, and ever more rarely if that comes to nothing.
"""

from __future__ import annotations

import ipaddress
import json
import math
import socket
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from agents.kinds import KindTable
from agents.motion.agent_view import AgentView, numbers_of_action, wishes_of_actions
from agents.motion.motion import Motion
from agents.motion.steered_motion import Pilot
from worlds.input_error import InputError, shorten, unknown

NEAREST = 6
"""Nearest agents that each sees."""
MOST_AGENTS = 64
"""Agents of a kind: more do not fit into a datagram."""
LONGEST = 16 * 1024
"""Bytes of an answer."""
MOST_READ = 32
"""Datagrams that are read for a tick: whoever sends more is not read to the end."""
MISSES = 3
"""Ticks one after the other without a right answer, after which nobody waits any more."""
RECENT = 10
"""An answer to one of so many ticks before shows that a controller is there again."""
RAREST = 256
"""Ticks at most from a wait that came to nothing to the next."""
MOST_TOLD = 10
"""Lines that are told of one controller."""
TIMEOUT, LONGEST_TIMEOUT = 0.05, 10.0
"""Seconds that a tick waits for an answer, as a rule and at most."""


class AnswerError(ValueError):
    """An answer that does not count; the text says why."""


@dataclass(frozen=True)
class ControllerAddress:
    """Which kind a controller steers, and where it listens."""

    kind: str
    host: str
    port: int
    timeout: float = TIMEOUT

    def __str__(self) -> str:
        return f"the controller of kind {self.kind} at {self.host}:{self.port}"


def read_address(text: str) -> ControllerAddress:
    """The controller of `KIND=HOST:PORT?timeout=0.1`. Raises InputError.

    >>> read_address("robot=127.0.0.1:9100?timeout=0.2").timeout
    0.2
    """
    kind, equals, rest = text.partition("=")
    place, _, query = rest.partition("?")
    host, colon, port = place.rpartition(":")
    is_number = port.isascii() and port.isdigit() and len(port) < 6
    if not (kind and equals and host and colon and is_number and 0 < int(port) < 65536):
        raise InputError(f"{text} is not KIND=HOST:PORT, as robot=127.0.0.1:9100 (--steer)")
    options = {"timeout": str(TIMEOUT), "network": "false"}
    for part in query.split("&") if query else ():
        name, _, value = part.partition("=")
        if name not in options:
            raise unknown("option", name, options, "--steer")
        options[name] = value
    try:
        timeout = float(options["timeout"])
    except ValueError:
        timeout = math.nan
    if not 0.0 < timeout <= LONGEST_TIMEOUT:
        raise InputError(
            f"timeout = {options['timeout']} is not allowed: seconds in (0, {LONGEST_TIMEOUT:g}] "
            "are needed (--steer)"
        )
    if options["network"] not in ("true", "false"):
        raise InputError(f"network = {options['network']} is not true or false (--steer)")
    try:
        found = socket.getaddrinfo(host.strip("[]"), int(port), type=socket.SOCK_DGRAM)
    except OSError as error:
        raise InputError(f"{host} cannot be found: {error.strerror} (--steer)") from None
    address = str(found[0][4][0])
    if options["network"] == "false" and not ipaddress.ip_address(address).is_loopback:
        raise InputError(
            f"{host} is another machine, which would be told all of kind {kind}: say "
            f"{kind}={place}?network=true if you mean it (--steer)"
        )
    return ControllerAddress(kind, address, int(port), timeout)


def demand_steered_kinds(addresses: Sequence[ControllerAddress], kinds: KindTable) -> None:
    """Raise InputError for controllers of kinds that none can steer."""
    for place, address in enumerate(addresses):
        kind = kinds.kind(address.kind)
        if not kind.steered:
            raise InputError(f"kind {kind.name} is not steered: give it steered=true (--steer)")
        if kind.agents > MOST_AGENTS:
            raise InputError(
                f"kind {kind.name} has {kind.agents} agents: a controller steers {MOST_AGENTS} at "
                "most (--steer)"
            )
        if address.kind in [other.kind for other in addresses[:place]]:
            raise InputError(f"kind {kind.name} has two controllers (--steer)")


class ControllerPilot(Pilot):
    """Asks a controller before each tick. `clock`, s, says how long a tick has waited."""

    is_active = True

    def __init__(
        self, address: ControllerAddress, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self.address, self.clock = address, clock
        family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
        self.socket = socket.socket(family, socket.SOCK_DGRAM)
        self.socket.connect((address.host, address.port))
        self.socket.setblocking(False)
        self.fault = ""
        """What is wrong while nobody waits for it; empty: it answers."""
        self.has_answered = False
        """Whether it has answered in this run."""
        self.misses = 0
        """Ticks one after the other without a right answer."""
        self.silence = ""
        """That the last of them has waited in vain, and why."""
        self.pause = 1
        """Ticks from a wait that comes to nothing to the next one, once nobody waits any more."""
        self.next_wait = 0
        """The first tick for which it may be waited for again."""
        self.told = 0
        self.waits = 0
        """Ticks that waited in vain."""

    def close(self) -> None:
        """Ask no more."""
        self.socket.close()

    def steer(self, flock: Motion) -> None:
        """Ask what the agents of the kind do in the coming tick, and write it."""
        if self.address.kind not in flock.kinds.names[1:] or not len(flock.arrays.wish):
            return
        rows = flock.rows_of(self.address.kind)[:MOST_AGENTS]
        if not len(rows):
            return
        is_heard, _ = self.read(flock, rows, 0.0, flock.tick - RECENT)  # what is left of before
        self.send(describe_agents(flock, self.address.kind, rows))
        is_waited = not self.fault or (is_heard is not None and flock.tick >= self.next_wait)
        actions, reason = self.read(
            flock, rows, self.address.timeout if is_waited else 0.0, flock.tick
        )
        if actions is not None:
            self.note_answer(flock)
        elif is_waited:
            self.note_miss(flock, reason)
        wishes = np.full((len(rows), flock.world.dim), np.nan)
        if actions is not None:
            wishes = wishes_of_actions(flock, rows, actions, 1.0)
        flock.steer_rows(rows, wishes)

    def send(self, message: dict[str, Any]) -> None:
        """Send a datagram; that nobody listens is noticed by its silence."""
        with suppress(OSError):
            self.socket.send(json.dumps(message, separators=(",", ":")).encode())

    def read(
        self, flock: Motion, rows: np.ndarray, timeout: float, since: int
    ) -> tuple[np.ndarray | None, str]:
        """The actions (M, A) of an answer to a tick from `since` on, nan for who follows its rule;
        None, and why, if there is none within `timeout` s."""
        reason = "no answer"
        end = self.clock() + timeout
        for _ in range(MOST_READ):
            left = end - self.clock()
            try:
                self.socket.settimeout(max(left, 0.0))
                data = self.socket.recv(LONGEST + 1)
            except (TimeoutError, BlockingIOError):
                break
            except OSError:  # nobody listens there
                reason = "nobody listens"
                if left <= 0.0:
                    break
                time.sleep(min(left, 1e-3))
                continue
            try:
                return read_answer(data, flock, rows, since), ""
            except AnswerError as error:
                reason = str(error)
        return None, reason

    def note_answer(self, flock: Motion) -> None:
        """It has answered."""
        if self.fault:
            self.tell(flock, f"{self.address} answers again at tick {flock.tick}")
        self.fault, self.misses, self.pause = "", 0, 1
        self.has_answered = True

    def note_miss(self, flock: Motion, reason: str) -> None:
        """A tick has waited in vain."""
        self.misses += 1
        self.waits += 1
        waited = f"within {self.address.timeout:g} s at tick {flock.tick}"
        self.silence = f"{self.address}: {reason} {waited}"
        if self.fault:
            self.pause = min(2 * self.pause, RAREST)
            self.next_wait = flock.tick + self.pause
        elif self.misses >= MISSES:
            self.fault = f"{self.silence}; its agents follow their rule until it answers"
            self.next_wait = flock.tick + self.pause
            self.tell(flock, self.fault)

    def end_run(self, flock: Motion) -> None:
        """Tell of a run too short for `MISSES`, in which it has never answered; the next begins
        afresh."""
        if self.misses and not self.fault and not self.has_answered:
            self.fault = f"{self.silence}; it never answered, its agents followed their rule"
            self.tell(flock, self.fault)
        self.has_answered, self.misses, self.pause, self.next_wait = False, 0, 1, 0

    def tell(self, flock: Motion, line: str) -> None:
        """Tell a line; of one that comes and goes all the time not all."""
        self.told += 1
        if self.told <= MOST_TOLD:
            last = "; nothing more is told of it" if self.told == MOST_TOLD else ""
            flock.tell(f"{line}{last}")


def open_controllers(texts: Sequence[str] | None, kinds: KindTable) -> tuple[ControllerPilot, ...]:
    """Those of `--steer`. Raises InputError."""
    addresses = [read_address(text) for text in texts or ()]
    demand_steered_kinds(addresses, kinds)
    return tuple(map(ControllerPilot, addresses))


def describe_agents(flock: Motion, kind: str, rows: np.ndarray) -> dict[str, Any]:
    """What a controller is sent of the agents of rows."""
    seen = AgentView(flock, NEAREST, len(rows)).look(rows).astype(float).round(4)
    return {
        "tick": flock.tick,
        "kind": kind,
        "wish": flock.model.rule.wish,
        "numbers": numbers_of_action(flock),
        "dt": flock.dt,
        "agents": [
            {
                "id": int(flock.ids[row]),
                "position": flock.position[row].round(6).tolist(),
                "heading": flock.heading[row].round(6).tolist(),
                "speed": round(float(flock.speed[row] / flock.dt), 6),
                "sees": sight.tolist(),
            }
            for row, sight in zip(rows.tolist(), seen, strict=True)
        ],
    }


def read_answer(data: bytes, flock: Motion, rows: np.ndarray, since: int) -> np.ndarray:
    """The actions (M, A) of a datagram, nan for who follows its rule. Raises AnswerError."""
    if len(data) > LONGEST:
        raise AnswerError(f"an answer of more than {LONGEST} bytes")
    try:
        answer = json.loads(data)
    except (ValueError, RecursionError):
        raise AnswerError("an answer that is no JSON") from None
    if not isinstance(answer, dict) or set(answer) != {"tick", "actions"}:
        raise AnswerError("an answer without its tick and actions alone")
    tick, told = answer["tick"], answer["actions"]
    if not isinstance(tick, int) or isinstance(tick, bool) or not since <= tick <= flock.tick:
        raise AnswerError(f"an answer to tick {shorten(tick)}")
    if not isinstance(told, dict):
        raise AnswerError("an answer whose actions are no table by identities")
    places = {str(flock.ids[row]): place for place, row in enumerate(rows.tolist())}
    actions = np.full((len(rows), numbers_of_action(flock)), np.nan)
    for name, numbers in told.items():
        if name not in places:
            raise AnswerError(f"an answer about agent {shorten(name)}, which it does not steer")
        if numbers is None:
            continue
        is_list = isinstance(numbers, list) and len(numbers) == actions.shape[1]
        if not is_list or not all(map(is_share, numbers)):
            raise AnswerError(
                f"an answer with {shorten(numbers)} for agent {name}: {actions.shape[1]} numbers "
                "in [-1, 1] are needed"
            )
        actions[places[name]] = numbers
    return actions


def is_share(number: object) -> bool:
    """Whether it is a number in [-1, 1]."""
    return (
        isinstance(number, int | float) and not isinstance(number, bool) and -1.0 <= number <= 1.0
    )
