"""Where a page is served, as options of every command that serves one."""

from __future__ import annotations

from typing import Annotated

import typer

from worlds.refusal import Refusal, shortened

LONGEST = 253
"""Characters of a name of a machine."""

Port = Annotated[int, typer.Option(min=0, max=65535, help="Port to serve on.")]


def address(host: str) -> str:
    """The address, if a machine can have it. Raises Refusal."""
    if not host.isascii() or not host.isprintable() or len(host) > LONGEST:
        raise Refusal(f"--host {shortened(host)} is no name or address of a machine")
    return host


Host = Annotated[
    str,
    typer.Option(callback=address, help="Address to serve on; 0.0.0.0 lets the whole network in."),
]
OpenBrowser = Annotated[bool, typer.Option("--open/--no-open", help="Open the browser.")]
