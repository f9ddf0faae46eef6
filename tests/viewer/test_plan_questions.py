"""A drawing that may mean two things is asked about in the browser that has opened it."""

from __future__ import annotations

import asyncio
from types import SimpleNamespace

import pytest

from app.viewer.lab.panels.plan_questions import PlanQuestions
from worlds.readers.drawing_contents import PlanChoice, PlanQuestion

QUESTION = PlanQuestion(
    "house.wkt: it is <all>: give --solid A",
    (
        PlanChoice("Solid block", {"roles": {"obstacle": ["A"]}}),
        PlanChoice("Walls", {"roles": {"wall": ["A"]}}, thickness=True),
    ),
)


class Window:
    """What of viser's gui a question uses, and what was put there."""

    def __init__(self):
        self.words, self.buttons, self.numbers, self.closed = [], {}, [], False

    def add_modal(self, _title):
        return self

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def close(self):
        self.closed = True

    def add_html(self, content):
        self.words.append(content)

    def add_number(self, _label, value, **_):
        self.numbers.append(SimpleNamespace(value=value))
        return self.numbers[-1]

    def add_button(self, label, **_):
        def on_click(answer):
            self.buttons[label] = answer

        return SimpleNamespace(on_click=on_click)


def questions_on(edits):
    """The questions of a page of which no browser leaves."""
    server = SimpleNamespace(on_client_disconnect=lambda _: None)
    return PlanQuestions(server, SimpleNamespace(edits=edits))


class Edits:
    """Commands to the simulation: the first file is asked about, what follows is taken."""

    def __init__(self):
        self.calls = []

    def open_layout(self, name, content, options, ask):
        self.calls.append((name, content, options))
        if len(self.calls) == 1:
            ask(QUESTION)


@pytest.mark.parametrize(
    ("label", "options"),
    [
        ("Solid block", {"roles": {"obstacle": ["A"]}}),
        ("Walls", {"roles": {"wall": ["A"]}, "thickness": 0.35}),
        ("Cancel", None),
    ],
)
def test_an_answer_opens_the_drawing_again_with_it(label, options):
    edits, window = Edits(), Window()
    client = SimpleNamespace(gui=window, client_id=3)

    async def browse():
        questions_on(edits).open_layout(client, "house.wkt", b"...")
        while not window.buttons:  # the question comes from another thread
            await asyncio.sleep(0)
        window.numbers[0].value = 0.35
        await window.buttons[label](None)

    asyncio.run(asyncio.wait_for(browse(), 60.0))
    assert window.closed
    assert list(window.buttons) == ["Solid block", "Walls", "Cancel"]
    assert "it is &lt;all&gt;." in window.words[0]
    assert "--solid" not in window.words[0]
    again = [] if options is None else [("house.wkt", b"...", options)]
    assert edits.calls == [("house.wkt", b"...", {}), *again]


def test_a_browser_holds_one_question_and_none_once_it_has_gone():
    questions = questions_on(None)
    windows = [Window() for _ in range(3)]
    for window in windows:
        client = SimpleNamespace(gui=window, client_id=3)
        questions.ask(client, "house.wkt", b"...", {}, QUESTION)
    other = SimpleNamespace(gui=Window(), client_id=4)
    questions.ask(other, "house.wkt", b"...", {}, QUESTION)
    assert [window.closed for window in windows] == [True, True, False]
    assert questions.open == {3: windows[2], 4: other.gui}
    asyncio.run(questions.forget_client(client))
    assert questions.open == {4: other.gui}
