"""Where a page is served, as options of every command that serves one."""

from __future__ import annotations

from typing import Annotated

import typer

Port = Annotated[int, typer.Option(min=0, max=65535, help="Port to serve on.")]
Host = Annotated[str, typer.Option(help="Address to serve on; 0.0.0.0 lets the whole network in.")]
OpenBrowser = Annotated[bool, typer.Option("--open/--no-open", help="Open the browser.")]
