"""Options of the commands `flockscope live ...`."""

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
Seconds = Annotated[
    float | None, typer.Option("--seconds", help="Leave after so long. \\[default: never]")
]
Ticks = Annotated[
    int | None,
    typer.Option("--ticks", help="Instead of --seconds: ticks of the laboratory's rate."),
]
