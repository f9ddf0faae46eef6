"""Tables of an experiment's TOML file: keys that they do not have are errors."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict

Value = bool | float | str
"""What a parameter may be set to."""


class Strict(BaseModel):
    """A table of the file."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)
