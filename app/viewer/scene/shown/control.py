"""How a person chooses a value: what it is called, what may be chosen, and when it applies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any

Applies = Callable[[Any, Any], bool]
"""(what is shown, what is chosen) -> whether a choice makes a difference to it."""


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
    group: str = ""
    """What it is about: a heading over all such controls."""
    applies: Applies | None = None
    """When there is anything to choose; None: always."""
    only: Mapping[str, Applies] = field(default_factory=dict)
    """When some of the `choices` are offered; the others always are."""

    def is_for(self, scene: Iterable[Any], chosen: Any) -> bool:
        """Whether it applies to anything in a scene."""
        return self.applies is None or any(self.applies(one, chosen) for one in scene)

    def offered(self, scene: Iterable[Any], chosen: Any) -> tuple[str, ...]:
        """The choices that apply to anything in a scene."""
        rest = {
            choice: Control(choice, applies=applies).is_for(scene, chosen)
            for choice, applies in self.only.items()
        }
        return tuple(choice for choice in self.choices if rest.get(choice, True))


def chosen_field(default: Any, *control: Any, **more: Any) -> Any:
    """A field of a dataclass that a person may choose by `Control(*control, **more)`."""
    return field(default=default, metadata={"control": Control(*control, **more)})


def controls_of(declared: type) -> dict[str, Control]:
    """How those fields of a dataclass are chosen that are, by name, in their order."""
    pairs = ((field.name, field.metadata.get("control")) for field in fields(declared))
    return {name: control for name, control in pairs if control is not None}
