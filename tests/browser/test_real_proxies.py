"""A class behind nginx and Caddy, as docs/behind-a-proxy.md configures them, in a real browser.

FLOCKSCOPE_BROWSER_TESTS=required makes a missing proxy an error, as a missing browser.
"""

from __future__ import annotations

import shutil
from urllib.parse import urlsplit

import pytest

from tests.browser.conftest import POLICY, absent
from tests.browser.real_proxy import NAME, RealProxy, free_port
from tests.classroom.running import Person, roster, running
from tests.viewer.waiting import COMPILED, until

SLOW = 1000 * COMPILED


@pytest.fixture(
    scope="module", params=[("nginx", ""), ("nginx", "/flocks"), ("caddy", "")], ids="".join
)
def proxied(request, tmp_path_factory):
    """A class, and the proxy before it."""
    kind, below = request.param
    if shutil.which(kind) is None:
        absent(kind)
    port, folder = free_port(), tmp_path_factory.mktemp("class")
    with (
        running(folder, "--allow-host", f"{NAME}:{port}") as served,
        RealProxy(kind, folder, port, inner_port(served), below) as proxy,
    ):
        yield served, proxy


def inner_port(served) -> int:
    """Where the class is itself, whatever name it gives to students."""
    return int(urlsplit(served.teachers_link).port)


def teacher_of(served) -> Person:
    """The teacher, who comes from the machine itself."""
    person = Person(inner_port(served))
    assert person.form("/teach", key=key_of(served)).status == 303
    return person


def key_of(served) -> str:
    return served.teachers_link.rpartition("/")[2]


def tick(page) -> int:
    text = page.locator(".fs-card", has_text="tick").first.locator("b").inner_text()
    return int(text) if text.isdecimal() else -1


def test_a_student_enters_and_runs_a_flock(chromium, proxied):
    served, proxy = proxied
    outer = f"https://{NAME}:{proxy.port}{proxy.below}"
    context = chromium.new_context(
        viewport={"width": 1000, "height": 700}, ignore_https_errors=True
    )
    page = context.new_page()
    teacher = teacher_of(served)
    assert teacher.do("role", role="own").status == 200
    lines, said = [], []
    page.on("websocket", lambda line: lines.append(line.url))
    page.on("console", lambda one: said.append(one.text))
    try:
        assert page.goto(f"{outer}/").status == 403
        page.goto(f"{outer}/{served.code}")
        page.get_by_label("Your name").fill("Ada")
        page.get_by_role("button", name="Join the class").click()
        page.locator(".fs-card").first.wait_for(timeout=SLOW)
        assert page.url == f"{outer}/"
        until(lambda: tick(page) > 5, COMPILED, "a flock that runs")
        page.get_by_role("button", name="Pause", exact=True).click()
        page.get_by_role("button", name="Go", exact=True).wait_for(timeout=SLOW)
        assert set(lines) == {f"wss://{NAME}:{proxy.port}{proxy.below or '/'}"}
        assert not [one for one in said if POLICY in one]
        (cookie,) = context.cookies()
        assert cookie["secure"]
        assert cookie["httpOnly"]
        assert cookie["sameSite"] == "Strict"
        assert [one["name"] for one in roster(teacher)["students"]] == ["Ada"]
        page.goto(f"{outer}/{key_of(served)}")
        page.get_by_text("Ada").first.wait_for(timeout=SLOW)
        assert served.code not in proxy.written
        assert key_of(served) not in proxy.written
    finally:
        context.close()


def test_by_another_name_nobody_is_let_in(chromium, proxied):
    served, proxy = proxied
    context = chromium.new_context(ignore_https_errors=True)
    page = context.new_page()
    address = f"https://other.localhost:{proxy.port}{proxy.below}/{served.code}"
    try:
        if proxy.kind == "nginx":
            assert page.goto(address).status == 403
        else:
            with pytest.raises(Exception, match="ERR_SSL"):  # it has no certificate for that name
                page.goto(address)
    finally:
        context.close()
