"""The code without which no browser arms: whoever knows it can see the terminal."""

from __future__ import annotations

import hmac
import re
import secrets
import threading
from typing import Literal

DIGITS = 6
TRIES = 5
"""Wrong codes, of all browsers together, after which none is taken any more."""
WRITTEN = re.compile(rf"[0-9]{{{DIGITS}}}")

Verdict = Literal["right", "wrong", "no code", "off"]
"""`no code`: what was entered cannot be one, and counts as no try."""


class ArmingCode:
    """A code made by chance at the start; it is shown in the terminal and nowhere else.

    >>> code = ArmingCode()
    >>> code.tried(code.digits), code.tried("12"), code.left
    ('right', 'no code', 5)
    """

    def __init__(self) -> None:
        self.digits = f"{secrets.randbelow(10**DIGITS):0{DIGITS}d}"
        self.left = TRIES
        """Wrong codes until it is off."""
        self.trying = threading.Lock()

    @property
    def off(self) -> bool:
        """Whether no code is taken any more, until the next start."""
        return self.left == 0

    def tried(self, entered: str) -> Verdict:
        """What is to be said of an entered code; a wrong one is counted for good."""
        given = entered.strip()
        if not WRITTEN.fullmatch(given):
            return "off" if self.off else "no code"
        with self.trying:
            if self.off:
                return "off"
            if hmac.compare_digest(given, self.digits):
                return "right"
            self.left -= 1
            return "wrong"
