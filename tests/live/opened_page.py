"""A page of emulated cars in this process, once its room is open."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager

from app.live.laboratory.lab_file import Lab
from app.live.operating.lab_choices import Choices
from app.viewer.live.page import LivePage
from tests.live.waiting import until

BEGINS = 240.0
"""Seconds that a room may take to open: its rule is compiled, by a machine that may be busy."""


@contextmanager
def opened(lab: Lab) -> Iterator[LivePage]:
    """The page of this laboratory with emulated cars, ready to be armed; closed when left."""
    page = LivePage(Choices.of(lab).choosing(source="emulated cars"), port=0)
    try:
        until(
            lambda: page.session.status is not None and page.session.state.phase == "open", BEGINS
        )
        until(lambda: not page.session.status.reasons, BEGINS)
        yield page
    finally:
        page.close()


def arm(page, browser, is_so, within=BEGINS):
    """Arm the cars in a browser, again where a busy machine had them held, until it is so."""

    def tried():
        if page.session.status.arm == "safe" and not page.session.status.reasons:
            browser.arm(page.session.code.digits)
            time.sleep(0.2)
        return is_so()

    until(tried, within)
