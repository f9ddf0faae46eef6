"""No browser arms without the code that the terminal shows."""

from __future__ import annotations

import threading

import pytest

from app.cli.live.lab import SessionConsole
from app.cli.terminal.progress import StopSignals
from app.viewer.live.panels.log_panel import as_csv
from app.viewer.live.panels.state_panel import banner_of
from app.viewer.live.session import DIGITS, TRIES, ArmingCode
from tests.viewer.live_sessions import Sessions, told
from tests.viewer.waiting import until


@pytest.fixture
def sessions():
    with Sessions() as made:
        yield made


def wrong(code: ArmingCode, times: int = 1) -> list[str]:
    """Codes that are not the right one."""
    return [f"{(int(code.digits) + 1 + k) % 10**DIGITS:06d}" for k in range(times)]


def code_events(session):
    return [(event.words, event.cause) for event in session.events if event.kind == "code"]


def test_codes_are_six_digits_and_made_by_chance():
    made = {ArmingCode().digits for _ in range(200)}
    assert all(len(one) == DIGITS and one.isdigit() and one.isascii() for one in made)
    assert len(made) > 190


@pytest.mark.parametrize(
    "entered", ["", "12345", "1234567", "12345a", "１２３４５６", "1 23456", "-12345"]
)
def test_what_cannot_be_a_code_is_no_try(entered):
    code = ArmingCode()
    assert [code.check(entered) for _ in range(20)] == ["no code"] * 20
    assert code.left == TRIES


def test_five_wrong_codes_and_even_the_right_one_is_not_taken():
    code = ArmingCode()
    assert [code.check(one) for one in wrong(code, 4)] == ["wrong"] * 4
    assert code.check(f" {code.digits}\n") == "right"
    assert code.left == 1
    assert code.check(*wrong(code)) == "wrong"
    assert code.is_off
    assert [code.check(code.digits), code.check(""), code.left] == ["off", "off", 0]


def test_many_at_once_have_five_tries_together():
    code, verdicts = ArmingCode(), []
    guesses = wrong(code, 400)
    threads = [
        threading.Thread(
            target=lambda part: verdicts.extend(map(code.check, part)),
            args=(part,),
        )
        for part in (guesses[k::8] for k in range(8))
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert verdicts.count("wrong") == TRIES
    assert verdicts.count("off") == 400 - TRIES
    print(f"{len(verdicts)} guesses from 8 threads: {TRIES} were looked at")


def test_a_browser_with_the_code_arms_and_both_are_events(sessions):
    session = sessions()
    assert session.arm_by_code(session.code.digits, "browser 3") == "right"
    until(lambda: session.status.arm == "armed")
    assert code_events(session) == [("the right code", "browser 3")]
    assert [(one.action, one.cause) for one in sessions.operators.last.asked] == [
        ("arm", "browser 3")
    ]


def test_wrong_codes_arm_nothing_are_told_and_end_arming_from_browsers_alone(sessions):
    session = sessions()
    for number, guess in enumerate(wrong(session.code, TRIES)):
        assert session.arm_by_code(guess, f"browser {number}") == "wrong"
    assert session.arm_by_code(session.code.digits, "browser 9") == "off"
    assert [cause for _, cause in code_events(session)] == [f"browser {k}" for k in range(TRIES)]
    assert code_events(session)[0][0] == "a wrong code: 4 more and no browser arms"
    assert code_events(session)[-1][0] == "a wrong code: no browser arms until the next start"
    told(session, "a wrong code to arm (browser 4): no browser arms until the next start")
    assert sessions.operators.last.asked == []

    until(lambda: session.status is not None)
    now = banner_of(session.state, session.status)
    assert not now.can_be_armed
    assert "terminal" in now.reasons[0]
    SessionConsole(session, StopSignals(), verbose=False).handle_key("a")
    until(lambda: session.status.arm == "armed")
    session.emergency("browser 9")
    until(lambda: session.status.arm == "emergency")


def test_another_opening_of_the_room_gives_no_more_tries(sessions):
    session = sessions()
    for guess in wrong(session.code, TRIES):
        session.arm_by_code(guess, "browser 1")
    code, run = session.code, session.state.run
    session.reopen("browser 1")
    until(lambda: session.state.run > run and session.state.phase == "open")
    assert session.code is code
    assert not session.state.browsers_arm
    assert session.arm_by_code(code.digits, "browser 1") == "off"


def test_neither_the_code_nor_a_guess_is_written_down(sessions, capsys):
    session = sessions()
    console = SessionConsole(session, StopSignals(), verbose=True)
    guesses = wrong(session.code, 3)
    for guess in (*guesses, session.code.digits):
        session.arm_by_code(guess, "browser 1")
    until(lambda: session.status.arm == "armed")
    console.print_news()
    printed = capsys.readouterr()
    written = (
        as_csv(session.events)
        + printed.out
        + printed.err
        + repr(session.state)
        + repr(session.code)
    )
    assert "the right code" in written
    assert not [one for one in (*guesses, session.code.digits) if one in written]
