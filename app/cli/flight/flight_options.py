"""The options that the flight commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Frequency = Annotated[float, typer.Option(help="Of flap and twist, Hz, 0.5 to 6.")]
Twist = Annotated[float, typer.Option(help="R of the wing tip, deg, 0 to 45.")]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        help="Of the aircraft (flight aircraft lists them), NAME=VALUE; may be repeated.",
    ),
]
Out = Annotated[Path, typer.Option(help="Folder for numbers and pictures.")]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Replace what the folder has of these results.")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No messages while it runs.")]
