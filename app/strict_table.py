"""Tables of an experiment's TOML file: keys that they do not have are errors."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    InstanceOf,
    PlainSerializer,
)

from agents.individuals import Distribution, as_distribution
from worlds.input_error import demand_line

Value = bool | float | str
"""What a parameter may be set to."""


def distribution_or_value(value: Any) -> Any:
    """The distribution that a value describes, or the value. Raises InputError."""
    found = as_distribution(value)
    return value if found is None else found


def as_written(value: Value | Distribution) -> Any:
    """A value as TOML and JSON have it."""
    return value.to_value() if isinstance(value, Distribution) else value


ParameterValue = Annotated[
    Value | InstanceOf[Distribution],
    BeforeValidator(distribution_or_value),
    PlainSerializer(as_written),
]
"""What a parameter of runs may be set to: one value of all agents, or what each draws its own from,
such as `{ normal = [3, 0.5] }` or `"normal(3, 0.5)"`; a list has the number of each agent."""
Line = Annotated[str, AfterValidator(demand_line)]
"""A text that is shown in a line."""


class StrictTable(BaseModel):
    """A table of the file."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
