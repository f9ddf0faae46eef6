"""Tables of an experiment's TOML file: keys that they do not have are errors."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, BaseModel, ConfigDict

from worlds.input_error import demand_line

Value = bool | float | str
"""What a parameter may be set to."""
Line = Annotated[str, AfterValidator(demand_line)]
"""A text that is shown in a line."""


class StrictTable(BaseModel):
    """A table of the file."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
