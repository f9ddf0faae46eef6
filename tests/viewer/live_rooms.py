"""Rooms with stub desks for the tests, and what is waited for in them."""

from __future__ import annotations

from app.live.operating.choices import laboratory
from app.viewer.live.room import Room
from tests.viewer.stub_desk import Desks, driver
from tests.viewer.waiting import until

EMULATED = "emulated cars"


class Rooms:
    """Makes rooms, and closes them with all their desks when left."""

    def __init__(self):
        self.desks = Desks()
        self.made: list[Room] = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.desks.gate.set()
        for room in self.made:
            room.close()
            until(lambda room=room: not room.thread.is_alive())
        assert all(desk.closed for desk in self.desks.made)

    def __call__(self, ready=True, driver=driver, **more) -> Room:
        """A room of the example; `ready`: with its first look."""
        room = Room(laboratory(), desk=self.desks, driver=driver, **more)
        self.made.append(room)
        if ready:
            until(lambda: room.look is not None)
        return room


def told(room, words):
    """Wait for a notice with these words; the notices up to it."""
    found = []

    def is_there():
        while not room.notices.empty():
            found.append(room.notices.get())
        return any(words in notice for notice in found)

    until(is_there, what=f"{words!r}, but {found}")
    return found


def armed(room, cause="browser 1"):
    """Arm, and wait until it is so."""
    room.ask("arm", cause)
    until(lambda: room.look is not None and room.look.arm == "armed")
