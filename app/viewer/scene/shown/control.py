"""How a person chooses a value: what it is called, and what may be chosen."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any


@dataclass(frozen=True)
class Control:
    """A switch; with `choices` a list of words; from `low` to `high` in steps a slider, or a box
    that numbers are typed into."""

    label: str
    hint: str | None = None
    choices: tuple[str, ...] = ()
    low: float = 0.0
    high: float = 0.0
    step: float = 0.0
    typed: bool = False


def chosen(default: Any, *control: Any, **more: Any) -> Any:
    """A field of a dataclass that a person may choose by `Control(*control, **more)`."""
    return field(default=default, metadata={"control": Control(*control, **more)})


def controls_of(declared: type) -> dict[str, Control]:
    """How those fields of a dataclass are chosen that are, by name, in their order."""
    found = ((one.name, one.metadata.get("control")) for one in fields(declared))
    return {name: control for name, control in found if control is not None}
