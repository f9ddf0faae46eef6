"""Where a page is served, as options of every command that serves one, and what is said of it."""

from __future__ import annotations

from typing import Annotated

import typer

from worlds.input_error import InputError, shorten

LONGEST = 253
"""Characters of a name of a machine."""

Port = Annotated[int, typer.Option(min=0, max=65535, help="Port to serve on.")]


def address(host: str) -> str:
    """The address, if a machine can have it. Raises InputError."""
    if not host.isascii() or not host.isprintable() or len(host) > LONGEST:
        raise InputError(f"--host {shorten(host)} is no name or address of a machine")
    return host


Host = Annotated[
    str,
    typer.Option(callback=address, help="Address to serve on; 0.0.0.0 lets the whole network in."),
]
OpenBrowser = Annotated[bool, typer.Option("--open/--no-open", help="Open the browser.")]
AllowHost = Annotated[
    list[str] | None,
    typer.Option(
        "--allow-host",
        metavar="NAME",
        help="A name, NAME or NAME:PORT, by which browsers reach the page: a full name of this "
        "machine, or a proxy such as JupyterHub; may be repeated.",
    ),
]


def announce(host: str, port: int, leaving: str, whoever: str) -> None:
    """Say where the page is; `whoever`: what anyone in the network can do, if they reach it."""
    from app.front.origin import local_address, network_addresses

    typer.echo(f"flockscope is at {local_address(host, port)} ({leaving})")
    others = network_addresses(host, port)
    if others:
        typer.echo(f"from other machines at {' or '.join(others)}")
        typer.echo(f"warning: --host {host} lets anyone in the network {whoever}", err=True)
