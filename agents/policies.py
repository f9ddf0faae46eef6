"""A policy: a function of an author's own file that flies the agents of a kind.

It is given what they see, (M, width), and answers what they do, (M, A) in [-1, 1], once a tick:
see `agents.motion.agent_view`. `agents.policy_process` calls it, in a process of its own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, overload

from worlds.input_error import InputError, shorten, unknown

MOST_NEAREST = 64
"""Nearest agents that one sees, at most."""
LONGEST_TICK = 60.0
"""Seconds that a policy may have for a tick, at most."""
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,31}")


@dataclass(frozen=True)
class Policy:
    """What a file declares by `policy`. Raises InputError."""

    act: Callable[[Any], Any]
    name: str
    k: int = 6
    """How many of the nearest its agents see."""
    scale: float = 1.0
    """What an action of 1 is, where the rule wishes an acceleration or a velocity."""
    timeout: float = 1.0
    """Seconds that it may take for a tick, from when it begins."""
    ends: bool = False
    """Whether the run ends with what goes wrong; else its agents follow their rule from then on."""
    file: str = ""
    """Where it was read from."""
    digest: str = field(default="", compare=False)
    """A hash of that file as it was read."""

    def __post_init__(self) -> None:
        if not callable(self.act):
            raise InputError(f"{shorten(self.act)} is no policy: a function is needed")
        demand_policy_name(self.name)
        is_whole = isinstance(self.k, int) and not isinstance(self.k, bool)
        if not is_whole or not 1 <= self.k <= MOST_NEAREST:
            raise InputError(
                f"policy {self.name}: k = {shorten(self.k)} is not allowed: a whole number from 1 "
                f"to {MOST_NEAREST} is needed"
            )
        for name, most in (("scale", math.inf), ("timeout", LONGEST_TICK)):
            value = getattr(self, name)
            is_number = isinstance(value, int | float) and not isinstance(value, bool)
            if not is_number or not 0.0 < value <= most or math.isinf(value):
                limit = "" if math.isinf(most) else f", {most:g} at most,"
                raise InputError(
                    f"policy {self.name}: {name} = {shorten(value)} is not allowed: a finite "
                    f"number > 0{limit} is needed"
                )
        if not isinstance(self.ends, bool):
            raise InputError(
                f"policy {self.name}: ends = {shorten(self.ends)} is not True or False"
            )


def demand_policy_name(name: object) -> None:
    """Raise InputError for what no policy is called."""
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise InputError(
            f"policy {shorten(name)} is not allowed: a name of letters, digits, - and _ is needed"
        )


@overload
def policy(act: Callable[[Any], Any]) -> Policy: ...
@overload
def policy(
    *,
    name: str = "",
    k: int = 6,
    scale: float = 1.0,
    timeout: float = 1.0,
    ends: bool = False,
) -> Callable[[Callable[[Any], Any]], Policy]: ...
def policy(act: Callable[[Any], Any] | None = None, **options: Any) -> Any:
    """Declare a function as a policy; it is called as the function is, or as `name` says.

    k: how many of the nearest its agents see. scale: what an action of 1 is, where the rule wishes
    an acceleration or a velocity. timeout: seconds that it may take for a tick. ends: whether the
    run ends with what goes wrong; else its agents follow their rule from then on. Raises
    InputError.

    >>> from flockscope import policy
    >>> @policy(k=4)
    ... def straight_on(seen):
    ...     return [[0.0]] * len(seen)
    >>> straight_on.name, straight_on.k
    ('straight_on', 4)
    """
    if act is None:
        return lambda function: policy_of(function, **options)
    return policy_of(act)


def policy_of(act: Callable[[Any], Any], name: str = "", **options: Any) -> Policy:
    """The policy of a function. Raises InputError."""
    return Policy(act, name or getattr(act, "__name__", ""), **options)


POLICIES: dict[str, Policy] = {}
"""Those that were read from files, by their names."""


def known_policy(name: str) -> Policy:
    """The policy of a name. Raises InputError for one that no file has brought."""
    if name not in POLICIES:
        if not POLICIES:
            raise InputError(f"unknown policy {shorten(name)}: give its file by --rule FILE.py")
        raise unknown("policy", name, POLICIES)
    return POLICIES[name]
