"""What a sweep has come to, as a value for scripts and notebooks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from agents.spec import Spec
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.sweep_table import as_arrow, long_table, spec_at, wide_table
from worlds.input_error import InputError


@dataclass(frozen=True)
class Results:
    """The runs of a sweep, read from its folder whenever they are asked for the first time.

    `table` has a row for each run, in the order of the plan: `place` of its cell, the axes, `seed`,
    `status` (ok, gave-up, failed, killed), `reason`, `ticks`, `astray`, and what was measured.
    """

    folder: Path

    @cached_property
    def _reader(self) -> StoreReader:
        return StoreReader(self.folder)

    @cached_property
    def columns(self) -> dict[str, list[Any]]:
        """The table as lists by column."""
        return wide_table(self._reader)

    @cached_property
    def table(self) -> Any:
        """The table as `pyarrow.Table`."""
        return as_arrow(self.columns)

    @property
    def series(self) -> Any:
        """Every value at every tick, as `pyarrow.Table` in long form."""
        return as_arrow(long_table(self._reader))

    @property
    def counts(self) -> dict[str, int]:
        """Runs by how they ended."""
        return self._reader.counts

    def to_pandas(self) -> Any:
        """The table as `pandas.DataFrame`."""
        import pandas as pd

        return pd.DataFrame(self.columns)

    def to_polars(self) -> Any:
        """The table as `polars.DataFrame`, where polars is installed. Raises InputError
        elsewhere."""
        try:
            import polars
        except ImportError:
            raise InputError(
                "to_polars needs the package polars, which is not installed: `pip install polars`"
            ) from None
        return polars.from_arrow(self.table)

    def spec(self, place: int, seed: int) -> Spec:
        """A run as a value: `Flock(results.spec(3, 7))` begins it again. Raises InputError."""
        return spec_at(self._reader, place, seed)

    def plot(self, path: str | Path, observable: str | None = None, **options: Any) -> None:
        """Draw the picture of an observable: PNG, SVG or PDF, as `flockscope sweep plot` does."""
        from app.studies.sweeps.sweep_picture import draw

        draw(self._reader, Path(path), observable, **options)

    def _repr_html_(self) -> str:
        return str(self.to_pandas()._repr_html_())
