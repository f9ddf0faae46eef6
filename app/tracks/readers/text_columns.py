"""Read tables of text by their columns, fast and bounded; what is wrong is told with its line."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from app.tracks.readers.file_beginning import FileBeginning
from worlds.input_error import InputError, shorten, unknown
from worlds.memory import demand_memory

if TYPE_CHECKING:
    import pandas as pd

MOST_ROWS = 30_000_000
"""Rows of a table."""
MOST_COLUMNS = 100_000
"""Columns of a table, such as two for each of many individuals."""
MOST_CELLS = 400_000_000
"""Numbers of a table: 3 GB."""


def read_frame(
    beginning: FileBeginning,
    columns: Sequence[str] | None = None,
    *,
    header: int | None = 0,
    names: Sequence[str] | None = None,
    skip: Sequence[int] | int = (),
    separator: str | None = None,
    comment: str | None = None,
    texts: Iterable[str] = (),
    used: Sequence[int] | None = None,
    width: int | None = None,
) -> pd.DataFrame:
    """Some columns (all) of a table of text as a data frame.

    header: the line with the names of its columns, after what is skipped, or None; names: those
    of a table without such a line. skip: lines that are left out, by their places from 0, or how
    many at the beginning. texts: columns that stay text, as categories. used: places of the
    columns that are read. width: how many columns there are, if the first line does not tell it.
    Raises InputError.
    """
    import pandas as pd

    name = beginning.name
    mark = beginning.separator if separator is None else separator
    widest = width or max((len(beginning.words(k)) for k in range(50)), default=1)
    if widest > MOST_COLUMNS:
        raise InputError(f"{name} has {widest} columns: at most {MOST_COLUMNS} are read")
    share = min(len(columns or used or ()) / widest, 1.0) if columns or used else 1.0
    demand_memory(f"reading {name}", 2e8 + 6.0 * share * beginning.size)
    try:
        frame = pd.read_csv(
            beginning.path,
            sep=mark or r"\s+",
            header=header,
            names=names,
            usecols=columns if columns is not None else used,
            skiprows=list(skip) if not isinstance(skip, int) else skip,
            comment=comment,
            dtype=dict.fromkeys(texts, "category") or None,
            nrows=min(MOST_ROWS + 1, MOST_CELLS // max(1, round(share * widest)) + 1),
            compression=None,
            encoding="utf-8-sig",
            low_memory=False,
            skipinitialspace=True,
        )
    except UnicodeDecodeError:
        raise InputError(f"{name} is not a text file in UTF-8") from None
    except OSError as error:
        raise InputError(f"{name} cannot be read: {error.strerror or error}") from None
    except (ValueError, pd.errors.ParserError, csv.Error, OverflowError) as error:
        reason = " ".join(str(error).split()).removeprefix("Error tokenizing data. C error: ")
        raise InputError(f"{name} is no table: {reason[:200]}") from None
    if len(frame) > MOST_ROWS or frame.size > MOST_CELLS:
        raise InputError(
            f"{name} has too many rows: at most {min(MOST_ROWS, MOST_CELLS // frame.shape[1])} "
            f"of {frame.shape[1]} columns are read"
        )
    if not len(frame):
        raise InputError(f"{name} has no rows")
    return frame


def numbers_of(frame: pd.DataFrame, column: Any, name: str, least_line: int = 2) -> np.ndarray:
    """A column as (R,) float64, NaN where it is blank. Raises InputError naming the line.

    least_line: the line of the file that the first row stands in.
    """
    import pandas as pd

    values = frame[column]
    if values.dtype.kind in "fiub":
        return values.to_numpy(float)
    converted = pd.to_numeric(values.astype(object), errors="coerce").to_numpy(float)
    for k in np.flatnonzero(np.isnan(converted) & values.notna().to_numpy())[:1]:
        raise InputError(
            f"{name}, line {k + least_line}, column {column}: "
            f"{shorten(str(values.iloc[k]))} is not a number"
        )
    return converted


def whole_numbers(values: np.ndarray, column: str, name: str, least_line: int = 2) -> np.ndarray:
    """Numbers as (R,) int64. Raises InputError naming the line of one that is not whole."""
    fits = np.isfinite(values) & (np.abs(values) < 2**53)
    whole = np.where(fits, values, 0.5)
    for k in np.flatnonzero(whole != np.round(whole))[:1]:
        value = "it is empty" if np.isnan(values[k]) else f"{values[k]:g} is not a whole number"
        raise InputError(f"{name}, line {k + least_line}, column {column}: {value}")
    return whole.astype(np.int64)


def demand_columns(beginning: FileBeginning, columns: Iterable[str]) -> None:
    """Refuse a table without these columns."""
    for column in columns:
        if column not in beginning.columns:
            raise unknown("column", column, beginning.columns, beginning.name)


def lower_names(columns: Iterable[object]) -> Mapping[str, str]:
    """The columns by their names in lower case, without blanks around."""
    return {str(column).strip().lower(): str(column) for column in columns}


def beginning_of(path: Path) -> FileBeginning:
    """What a file begins with. Raises InputError."""
    return FileBeginning(path)


def stem_ids(files: Sequence[Path]) -> list[str]:
    """A name for each of several files, from its own: what they all begin with is left out.

    >>> stem_ids([Path("goat_1.csv"), Path("goat_12.csv")])
    ['1', '12']
    >>> stem_ids([Path("goats.csv")])
    ['goats']
    """
    stems = [path.stem for path in files]
    if len(stems) < 2:
        return stems
    length = 0
    for letters in zip(*stems, strict=False):
        if len(set(letters)) > 1:
            break
        length += 1
    start = length
    while start and stems[0][start - 1].isalnum():
        start -= 1  # a word is not cut in two, unless a number follows
    if all(stem[length:].isdigit() for stem in stems) and not stems[0][length - 1 :][:1].isdigit():
        start = length
    shorter = [stem[start:] for stem in stems]
    return shorter if all(shorter) and len(set(shorter)) == len(shorter) else stems
