"""The option `--rule FILE.py`: a rule of one's own, wherever a model's name may stand."""

from __future__ import annotations

from typing import Annotated

import typer


def bring(files: list[str] | None) -> list[str]:
    """Take the rules of files into the catalogue; the names of their models. Raises InputError."""
    if not files:
        return []
    from agents.catalogue import from_file

    return [from_file(file).name for file in files]


def by_name(model: str | None) -> str | None:
    """The name of a model; a file has its rule taken into the catalogue for it. Raises
    InputError."""
    return bring([model])[0] if model is not None and model.endswith(".py") else model


def first_of(model: str | None, rules: list[str] | None) -> str | None:
    """The model that is asked for: by its name, or else the first of `--rule`."""
    return model or next(iter(rules or ()), None)


Rules = Annotated[
    list[str] | None,
    typer.Option(
        "--rule",
        callback=bring,
        is_eager=True,
        metavar="FILE.py",
        help="A Python file with a RULE or a MODEL of your own; may be repeated.",
    ),
]
