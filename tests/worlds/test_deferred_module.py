"""Modules that are put off, asked for by two threads at once."""

from __future__ import annotations

import sys
import threading

from worlds import deferred_module
from worlds.deferred_module import DeferredModule


class ObservedLock:
    """A lock that says when somebody has to wait for it."""

    def __init__(self, on_wait):
        self._lock, self._on_wait = threading.Lock(), on_wait

    def __enter__(self):
        if not self._lock.acquire(blocking=False):
            self._on_wait()
            self._lock.acquire()

    def __exit__(self, *_):
        self._lock.release()


class PausingName(str):
    """The name of a module; whoever looks at it first lets another thread go before."""

    def __new__(cls, name, pause):
        self = super().__new__(cls, name)
        self.pause = pause
        return self

    def partition(self, separator):
        pause, self.pause = self.pause, None
        if pause is not None:
            pause()
        return super().partition(separator)


def test_two_threads_that_ask_at_once_get_the_same_module(tmp_path, monkeypatch):
    """One is stopped while it takes placeholders away; the other then comes to its end or waits."""
    package = tmp_path / "asked_at_once"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "part.py").write_text("value = object()\n")
    monkeypatch.syspath_prepend(tmp_path)
    came_or_waits, values, faults = threading.Event(), [], []

    def ask():
        try:
            values.append(placeholder.value)
        except BaseException as fault:
            faults.append(fault)
        finally:
            came_or_waits.set()

    second = threading.Thread(target=ask)

    def let_second_go():
        second.start()
        came_or_waits.wait()

    monkeypatch.setattr(deferred_module, "REPLACING", ObservedLock(came_or_waits.set), False)
    placeholder = DeferredModule("asked_at_once.part")
    monkeypatch.setitem(sys.modules, "asked_at_once", DeferredModule("asked_at_once"))
    name = PausingName("asked_at_once.part", let_second_go)
    monkeypatch.setitem(sys.modules, name, placeholder)
    values.append(placeholder.value)
    second.join()
    assert not faults
    assert values[0] is values[1] is sys.modules["asked_at_once.part"].value
