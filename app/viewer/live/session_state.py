"""The state of a session."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

from agents.models.model import Model

Phase = Literal["opening", "open", "replay", "failed", "closed"]
"""`replay`: no loop is open, and an earlier recording is shown."""


@dataclass(frozen=True)
class SessionState:
    """The state of a session; replaced as a whole, never changed."""

    source: str
    """Names of the source, the link and the rule that are open or being opened."""
    link: str
    rule: str
    phase: Phase = "opening"
    trouble: str = ""
    """What is wrong, in one line."""
    model: Model | None = None
    """The rule with its body; None until it is known."""
    values: dict[str, Any] = field(default_factory=dict)
    """The parameters of the model, name -> value, as the control loop has them."""
    compiling: str = ""
    """A line of text while the rule is compiled, the first time that it is used; else empty."""
    recording: str = ""
    """The folder of this opening's recording; empty: none is made."""
    run: int = 0
    """Counts the openings."""
    browsers_arm: bool = True
    """Whether browsers may arm: not after too many wrong codes."""
    latched: bool = False
    """Whether an emergency stop was asked for and no reset has followed, in whichever opening."""
