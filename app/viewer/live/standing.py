"""How a room stands, in big plain words: what the top of the panel says."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from app.live.control.look import Look
from app.live.links.link import RUN
from app.viewer.live.arming_code import TRIES
from app.viewer.live.room_state import RoomState

NO_BROWSER = f"no browser arms after {TRIES} wrong codes; the key a in the terminal does"
MOST = 4
"""Reasons that are told one by one."""
Kind = Literal["opening", "failed", "safe", "running", "held up", "emergency"]


@dataclass(frozen=True)
class Standing:
    """How a room stands."""

    kind: Kind
    title: str
    words: str
    """One sentence."""
    reasons: tuple[str, ...] = ()
    """Why the cars do not run, or cannot be armed, and what else is wrong."""

    @property
    def armable(self) -> bool:
        """Whether the cars can be armed."""
        return self.kind == "safe" and not self.reasons


def standing(state: RoomState, look: Look | None) -> Standing:
    """How a room with this state and this newest look stands."""
    if state.status == "opening":
        if state.latched:
            return Standing("emergency", "EMERGENCY STOP", "Opening; it begins stopped.")
        words = state.compiling or "Waiting for the control loop."
        return Standing("opening", "Opening …", words[:1].upper() + words[1:])
    if state.status != "open":
        title = "Closed" if state.status == "closed" else "Not open"
        return Standing("failed", title, state.trouble or "The cars stop themselves.")
    if look is None:
        return Standing("opening", "Opening …", "Waiting for the control loop.")
    return looked_at(look, state.browsers_arm)


def looked_at(look: Look, browsers_arm: bool = True) -> Standing:
    """How an open room stands."""
    reasons = [reason.words for reason in look.reasons]
    wrong = [f"{what}: {words}" for what, words in look.troubles.items()]
    if look.arm == "emergency":
        return Standing("emergency", "EMERGENCY STOP", "All cars are told to stop.", shown(wrong))
    if look.arm == "safe":
        reasons = [] if browsers_arm else [NO_BROWSER]
        reasons += [reason.words for reason in look.reasons]
        words = "Cannot be armed:" if reasons else "No car is driven. Ready to be armed."
        found = shown(reasons) if reasons else ()
        return Standing("safe", "SAFE", words, found or shown(wrong))
    if look.mode == RUN:
        return Standing("running", "ARMED", "The cars run.", shown(wrong))
    return Standing(
        "held up", "ARMED, but stopped", "They go on by themselves once it is over:", shown(reasons)
    )


def shown(reasons: list[str]) -> tuple[str, ...]:
    """The first few of them.

    >>> shown(["a", "b", "c", "d", "e", "f"])
    ('a', 'b', 'c', 'and 3 more')
    """
    if len(reasons) <= MOST:
        return tuple(reasons)
    return (*reasons[: MOST - 1], f"and {len(reasons) - MOST + 1} more")
