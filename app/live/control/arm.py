"""Arming: no car drives before a person arms the laboratory, and the emergency stop latches.

safe --arm--> armed --disarm, hold--> safe
any  --emergency--> emergency --reset--> safe
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

from worlds.input_error import InputError, unknown

State = Literal["safe", "armed", "emergency"]
Action = Literal["arm", "disarm", "hold", "emergency", "reset", "tune", "accompany"]
ACTIONS: tuple[Action, ...] = ("arm", "disarm", "hold", "emergency", "reset", "tune", "accompany")
UNDOING = ("reset", "arm")
"""Requests that are void if an emergency stop was asked for after them."""


@dataclass(frozen=True)
class OperatorRequest:
    """A request of an operator to the control loop, and who makes it."""

    action: Action
    cause: str
    """Who or what asks: `terminal`, `browser 3`, `link`."""
    words: str = ""
    """Why; for `tune` the parameters as JSON, for `accompany` how many simulated cars."""

    def __post_init__(self) -> None:
        if self.action not in ACTIONS:
            raise unknown("request", self.action, ACTIONS, self.cause)


class Arm:
    """Whether the cars may be driven; a pure state machine without a clock."""

    def __init__(self) -> None:
        self.state: State = "safe"

    def carry_out(self, request: OperatorRequest, faults: Sequence[str] = ()) -> bool:
        """Carry out a request; whether it changed the state.

        `faults` are the reasons, in words, why the cars would not run. Raises InputError for an
        arming with faults or with the emergency stop latched.
        """
        before = self.state
        match request.action:
            case "emergency":
                self.state = "emergency"
            case "reset" if self.state == "emergency":
                self.state = "safe"
            case "disarm" | "hold" if self.state == "armed":
                self.state = "safe"
            case "arm" if self.state == "emergency":
                raise InputError("cannot be armed: the emergency stop is latched, reset it first")
            case "arm" if faults:
                raise InputError(f"cannot be armed: {'; '.join(faults)}")
            case "arm":
                self.state = "armed"
        return self.state != before
