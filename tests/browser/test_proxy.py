"""A page behind a reverse proxy with a path of its own, as of JupyterHub, in a real browser."""

from __future__ import annotations

import pytest

from app.front.origin import parse_allowed_host
from app.front.page_front import Front
from app.front.server import admit_browsers, close_server, open_server
from tests.browser.proxy import PREFIX, Proxy

SLOW = 60_000
HUB = "hub.localhost"
"""A name that browsers find on this machine, but that is not this machine's own."""


@pytest.mark.parametrize("host", [None, "localhost:8080"], ids=["its own Host", "the inner Host"])
def test_a_page_behind_an_allowed_proxy_works_and_can_be_loaded_again(chromium, host):
    front = Front()
    server = open_server(port=0, front=front)
    server.gui.add_html('<div id="here">a flock</div>')
    admit_browsers(server)
    page = chromium.new_page(viewport={"width": 1000, "height": 600})
    lines: list[str] = []
    page.on("websocket", lambda line: lines.append(line.url))
    try:
        with Proxy(server.get_port(), host) as proxy:
            outer = f"http://{HUB}:{proxy.port}{PREFIX}"
            refused = page.goto(f"{outer}/").status
            assert refused == (403 if host is None else 200)
            lines.clear()

            front.allow = (parse_allowed_host(f"{HUB}:{proxy.port}"),)
            page.goto(f"{outer}/?token=1")
            page.locator("#here").wait_for(timeout=SLOW)
            assert page.url == f"{outer}/"
            page.reload()
            page.locator("#here").wait_for(timeout=SLOW)
            assert page.url == f"{outer}/"
            assert set(lines) == {f"ws://{HUB}:{proxy.port}{PREFIX}"}
            assert page.goto(f"{outer}/?websocket=ws://127.0.0.1:1").status == 400
    finally:
        page.close()
        close_server(server)
