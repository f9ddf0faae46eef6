"""Rooms with stub operators for the tests, and what is waited for in them."""

from __future__ import annotations

from app.live.operating.lab_choices import laboratory
from app.viewer.live.session import Session
from tests.viewer.stub_operator import Operators, driver
from tests.viewer.waiting import until

EMULATED = "emulated cars"


class Sessions:
    """Makes rooms, and closes them with all their operators when left."""

    def __init__(self):
        self.operators = Operators()
        self.made: list[Session] = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.operators.gate.set()
        for session in self.made:
            session.close()
            until(lambda session=session: not session.thread.is_alive())
        assert all(operator.closed for operator in self.operators.made)

    def __call__(self, ready=True, driver=driver, **more) -> Session:
        """A room of the example; `ready`: with its first look."""
        session = Session(laboratory(), operator=self.operators, driver=driver, **more)
        self.made.append(session)
        if ready:
            until(lambda: session.status is not None)
        return session


def told(session, words):
    """Wait for a notice with these words; the notices up to it."""
    found = []

    def is_there():
        while not session.notices.empty():
            found.append(session.notices.get())
        return any(words in notice for notice in found)

    until(is_there, what=f"{words!r}, but {found}")
    return found


def armed(session, cause="browser 1"):
    """Arm, and wait until it is so."""
    session.ask("arm", cause)
    until(lambda: session.status is not None and session.status.arm == "armed")
