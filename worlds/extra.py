"""Packages that only some need: extras of flockscope, named by whoever needs one."""

from __future__ import annotations

from importlib.util import find_spec

from worlds.input_error import InputError


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
