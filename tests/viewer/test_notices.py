"""Notices reach every browser, and none of them twice in a row."""

from __future__ import annotations

import queue
from types import SimpleNamespace

import pytest

from app.front.notices import AGAIN, Notices


@pytest.fixture
def browsers():
    """Two browsers that keep what they are shown, as [(browser, words)]."""
    heard: list[tuple[int, str]] = []

    def browser(number: int) -> SimpleNamespace:
        return SimpleNamespace(
            add_notification=lambda _title, words, **_: heard.append((number, words))
        )

    clients = {number: browser(number) for number in (1, 2)}
    return SimpleNamespace(get_clients=lambda: clients, heard=heard)


def test_each_is_shown_once_in_every_browser_until_some_time_has_passed(browsers):
    waiting: queue.SimpleQueue[str] = queue.SimpleQueue()
    notices = Notices(browsers, waiting)
    for _ in range(50):
        waiting.put("d_r stops")
    notices.tell()
    notices.tell()
    assert sorted(browsers.heard) == [(1, "d_r stops"), (2, "d_r stops")]
    assert waiting.empty()
    notices.shown["d_r stops"] -= AGAIN
    waiting.put("d_r stops")
    notices.tell()
    assert len(browsers.heard) == 4


def test_a_few_are_told_at_a_time_and_none_is_lost(browsers):
    waiting: queue.SimpleQueue[str] = queue.SimpleQueue()
    notices = Notices(browsers, waiting)
    for number in range(7):
        waiting.put(f"notice {number}")
    reported = []
    for _ in range(3):
        notices.tell()
        reported.append(len(browsers.heard) // 2)
    assert reported == [3, 6, 7]
    assert {words for _, words in browsers.heard} == {f"notice {number}" for number in range(7)}
