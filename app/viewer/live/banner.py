"""The banner at the top of the panel: the state of the cars in large, plain words."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from app.live.control.loop_status import Status
from app.live.links.link import RUN
from app.viewer.live.arming_code import TRIES
from app.viewer.live.session_state import SessionState

MOVES = "A CAR MOVES THOUGH TOLD TO STAND"
"""The alarm of a car that moves in whatever state; what to do follows in the reasons."""
NO_BROWSER = f"no browser arms after {TRIES} wrong codes; the key a in the terminal does"
MOST = 4
"""Reasons that are listed one by one."""
Kind = Literal["opening", "failed", "replay", "safe", "running", "held up", "emergency"]


@dataclass(frozen=True)
class Banner:
    """A title, a sentence, and reasons."""

    kind: Kind
    title: str
    words: str
    """One sentence."""
    reasons: tuple[str, ...] = ()
    """Why the cars do not run, or cannot be armed, and what else is wrong."""
    alarm: str = ""
    """What a person must act on at once, in large letters above all else; empty: nothing."""

    @property
    def armable(self) -> bool:
        """Whether the cars can be armed."""
        return self.kind == "safe" and not self.reasons


def banner_of(state: SessionState, status: Status | None) -> Banner:
    """The banner of a session with this state and this newest status of its loop."""
    if state.phase == "opening":
        if state.latched:
            return Banner("emergency", "EMERGENCY STOP", "Opening; it begins stopped.")
        words = state.compiling or "Waiting for the control loop."
        return Banner("opening", "Opening …", words[:1].upper() + words[1:])
    if state.phase == "replay":
        words = "An earlier recording. The room is closed: nothing is sent to any car."
        late = ("an emergency stop is latched",) if state.latched else ()
        return Banner("replay", "REPLAY", words, late)
    if state.phase != "open":
        title = "Closed" if state.phase == "closed" else "Not open"
        return Banner("failed", title, state.trouble or "The cars stop themselves.")
    if status is None:
        return Banner("opening", "Opening …", "Waiting for the control loop.")
    return banner_of_open(status, state.browsers_arm)


def banner_of_open(status: Status, browsers_arm: bool = True) -> Banner:
    """The banner of an open session."""
    moves = [reason.words for reason in status.reasons if reason.kind == "moves"]
    others = [reason.words for reason in status.reasons if reason.kind != "moves"]
    wrong = [f"{what}: {words}" for what, words in status.troubles.items()]
    alarm = MOVES if moves else ""
    if status.arm == "emergency":
        title, words = "EMERGENCY STOP", "All cars are told to stop."
        return Banner("emergency", title, words, shown(moves + wrong), alarm)
    if status.arm == "safe":
        reasons = moves + ([] if browsers_arm else [NO_BROWSER]) + others
        words = "Cannot be armed:" if reasons else "No car is driven. Ready to be armed."
        return Banner("safe", "SAFE", words, shown(reasons + wrong), alarm)
    if status.mode == RUN:
        return Banner("running", "ARMED", "The cars run.", shown(wrong))
    words = "They go on by themselves once it is over:"
    return Banner("held up", "ARMED, but stopped", words, shown(moves + others + wrong), alarm)


def shown(reasons: list[str]) -> tuple[str, ...]:
    """The first few of them.

    >>> shown(["a", "b", "c", "d", "e", "f"])
    ('a', 'b', 'c', 'and 3 more')
    """
    if len(reasons) <= MOST:
        return tuple(reasons)
    return (*reasons[: MOST - 1], f"and {len(reasons) - MOST + 1} more")
