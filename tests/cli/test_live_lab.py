"""`flockscope live lab`: the page and the terminal beside it."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from app.cli.live.lab import SessionConsole, lab
from app.cli.terminal.progress import StopSignals
from app.live.control.loop_status import Event
from worlds.input_error import InputError


class StubSession:
    """A session that only takes down what is asked of it."""

    def __init__(self, *events, trouble=""):
        phase = "failed" if trouble else "open"
        self.state = SimpleNamespace(phase=phase, trouble=trouble)
        self.events = list(events)
        self.asked = []

    def ask(self, action, cause):
        self.asked.append((action, cause))

    def emergency(self, cause):
        self.asked.append(("emergency", cause))


@pytest.mark.parametrize(
    ("pressed", "actions"),
    [
        ("a", ["arm"]),
        ("d", ["disarm"]),
        ("r", ["reset"]),
        (" ", ["emergency"]),
        ("x", ["emergency"]),
        ("ra", ["reset", "arm"]),
        ("ra ", ["emergency"]),
        ("", []),
    ],
)
def test_any_key_that_means_nothing_else_is_the_emergency_stop(pressed, actions):
    session = StubSession()
    SessionConsole(session, StopSignals(), verbose=False).handle_key(pressed)
    assert session.asked == [(action, "terminal") for action in actions]


def test_it_prints_each_event_once_and_why_a_room_is_not_open(capsys):
    session = StubSession(
        Event(1, 1.0, "arm", "armed", cause="browser 2"), trouble="no frame within 5 s"
    )
    console = SessionConsole(session, StopSignals(), verbose=True)
    console.print_news()
    console.print_news()
    told = capsys.readouterr()
    assert told.out.split() == ["0.00", "s", "arm", "armed", "(browser", "2)"]
    assert told.err == "no frame within 5 s\n"


def test_quiet_it_prints_no_event(capsys):
    SessionConsole(
        StubSession(Event(1, 1.0, "arm", "armed")), StopSignals(), verbose=False
    ).print_news()
    assert capsys.readouterr().out == ""


def test_an_unknown_source_is_refused_before_anything_is_opened():
    with pytest.raises(InputError, match="unknown source 'nowhere'"):
        lab(source="nowhere", open_browser=False)
