"""Pages of flocks, opened from their files."""

from __future__ import annotations

from contextlib import contextmanager

import pytest

from agents.flock import Flock
from app.viewer.lab.flock_page import PLAIN_WORDS, PageWords, flock_page
from tests.viewer.waiting import until

PAGES: dict[str, str] = {}
"""Pages by what their flocks are: a page takes seconds to compile, and several tests open it."""


def page_text(flock: Flock, words: PageWords = PLAIN_WORDS) -> str:
    """The page of a flock that stands at its start."""
    key = repr((flock.spec, flock.seed, words))
    if key not in PAGES:
        PAGES[key] = flock_page(flock, words)
    return PAGES[key]


@pytest.fixture
def opened(chromium, tmp_path):
    """Opens the page of a flock from its file; notes what it asks of any network, and errors.

    `script` runs before the page's own; `without` is what a browser lacks.
    """
    asked: list[str] = []
    errors: list[str] = []

    @contextmanager
    def opens(
        flock: Flock,
        script: str = "",
        without: str = "",
        words: PageWords = PLAIN_WORDS,
        **options,
    ):
        file = tmp_path / "flock.html"
        file.write_text(page_text(flock, words), encoding="utf-8")
        page = chromium.new_page(**{"viewport": {"width": 1100, "height": 720}} | options)
        page.on("request", lambda request: asked.append(request.url))
        page.on("pageerror", lambda error: errors.append(str(error)))
        if without:
            script += f"delete globalThis.{without}"
        if script:
            page.add_init_script(script)
        page.goto(file.as_uri())
        until(lambda: page.evaluate("'page' in globalThis"), 60, "the flock to be there")
        try:
            yield page
            assert errors == []
            assert {url.partition(":")[0] for url in asked} <= {"file", "data", "blob"}
        finally:
            page.close()

    return opens
