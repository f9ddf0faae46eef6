"""What runs a flock's WebAssembly in `web.py`: Chromium, Firefox and node, each if it is there.

Each has the page's own class Kernel and `web_flight.js`, and gives positions to the last bit.
Chromium is driven by Playwright. Debian's Firefox is not the one that Playwright drives, so it
fetches flocks from a server on this computer and sends back what it finds.
"""

from __future__ import annotations

import base64
import json
import os
import queue
import shutil
import subprocess
import tempfile
import threading
from collections.abc import Sequence
from ctypes.util import find_library
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

STATIC = Path(__file__).parents[2] / "static" / "export"
SOURCE = "\n".join(
    path.read_text("utf-8")
    for path in (
        STATIC / "kernel.js",
        STATIC / "start.js",
        Path(__file__).parent / "web_flight.js",
    )
)
ARGUMENTS = (
    "--no-sandbox",
    "--use-gl=angle",
    f"--use-angle={'gl-egl' if find_library('EGL') else 'swiftshader'}",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
)
"""A browser that draws without a graphics card."""
TIMEOUT = 300.0
"""Seconds that a runtime may take for one flock."""
IN_NODE = """
const ask = JSON.parse(require("fs").readFileSync(0, "utf8"));
kernelOf(ask.program).then((kernel) =>
  process.stdout.write(JSON.stringify(positionsAfter(kernel, ask.ticks))));
"""
IN_FIREFOX = """
(async () => {
  for (;;) {
    const ask = await (await fetch("/next")).json();
    let found;
    try {
      found = positionsAfter(await kernelOf(ask.program), ask.ticks);
    } catch (error) {
      found = { error: String(error) };
    }
    await fetch("/found", { method: "POST", body: JSON.stringify(found) });
  }
})();
"""
PAGE = f"<!doctype html><meta charset='utf-8'><script>{SOURCE}{IN_FIREFOX}</script>"
"""What Firefox opens."""

type Positions = list[bytes]
"""The bits of all positions, after each number of ticks that was asked for."""


class RuntimeFault(Exception):
    """A runtime did not run a flock."""


def decoded(texts: Sequence[str]) -> Positions:
    """What JavaScript gives, as bytes."""
    return [base64.b64decode(text) for text in texts]


class Chromium:
    """A Chromium that is driven; a page of it holds one kernel at a time."""

    def __init__(self) -> None:
        from playwright.sync_api import sync_playwright

        program = os.environ.get("FLOCKSCOPE_CHROMIUM") or shutil.which("chromium")
        if program is None:
            raise SystemExit("this benchmark needs Chromium")
        self.playwright = sync_playwright().start()
        self.browser = self.playwright.chromium.launch(executable_path=program, args=ARGUMENTS)
        self.name = f"Chromium {self.browser.version.partition('.')[0]}"

    def open(self) -> Any:
        """A new page, which waits long."""
        page = self.browser.new_page(viewport={"width": 1100, "height": 720})
        page.set_default_timeout(1000 * TIMEOUT)
        return page

    def kernel_page(self, program: dict[str, Any]) -> Any:
        """A page that holds a flock as `kernel`."""
        page = self.open()
        page.add_script_tag(content=SOURCE)
        page.evaluate(
            "async (program) => { globalThis.kernel = await kernelOf(program); }", program
        )
        return page

    def close(self) -> None:
        """End it."""
        self.browser.close()
        self.playwright.stop()


class Node:
    """node, started anew for each flock."""

    def __init__(self, program: str):
        self.program = program
        version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
        self.name = f"node {version.stdout.strip().removeprefix('v').partition('.')[0]}"

    def positions(self, program: dict[str, Any], ticks: Sequence[int]) -> Positions:
        """Where agents are after each of the ticks. Raises RuntimeFault."""
        with tempfile.TemporaryDirectory() as folder:
            script = Path(folder) / "flight.cjs"
            script.write_text(SOURCE + IN_NODE, "utf-8")
            done = subprocess.run(
                [self.program, str(script)],
                input=json.dumps({"program": program, "ticks": ticks}),
                capture_output=True,
                text=True,
                timeout=TIMEOUT,
            )
        if done.returncode:
            lines = [line for line in done.stderr.splitlines() if "Error" in line]
            raise RuntimeFault(f"{self.name}: {lines[0] if lines else done.stderr.strip()}")
        return decoded(json.loads(done.stdout))

    def close(self) -> None:
        """Nothing is left to end."""


class Firefox:
    """A Firefox without a window, which asks this process for flocks."""

    def __init__(self, program: str):
        version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True)
        self.name = f"Firefox {version.stdout.split()[-1].partition('.')[0]}"
        self.asked: queue.Queue[bytes] = queue.Queue()
        self.found: queue.Queue[Any] = queue.Queue()
        self.server = ThreadingHTTPServer(("127.0.0.1", 0), self.handler())
        self.server.daemon_threads = True
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        self.profile = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        address = f"http://127.0.0.1:{self.server.server_address[1]}/"
        self.process = subprocess.Popen(
            [program, "--headless", "--no-remote", "--profile", self.profile.name, address],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )

    def handler(self) -> type[BaseHTTPRequestHandler]:
        """Serves the page, then one flock after the other as they are asked for."""
        asked, found = self.asked, self.found

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                if self.path == "/next":
                    self.send(asked.get(), "application/json")
                else:
                    self.send(PAGE.encode() if self.path == "/" else b"", "text/html")

            def do_POST(self) -> None:
                found.put(json.loads(self.rfile.read(int(self.headers["Content-Length"]))))
                self.send(b"", "text/plain")

            def send(self, content: bytes, kind: str) -> None:
                self.send_response(200)
                self.send_header("Content-Type", kind)
                self.send_header("Content-Length", str(len(content)))
                self.end_headers()
                self.wfile.write(content)

            def log_message(self, *_: Any) -> None:
                """Say nothing of requests."""

        return Handler

    def positions(self, program: dict[str, Any], ticks: Sequence[int]) -> Positions:
        """Where agents are after each of the ticks. Raises RuntimeFault."""
        self.asked.put(json.dumps({"program": program, "ticks": ticks}).encode())
        try:
            found = self.found.get(timeout=TIMEOUT)
        except queue.Empty:
            raise RuntimeFault(f"{self.name} does not answer") from None
        if isinstance(found, dict):
            raise RuntimeFault(f"{self.name}: {found['error']}")
        return decoded(found)

    def close(self) -> None:
        """End it, and the server."""
        self.process.terminate()
        self.process.wait(30)
        self.server.shutdown()
        self.server.server_close()
        self.profile.cleanup()


def other_runtimes() -> list[Firefox | Node]:
    """Those that are there beside Chromium."""
    runtimes: list[Firefox | Node] = []
    programs = (os.environ.get("FLOCKSCOPE_FIREFOX"), "firefox-esr", "firefox")
    firefox = next((path for name in programs if name and (path := shutil.which(name))), None)
    if firefox is not None:
        runtimes.append(Firefox(firefox))
    if (node := shutil.which("node")) is not None:
        runtimes.append(Node(node))
    return runtimes
