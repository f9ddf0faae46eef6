"""What a page asks for whose person steers an agent, as strangers may ask for it too."""

from __future__ import annotations

from urllib.parse import urlencode

import numpy as np
import pytest

from agents.kinds import Kind
from app.steering.hand_pilot import SILENCE, HandMotion
from app.viewer.lab.laboratory import Laboratory
from app.viewer.run.run_preset import preset_spec
from tests.viewer.http_client import ask
from tests.viewer.waiting import COMPILED, until

MARKED = {"X-Flockscope": "scene"}
WHO = "0123456789abcdef" * 2


@pytest.fixture(scope="module")
def laboratory():
    kinds = [Kind("robot", 1, steered=True), Kind("drone", 1)]
    spec = preset_spec("vem", agents=20, seed=2).but(kinds=kinds)
    made = Laboratory(spec, port=0, running=False)
    assert made.simulation.ready.wait(COMPILED)
    until(lambda: made.simulation.state.compiling is None, COMPILED)
    until(lambda: made.simulation.frame is not None)
    yield made
    made.close()


@pytest.fixture
def hands(laboratory):
    """The people who steer, nobody yet, by a clock that stands."""
    hands = laboratory.simulation.hands
    hands.begin()
    hands.last.clear()
    hands.clock = lambda: 5.0
    return hands


def robot(laboratory) -> int:
    frame = laboratory.simulation.frame
    return int(frame.ids[np.flatnonzero(frame.kind == 1)[0]])


def steered(laboratory, path="/steer", headers=MARKED, **changes):
    """What is answered to a page that steers the robot to the left, with some things changed."""
    frame = laboratory.simulation.frame
    told = {"who": WHO, "n": 1, "agent": robot(laboratory), "run": frame.run}
    told |= {"turn": "1.000", "push": "0.000", "climb": "0.000"} | changes
    told = {name: value for name, value in told.items() if value is not None}
    return ask(laboratory.port, f"{path}?{urlencode(told, doseq=True)}", headers)


def test_a_page_steers_and_all_pages_read_who_is_steered(laboratory, hands):
    assert steered(laboratory).status == 200
    (hand,) = hands.hands.values()
    assert hand.motion == HandMotion(1.0, 0.0, 0.0)
    words = f"Steered by hand: agent {robot(laboratory)}"
    laboratory.simulation.step()
    laboratory.refresh()
    assert words in laboratory.run.status.content
    laboratory.select(int(np.flatnonzero(laboratory.simulation.frame.kind == 1)[0]))
    assert steered(laboratory, path="/steer/end", n=2).status == 200
    assert hands.steered == frozenset()
    laboratory.refresh()
    assert words not in laboratory.run.status.content


def test_silence_is_noticed_while_the_flock_stands(laboratory, hands):
    steered(laboratory)
    hands.clock = lambda: 5.1 + SILENCE
    laboratory.want()
    assert hands.hands == {}


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"who": "you"}, "who is not as it must be"),
        ({"who": None}, "who is not as it must be"),
        ({"who": [WHO, WHO]}, "who is not as it must be"),
        ({"turn": "nan"}, "turn is not as it must be"),
        ({"turn": "1.1"}, "turn is not as it must be"),
        ({"turn": "1e9"}, "turn is not as it must be"),
        ({"push": None}, "push is not as it must be"),
        ({"agent": "-1"}, "agent is not as it must be"),
        ({"agent": "9" * 400}, "agent is not as it must be"),
        ({"agent": "1"}, "agent 1 cannot be steered"),
        ({"agent": "22"}, "agent 22 cannot be steered"),
        ({"agent": "999"}, "agent 999 cannot be steered"),
        ({"run": "0"}, "another run has begun"),
        ({"n": "x"}, "n is not as it must be"),
        ({"a": "1", "b": "1"}, "more than 8 parameters"),
    ],
)
def test_what_cannot_be_is_refused_in_a_line(laboratory, hands, changes, told):
    answer = steered(laboratory, **changes)
    assert answer.status == 400
    assert told in answer.text
    assert "\n" not in answer.text.strip()
    assert hands.hands == {}


@pytest.mark.usefixtures("hands")
def test_another_page_and_a_foreign_page_are_refused(laboratory):
    assert steered(laboratory).status == 200
    answer = steered(laboratory, who="f" * 32)
    assert answer.status == 400
    assert "somebody else steers agent" in answer.text
    assert steered(laboratory, headers={}).status == 403
    foreign = MARKED | {"Origin": "http://example.org"}
    assert steered(laboratory, headers=foreign, n=2).status == 403


@pytest.mark.usefixtures("hands")
def test_a_page_that_says_too_much_is_not_heard(laboratory):
    statuses = [steered(laboratory, who="c" * 32, n=n).status for n in range(100)]
    assert 429 in statuses
    assert set(statuses) == {200, 429}
