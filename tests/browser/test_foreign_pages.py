"""A foreign page, in a real browser, opens no connection of the laboratory's and runs nothing in
it.

Each attack is a page of another server; while the served page obeyed its address, they pressed Go
and armed the cars. What a foreign server is asked for is counted and printed.
"""

from __future__ import annotations

from contextlib import contextmanager

import pytest
from viser._messages import RunJavascriptMessage

from app.live.operating.lab_choices import laboratory
from app.viewer.live.page import LivePage
from app.viewer.live.session import Session
from tests.browser.attacker import SCRIPT, Attacker
from tests.viewer.stub_operator import Operators, driver
from tests.viewer.waiting import until

SLOW = 60_000
"""Milliseconds for a page to be there, on a busy machine."""
ONE_LINE = "the address of this page may not name"


@pytest.fixture(scope="module")
def attacker():
    with Attacker() as one:
        yield one
        print(f"\na foreign server was asked for: {dict(one.counts)}")
        assert one.counts["websockets"] == one.counts["recordings"] == 0


@pytest.fixture(scope="module")
def live():
    """The page of a room, with an operator that answers at once."""

    def make_session(choices, recording):
        return Session(choices, recording, operator=Operators(), driver=driver)

    page = LivePage(laboratory(), port=0, make_session=make_session)
    until(lambda: page.session.status is not None)
    yield page
    page.close()


@pytest.fixture(params=["lab", "live lab"])
def target(request, laboratory, live):
    return laboratory if request.param == "lab" else live


@pytest.fixture
def window(chromium):
    """A window, and every websocket that a page in it opens."""
    context = chromium.new_context(viewport={"width": 1000, "height": 640})
    page = context.new_page()
    page.opened = []
    context.on("page", lambda other: watch(other, page.opened))
    watch(page, page.opened)
    yield page
    context.close()


def watch(page, opened) -> None:
    page.on("websocket", lambda line: opened.append(line.url))


@contextmanager
def nothing_happens(target, attacker, window):
    """Within it nobody asks the foreign server for more than its page, nothing runs or is armed."""
    runs = getattr(target, "session", None) is None
    before = attacker.counts.copy()
    yield
    frames = [frame for page in window.context.pages for frame in page.frames]
    assert not [frame.url for frame in frames if frame.evaluate("() => window.owned")]
    assert not [url for url in window.opened if f":{target.port}" not in url]
    assert attacker.counts["websockets"] == before["websockets"]
    assert attacker.counts["recordings"] == before["recordings"]
    if runs:
        assert not target.simulation.state.running
    else:
        assert target.session.status.arm == "safe"
        assert not [event for event in target.session.events if event.kind in ("arm", "code")]


def names(attacker: Attacker) -> list[str]:
    """Addresses of a page that would have it take its messages from the attacker."""
    return [
        f"?websocket={attacker.websocket}",
        f"?a=1&%77ebsocket={attacker.websocket}&websocket=",
        f"?playbackPath={attacker.recording}",
        f"?darkMode&play%62ackPath={attacker.recording}#here",
    ]


def test_a_frame_shows_nothing(target, attacker, window):
    queries = ["", *names(attacker)]
    attacker.page = "".join(
        f'<iframe src="{target.address}/{query}"></iframe>' for query in queries
    )
    with nothing_happens(target, attacker, window):
        window.goto(attacker.address)
        assert len(window.frames) == 1 + len(queries)
        for frame in window.frames[1:]:
            assert frame.url.startswith("chrome-error:") or frame.locator("button").count() == 0
    assert window.opened == []


@pytest.mark.parametrize("how", ["_self", "_blank"])
def test_a_link_is_answered_with_one_line(target, attacker, window, how):
    for query in names(attacker):
        attacker.page = f'<a target="{how}" href="{target.address}/{query}">flocks</a>'
        with nothing_happens(target, attacker, window):
            window.goto(attacker.address)
            window.get_by_text("flocks").click()
            until(lambda: ONE_LINE in window.context.pages[-1].inner_text("body"))
            if how == "_blank":
                window.context.pages[-1].close()
    assert window.opened == []


def test_a_script_or_a_form_of_a_foreign_page_leads_no_further(target, attacker, window):
    lab, line = target.address, attacker.websocket
    attacker.page = f"""
        <form action="{lab}/"><input name="websocket" value="{line}"><button>form</button></form>
        <script src="{lab}/"></script><img src="{lab}/?websocket={line}">
        <object data="{lab}/"></object>
        <script>
          const ws = new WebSocket("ws://localhost:{target.port}", ["viser-v1.1.1"]);
          ws.onclose = () => {{ window.refused = true; }};
          ws.onopen = () => {{ window.owned = true; }};
          fetch("{lab}/", {{mode: "no-cors"}}).catch(() => {{ window.unread = true; }});
        </script>"""
    with nothing_happens(target, attacker, window):
        window.goto(attacker.address)
        until(lambda: window.evaluate("() => window.refused && window.unread"))
        window.opened.clear()  # the one that was refused
        window.get_by_role("button", name="form").click()
        until(lambda: ONE_LINE in window.inner_text("body"))


def test_a_plain_link_shows_the_page_which_listens_to_its_own_server_alone(
    target, attacker, window
):
    """Also with a fragment, and whatever the page that opened it does to its window."""
    query = f"?dummyWindowDimensions=1x1#?websocket={attacker.websocket}"
    attacker.page = f"""
        <button onclick="window.lab = window.open('{target.address}/{query}')">go</button>
        <script>
          const message = {{type: "RunJavascriptMessage", source: "window.owned = 1"}};
          setInterval(() => {{ if (window.lab) lab.postMessage(message, "*"); }}, 100);
        </script>"""
    with nothing_happens(target, attacker, window):
        window.goto(attacker.address)
        with window.context.expect_page() as opening:
            window.get_by_text("go").click()
        page = opening.value
        page.locator(".fs-card, .fs-banner").first.wait_for(timeout=SLOW)
        assert page.url == f"{target.address}/"
        assert page.evaluate("() => window.opener") is None
        assert window.opened == [f"ws://localhost:{target.port}/"]

        line = attacker.websocket
        broken = page.evaluate(
            """address => new Promise(told => {
                document.addEventListener("securitypolicyviolation", found =>
                  told(found.effectiveDirective));
                new WebSocket(address); })""",
            line,
        )
        assert broken == "connect-src"
        page.evaluate("address => history.replaceState(null, '', '/?websocket=' + address)", line)
        assert page.url == f"{target.address}/"


def test_what_a_message_brings_is_not_run_even_if_it_is_our_own_server_s(served, window):
    """Neither a script, nor a handler in HTML, nor an address that is one."""
    window.goto(served.address)
    window.locator(".fs-card").first.wait_for(timeout=SLOW)
    clients = served.server.get_clients()
    client = clients[max(clients)]
    client.gui.add_html(
        '<img src="data:," onerror="window.owned = 1"><script>window.owned = 1</script>'
        '<a id="bad" href="javascript:window.owned = 1">link</a>'
    )
    with window.expect_event("pageerror", lambda error: "unsafe-eval" in str(error)):
        client._websock_connection.queue_message(RunJavascriptMessage(SCRIPT))
    window.locator("#bad").evaluate("link => link.click()")
    assert window.evaluate("() => window.owned") is None
    assert window.title() != "owned"
