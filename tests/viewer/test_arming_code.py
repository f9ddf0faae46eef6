"""No browser arms without the code that the terminal shows."""

from __future__ import annotations

import threading

import pytest

from app.cli.live.console import Console
from app.cli.stopping import Stopping
from app.viewer.live.arming_code import DIGITS, TRIES, ArmingCode
from app.viewer.live.panels.log import as_csv
from app.viewer.live.standing import standing
from tests.viewer.live_rooms import Rooms, told
from tests.viewer.waiting import until


@pytest.fixture
def rooms():
    with Rooms() as made:
        yield made


def wrong(code: ArmingCode, times: int = 1) -> list[str]:
    """Codes that are not the right one."""
    return [f"{(int(code.digits) + 1 + k) % 10**DIGITS:06d}" for k in range(times)]


def code_events(room):
    return [(event.words, event.cause) for event in room.events if event.kind == "code"]


def test_codes_are_six_digits_and_made_by_chance():
    made = {ArmingCode().digits for _ in range(200)}
    assert all(len(one) == DIGITS and one.isdigit() and one.isascii() for one in made)
    assert len(made) > 190


@pytest.mark.parametrize(
    "entered", ["", "12345", "1234567", "12345a", "１２３４５６", "1 23456", "-12345"]
)
def test_what_cannot_be_a_code_is_no_try(entered):
    code = ArmingCode()
    assert [code.tried(entered) for _ in range(20)] == ["no code"] * 20
    assert code.left == TRIES


def test_five_wrong_codes_and_even_the_right_one_is_not_taken():
    code = ArmingCode()
    assert [code.tried(one) for one in wrong(code, 4)] == ["wrong"] * 4
    assert code.tried(f" {code.digits}\n") == "right"
    assert code.left == 1
    assert code.tried(*wrong(code)) == "wrong"
    assert code.off
    assert [code.tried(code.digits), code.tried(""), code.left] == ["off", "off", 0]


def test_many_at_once_have_five_tries_together():
    code, verdicts = ArmingCode(), []
    guesses = wrong(code, 400)
    threads = [
        threading.Thread(target=lambda part: verdicts.extend(map(code.tried, part)), args=(part,))
        for part in (guesses[k::8] for k in range(8))
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert verdicts.count("wrong") == TRIES
    assert verdicts.count("off") == 400 - TRIES
    print(f"{len(verdicts)} guesses from 8 threads: {TRIES} were looked at")


def test_a_browser_with_the_code_arms_and_both_are_events(rooms):
    room = rooms()
    assert room.arm_by_code(room.code.digits, "browser 3") == "right"
    until(lambda: room.look.arm == "armed")
    assert code_events(room) == [("the right code", "browser 3")]
    assert [(one.wish, one.cause) for one in rooms.desks.last.asked] == [("arm", "browser 3")]


def test_wrong_codes_arm_nothing_are_told_and_end_arming_from_browsers_alone(rooms):
    room = rooms()
    for number, guess in enumerate(wrong(room.code, TRIES)):
        assert room.arm_by_code(guess, f"browser {number}") == "wrong"
    assert room.arm_by_code(room.code.digits, "browser 9") == "off"
    assert [cause for _, cause in code_events(room)] == [f"browser {k}" for k in range(TRIES)]
    assert code_events(room)[0][0] == "a wrong code: 4 more and no browser arms"
    assert code_events(room)[-1][0] == "a wrong code: no browser arms until the next start"
    told(room, "a wrong code to arm (browser 4): no browser arms until the next start")
    assert rooms.desks.last.asked == []

    until(lambda: room.look is not None)
    now = standing(room.state, room.look)
    assert not now.armable
    assert "terminal" in now.reasons[0]
    Console(room, Stopping(), said=False).obey("a")
    until(lambda: room.look.arm == "armed")
    room.emergency("browser 9")
    until(lambda: room.look.arm == "emergency")


def test_another_opening_of_the_room_gives_no_more_tries(rooms):
    room = rooms()
    for guess in wrong(room.code, TRIES):
        room.arm_by_code(guess, "browser 1")
    code, run = room.code, room.state.run
    room.reopen("browser 1")
    until(lambda: room.state.run > run and room.state.status == "open")
    assert room.code is code
    assert not room.state.browsers_arm
    assert room.arm_by_code(code.digits, "browser 1") == "off"


def test_neither_the_code_nor_a_guess_is_written_down(rooms, capsys):
    room = rooms()
    console = Console(room, Stopping(), said=True)
    guesses = wrong(room.code, 3)
    for guess in (*guesses, room.code.digits):
        room.arm_by_code(guess, "browser 1")
    until(lambda: room.look.arm == "armed")
    console.see()
    printed = capsys.readouterr()
    written = as_csv(room.events) + printed.out + printed.err + repr(room.state) + repr(room.code)
    assert "the right code" in written
    assert not [one for one in (*guesses, room.code.digits) if one in written]
