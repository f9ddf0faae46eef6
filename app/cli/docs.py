"""`flockscope docs`: the pages of flockscope in the browser, from a folder of this machine."""

from __future__ import annotations

import threading
import webbrowser
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any

import typer

from app.cli.options.serving_options import OpenBrowser, Port
from app.cli.terminal.progress import StopSignals
from app.front.http_server import listen
from app.front.origin import local_address
from app.package_files import FOLDER
from worlds.input_error import InputError

HOST = "127.0.0.1"
LOOK = 0.2
"""How often a stop is looked for, s."""
PACKAGE = "flockscope_docs"
"""The package of the wheel that `docs/build_site.py --wheel` writes."""


def docs(
    folder: Annotated[
        Path | None, typer.Argument(help="Folder of a site that was built elsewhere.")
    ] = None,
    port: Port = 0,
    open_browser: OpenBrowser = True,
) -> None:
    """Open the pages of flockscope in the browser; nothing is asked of the internet.

    They are those of the package flockscope-docs, or of the checkout where they are built. Port 0
    is any that is free. The pages are served to this machine alone.
    """
    site = find_site() if folder is None else folder
    if not (site / "index.html").is_file():
        raise InputError(f"{site} has no index.html: it is no folder of flockscope's pages")
    with open_server(site, port) as server, StopSignals() as stopping:
        address = local_address(HOST, server.server_port)
        typer.echo(f"flockscope's pages are at {address} (Ctrl-C stops it)")
        if open_browser:
            # A browser may not return before it has the page.
            threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()
        while not stopping.asked:
            server.handle_request()
    typer.echo("", err=True)


def find_site() -> Path:
    """The folder of the pages that are installed, or built in the checkout. Raises InputError."""
    package = find_spec(PACKAGE)
    if package is not None and package.origin is not None:
        return Path(package.origin).parent / "site"
    built = FOLDER / "site"
    if not built.is_dir():
        raise InputError(
            "the pages are not installed: install the wheel flockscope-docs of the release, or "
            "build them in the checkout: uv run python docs/build_site.py"
        )
    return built


class PageHandler(SimpleHTTPRequestHandler):
    """Answers with files of one folder; lists none, and says nothing of requests."""

    def list_directory(self, path: Any) -> None:  # noqa: ARG002
        """Refuse."""
        self.send_error(404)

    def log_message(self, *_: Any) -> None:
        """Say nothing."""


def open_server(site: Path, port: int) -> ThreadingHTTPServer:
    """A server of a folder, for this machine alone. Raises InputError if the port is busy."""
    handler = partial(PageHandler, directory=str(site))
    server = ThreadingHTTPServer((HOST, port), handler, bind_and_activate=False)
    server.socket.close()
    server.socket = listen(HOST, port)
    server.server_port = server.socket.getsockname()[1]
    server.timeout = LOOK
    return server
