"""What students may be called."""

from __future__ import annotations

import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

from app.classroom.student import MOST_LETTERS, same, student_name, unique_name
from worlds.input_error import InputError


@pytest.mark.parametrize(
    ("given_text", "name"),
    [
        ("Ada", "Ada"),
        ("  Ada \u00a0  Lovelace\u3000", "Ada Lovelace"),
        ("Zoe\u0308", "Zoë"),
        ("O'Neill-Śmigły (2)", "O'Neill-Śmigły (2)"),
        ("山田太郎", "山田太郎"),
        ("فاطمة", "فاطمة"),
        ("शशि", "शशि"),
        ("<b>&amp;", "<b>&amp;"),
        ("7", "7"),
    ],
)
def test_names_of_any_script_are_kept(given_text, name):
    assert student_name(given_text) == name


@pytest.mark.parametrize(
    "text",
    [
        "", "   ", None, 7, ["Ada"], b"Ada", "x" * 31, " " * 600, "a\nb", "a\tb", "a\x00b",
        "a\u202eb", "a\u2066b", "a\u200bb", "a\u200db", "\ufeffa", "a\ud800", "\ue000",
        "\U000e0041a", "\u0301\u0302", "\u0301a", "a" + "\u0329" * 5, "\u3164",
        "\u2800", "a\u115f", "...", "🐦",
        "=1+1", "+1", "-2", "@SUM(A1)", "＝1", " =cmd",
    ],
)  # fmt: skip
def test_what_cannot_be_shown_is_refused_in_one_printable_line(text):
    with pytest.raises(InputError) as refused:
        student_name(text)
    assert str(refused.value).isascii()
    assert "\n" not in str(refused.value)


@given(st.text(max_size=60))
def test_a_name_is_short_printable_normal_and_stays_itself(text):
    try:
        name = student_name(text)
    except InputError:
        return
    assert 1 <= len(name) <= MOST_LETTERS
    assert name == name.strip() == unicodedata.normalize("NFC", name) == student_name(name)
    assert "  " not in name
    assert not [one for one in name if unicodedata.category(one)[0] == "C"]
    assert any(unicodedata.category(one)[0] in "LN" for one in name)
    assert name.encode("utf-8").decode("utf-8") == name


@given(st.lists(st.sampled_from(["Ada", "ada", "ADA", "Ａda", "x" * 30, "X" * 30]), max_size=12))
def test_no_two_students_have_the_same_name(wanted):
    taken: list[str] = []
    for name in wanted:
        taken.append(unique_name(student_name(name), taken))
        assert student_name(taken[-1]) == taken[-1]
    assert len({same(name) for name in taken}) == len(taken)


def test_a_thousand_of_one_name_are_enough():
    taken = ["Ada", *(f"Ada {k}" for k in range(2, 1001))]
    with pytest.raises(InputError, match="there are 1000 of that name"):
        unique_name("Ada", taken)
