"""`flockscope cite`: the papers that a model comes from, as BibTeX."""

from __future__ import annotations

import json
from typing import Annotated

import typer


def cite(
    model: Annotated[str, typer.Argument(help="Name of a model, see `flockscope list models`.")],
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Print the sources of a model as BibTeX."""
    from agents.catalogue import model as by_name
    from agents.models import sources

    cited = by_name(model)
    entries = sources.cite(cited)
    if as_json:
        value = {"model": cited.name, "source": cited.rule.source, "bibtex": entries}
        typer.echo(json.dumps(value))
    elif entries:
        typer.echo("\n\n".join(entries))
    else:
        typer.echo(f"{cited.name} names no paper known here; its source: {cited.rule.source}")
