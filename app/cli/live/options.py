"""Options of `flockscope live check` and `flockscope live run`."""

from __future__ import annotations

from typing import Annotated

import typer

SourceName = Annotated[
    str | None,
    typer.Option("--source", help="Another source: a name of \\[sources], or `emulated cars`."),
]
LinkName = Annotated[
    str | None, typer.Option("--link", help="Another link: a name of \\[links], or `dry run`.")
]
