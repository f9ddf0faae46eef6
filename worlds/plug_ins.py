"""Find plug-ins of other packages by entry points; one that fails is left out with a warning."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection
from importlib.metadata import entry_points
from importlib.util import find_spec

from worlds.input_error import InputError


class PlugInWarning(UserWarning):
    """A plug-in is left out."""


def plug_ins[Made](
    group: str, convert: Callable[[str, object], tuple[str, Made]], names_in_use: Collection[str]
) -> dict[str, Made]:
    """What the entry points of a group come to, by name.

    `convert` turns the name of an entry and what it loads into a name and a thing. What cannot be
    loaded or made, and what has a name of `names_in_use`, is left out, each with a warning.
    """
    entries: dict[str, Made] = {}
    for entry in entry_points(group=group):
        try:
            name, value = convert(entry.name, entry.load())
        except (Exception, SystemExit) as error:
            reason = " ".join(f"{type(error).__name__}: {error}".split())
            warn_of_plug_in(group, entry, f"cannot be loaded ({reason[:200]})")
            continue
        if name in names_in_use:
            warn_of_plug_in(group, entry, f"has the name {name!r}, which is built in")
        elif name in entries:
            warn_of_plug_in(group, entry, f"has the name {name!r}, which another plug-in has")
        else:
            entries[name] = value
    return entries


def warn_of_plug_in(group: str, entry: object, reason: str) -> None:
    """Warn of a plug-in that is left out."""
    name, value = getattr(entry, "name", "?"), getattr(entry, "value", "?")
    warnings.warn(
        f"the plug-in {name!r} ({value}, {group}) {reason}; it is left out",
        PlugInWarning,
        stacklevel=3,
    )


# Packages that only some need: extras of flockscope, named by whoever needs one.


def install(extra: str) -> str:
    """What to do about a package of an extra; flockscope is on no package index.

    >>> install("live")
    'install the extra live: `uv sync --extra live` or `pip install ".[live]"` in its folder'
    """
    return (
        f"install the extra {extra}: `uv sync --extra {extra}` or "
        f'`pip install ".[{extra}]"` in its folder'
    )


def demand(package: str, purpose: str, extra: str) -> None:
    """Refuse with one line what needs a package that is not installed."""
    if find_spec(package) is None:
        raise InputError(
            f"{purpose} needs the package {package}, which is not installed: {install(extra)}"
        )


def demand_parquet(purpose: str) -> None:
    """Refuse with one line what writes or reads Parquet where that cannot be done."""
    demand("pyarrow", purpose, "parquet")
