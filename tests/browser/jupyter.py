"""A JupyterLab with a notebook in it, as a hub starts one: on a path of its own."""

from __future__ import annotations

import json
import os
import secrets
import socket
import subprocess
import sys
import urllib.request
from pathlib import Path
from typing import Any, Self

from tests.viewer.waiting import until

BASE = "/user/ada/"
STARTS, ENDS = 60.0, 20.0
"""Seconds that it takes to start, and to end, on a busy machine."""


class Jupyter:
    """Runs in a folder until left."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.token = secrets.token_hex(16)
        with socket.create_server(("127.0.0.1", 0)) as free:
            self.port = free.getsockname()[1]
        self.runtime = folder / "runtime"
        self.log = folder / "jupyter.log"

    def __enter__(self) -> Self:
        places = {
            "JUPYTER_CONFIG_DIR": "config",
            "JUPYTER_RUNTIME_DIR": "runtime",
            "JUPYTERLAB_SETTINGS_DIR": "settings",
            "JUPYTERLAB_WORKSPACES_DIR": "workspaces",
            "IPYTHONDIR": "ipython",
        }
        settings = self.folder / "settings" / "@jupyterlab" / "apputils-extension"
        settings.mkdir(parents=True)
        (settings / "notification.jupyterlab-settings").write_text(
            '{"fetchNews": "false", "checkForUpdates": false}'
        )
        self.process = subprocess.Popen(
            [
                *(sys.executable, "-m", "jupyterlab", "--no-browser", "--allow-root"),
                f"--ServerApp.port={self.port}",
                "--ServerApp.port_retries=0",
                f"--ServerApp.base_url={BASE}",
                f"--ServerApp.root_dir={self.folder}",
                f"--IdentityProvider.token={self.token}",
            ],
            env=os.environ | {name: str(self.folder / place) for name, place in places.items()},
            stdout=self.log.open("w"),
            stderr=subprocess.STDOUT,
        )
        until(self.answers, STARTS, "a JupyterLab")
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        try:
            self.process.wait(ENDS)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def answers(self) -> bool:
        """Whether it is there."""
        assert self.process.poll() is None, self.log.read_text()
        try:
            self.asked("api")
        except OSError:
            return False
        return True

    def asked(self, what: str) -> Any:
        """What its own interface answers."""
        asked = urllib.request.Request(
            f"http://127.0.0.1:{self.port}{BASE}{what}",
            headers={"Authorization": f"token {self.token}"},
        )
        with urllib.request.urlopen(asked, timeout=60) as answer:
            return json.load(answer)

    def notebook(self, *cells: str) -> str:
        """The address of a notebook with these cells, as seen by somebody with the token."""
        made = {
            "cells": [
                {"cell_type": "code", "id": f"cell-{k}", "metadata": {}, "outputs": [],
                 "execution_count": None, "source": text}
                for k, text in enumerate(cells)
            ],
            "metadata": {"kernelspec": {"name": "python3", "display_name": "Python 3"}},
            "nbformat": 4,
            "nbformat_minor": 5,
        }  # fmt: skip
        (self.folder / "flocks.ipynb").write_text(json.dumps(made))
        return f"http://localhost:{self.port}{BASE}lab/tree/flocks.ipynb?token={self.token}"
