"""How a run differs from the class's scene, in words: so that a teacher does not mix them up."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from agents.flock import Flock
from agents.kinds import kind_table
from agents.spec import OPTIONS
from app.viewer.measuring.run_conditions import kind_values
from app.viewer.run.run_preset import WORLDS
from worlds.world import World

APART = ("seed", "size", "dim", "world")
"""Options that are told apart from the others."""
MOST = 12
"""Differences that are told one by one."""


@dataclass(frozen=True)
class RunIdentity:
    """All that a run depends on but its seed, with nothing left open."""

    model: str
    options: Mapping[str, Any]
    parameters: Mapping[str, Any]
    world: World
    kinds: Mapping[str, Any] = field(default_factory=dict)
    """All by which kinds of agents may differ, by its name."""

    @classmethod
    def of(cls, flock: Flock) -> RunIdentity:
        """That of a flock."""
        options = {name: getattr(flock.options, name) for name in OPTIONS if name not in APART}
        kinds = kind_values(kind_table(flock.options.kinds, flock.options.to))
        return cls(flock.options.model, options, flock.all_parameters, flock.world, kinds)


def differences(ran: RunIdentity, meant: RunIdentity, but: Collection[str]) -> tuple[str, ...]:
    """In what a run is not as meant, what is in `but` apart; at most 13 sentences."""
    said: list[str] = []
    if ran.model != meant.model:
        said.append(f"another model: {ran.model}")
    else:
        said += apart("other", ran.parameters, meant.parameters, but)
    said += apart("other", ran.options, meant.options, but)
    said += of_kinds(ran.kinds, meant.kinds)
    said += of_worlds(ran.world, meant.world)
    if len(said) > MOST:
        said = [*said[:MOST], f"{len(said) - MOST} more"]
    return tuple(said)


def apart(
    word: str, ran: Mapping[str, Any], meant: Mapping[str, Any], but: Collection[str]
) -> list[str]:
    """The values that are not as meant."""
    return [
        f"{word} {name}: {format_value(ran[name])}, not {format_value(value)}"
        for name, value in meant.items()
        if name not in but and name in ran and ran[name] != value
    ]


def of_kinds(ran: Mapping[str, Any], meant: Mapping[str, Any]) -> list[str]:
    """What kinds of agents have that is not as meant."""
    return [
        f"other {name}: {format_value(ran.get(name, 'none'))}, not "
        f"{format_value(meant.get(name, 'none'))}"
        for name in dict.fromkeys([*meant, *ran])
        if ran.get(name) != meant.get(name)
    ]


def of_worlds(ran: World, meant: World) -> list[str]:
    """How two worlds differ, whatever they are called."""
    if nameless(ran) == nameless(meant):
        return []
    if bare(ran) == bare(meant):
        return ["own obstacles"]
    if replace(nameless(ran), size=meant.size, height=meant.height) == nameless(meant):
        return [f"another size: {format_value(ran.size)}, not {format_value(meant.size)}"]
    return [f"another world: {on_one_line(WORLDS.get(ran.name) or ran.title or ran.name, 80)}"]


def on_one_line(text: str, most: int) -> str:
    """At most so many letters of a text that may be anybody's, printable and without semicolons.

    >>> on_one_line("a\\n b; c\\x07", 4)
    'a b,'
    """
    kept = "".join(one for one in text.replace(";", ",") if one.isprintable() or one.isspace())
    return " ".join(kept.split())[:most]


def nameless(world: World) -> World:
    """A world without what it is called and where it is from."""
    return replace(world, name="", title="", source="")


def bare(world: World) -> World:
    """A world without its obstacles."""
    return replace(nameless(world), obstacles=(), random=None)


def format_value(value: Any) -> str:
    """A value for people.

    >>> format_value(0.1 + 0.2), format_value((10.0, 10.0)), format_value(True)
    ('0.3', '10 x 10', 'true')
    """
    if isinstance(value, tuple):
        return " x ".join(map(format_value, value))
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else str(value)
