"""What may be chosen in a laboratory: nothing but its file's texts and the two built-in ones."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.live.links.link_catalogue import open_link
from app.live.operating.lab_choices import SIMULATED, Choices
from app.live.sources.source_catalogue import open_source
from live.rooms import LAB, lab
from worlds.input_error import InputError

MORE = """
[sources]
"second room" = "optitrack:192.168.1.5?up=y"
monday = "recorded:monday.csv"

[links]
radio = "serial:/dev/ttyUSB0?baud=57600"
"""
ROOM = LAB.replace('"none"', '"squashing"') + MORE
SOFTWARE = ROOM.replace('"mock:"', '"simulated"').replace('"dry"', '"simulated?port=5005"', 1)
TEXTS = {"mock:", "optitrack:192.168.1.5?up=y", "recorded:monday.csv", SIMULATED}
CARRIERS = {"dry", "serial:/dev/ttyUSB0?baud=57600", SIMULATED}


def choosing(one, source, link, rule):
    """The laboratory with these chosen, by name."""
    return Choices.of(one).choosing(source=source, link=link, rule=rule).lab


def test_the_files_own_come_first_and_the_built_in_ones_last():
    assert list(Choices.of(lab(ROOM)).sources.items()) == [
        ("mock:", "mock:"),
        ("second room", "optitrack:192.168.1.5?up=y"),
        ("monday", "recorded:monday.csv"),
        ("emulated cars", "simulated"),
    ]
    radio = lab(ROOM.replace('"dry"', '"chain:/dev/ttyS0"'))
    assert list(Choices.of(radio).links.items()) == [
        ("chain:/dev/ttyS0", "chain:/dev/ttyS0"),
        ("radio", "serial:/dev/ttyUSB0?baud=57600"),
        ("dry run", "dry"),
    ]


def test_what_is_built_in_is_listed_once():
    assert list(Choices.of(lab(ROOM)).links) == ["dry run", "radio"]
    assert list(Choices.of(lab(SOFTWARE)).sources) == ["emulated cars", "second room", "monday"]
    assert Choices.of(lab(SOFTWARE)).links == {
        "emulated cars": "simulated?port=5005",
        "radio": "serial:/dev/ttyUSB0?baud=57600",
        "dry run": "dry",
    }


def test_the_rules_are_the_files_and_the_cars_of_the_catalogue():
    first, *others = Choices.of(lab(ROOM)).rules
    assert first == "squashing"
    assert {"squashing-cars", "squashing-best", "couzin-cars", "hwvem-cars"} <= set(others)
    assert "vem" not in others
    best = Choices.of(lab(ROOM.replace('"squashing"', '"squashing-best"'))).rules
    assert best.count("squashing-best") == 1


def test_emulated_cars_have_a_link_of_their_own():
    made = choosing(lab(ROOM), "emulated cars", "radio", "squashing")
    assert (made.source, made.link) == (SIMULATED, SIMULATED)
    again = choosing(lab(SOFTWARE), "emulated cars", "dry run", "squashing")
    assert again.link == "simulated?port=5005"


def test_real_poses_do_not_go_with_emulated_cars():
    with pytest.raises(
        InputError, match=r"link = 'simulated\?port=5005' needs source = 'simulated'"
    ):
        choosing(lab(SOFTWARE), "monday", "emulated cars", "squashing")
    body = ROOM.replace('path = "circle"\nradius = 2.0', 'path = "body"\nbody = "wand"')
    with pytest.raises(InputError, match="cannot be emulated"):
        choosing(lab(body), "emulated cars", "dry run", "squashing")


def test_another_rule_keeps_the_parameters_that_it_has():
    parameters = "[parameters]\nbeta = 1.5\ncircle = 1.1\n\n[area]"
    one = lab(ROOM.replace("[area]", parameters))
    same = choosing(one, "mock:", "dry run", "squashing")
    assert same == one
    other = choosing(one, "mock:", "radio", "couzin-cars")
    assert (other.rule, other.parameters) == ("couzin-cars", {"circle": 1.1})
    assert one.parameters == {"beta": 1.5, "circle": 1.1}


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("monday ", "dry run", "squashing"), "unknown source 'monday ': did you mean 'monday'?"),
        (("optitrack:192.168.1.5?up=y", "dry run", "squashing"), "unknown source 'optitrack"),
        (("monday", "udp:10.0.0.1:1", "squashing"), "unknown link 'udp:10.0.0.1:1'"),
        (("emulated cars", "dry", "squashing"), "unknown link 'dry': did you mean 'dry run'?"),
        (("monday", "radio", "vem"), "unknown rule 'vem'"),
    ],
)
def test_other_words_are_refused(words, says):
    with pytest.raises(InputError) as refused:
        choosing(lab(ROOM), *words)
    assert str(refused.value).startswith(says)
    assert str(refused.value).endswith("(the laboratory)")


def test_software_is_a_known_kind_but_is_opened_with_its_laboratory():
    with pytest.raises(
        InputError, match=r"unknown kind of source 'simulatd': did you mean 'simulate"
    ):
        open_source("simulatd:")
    with pytest.raises(InputError, match=r"unknown link 'simulatd': did you mean 'simulated'"):
        open_link("simulatd")
    with pytest.raises(InputError, match="only where a laboratory is opened"):
        open_source("simulated")
    with pytest.raises(InputError, match="only where a laboratory is opened"):
        open_link("simulated?port=5005")


HERE = lab(ROOM)
CHOICES = Choices.of(HERE)
anything = st.one_of(st.text(), st.sampled_from([*TEXTS, *CARRIERS, "mine.py:", "emulated cars"]))


@settings(max_examples=200, deadline=None)
@given(
    st.one_of(anything, st.sampled_from(list(CHOICES.sources))),
    st.one_of(anything, st.sampled_from(list(CHOICES.links))),
    st.one_of(anything, st.sampled_from(CHOICES.rules)),
)
def test_whatever_is_asked_for_only_the_files_texts_come_out(source, link, rule):
    try:
        made = choosing(HERE, source, link, rule)
    except InputError:
        assert not (source in CHOICES.sources and link in CHOICES.links and rule in CHOICES.rules)
        return
    assert made.source in TEXTS
    assert made.link in CARRIERS
    assert (made.source == SIMULATED) == (made.link == SIMULATED)
    assert made.rule in CHOICES.rules
    as_before = {"source": HERE.source, "link": HERE.link, "rule": HERE.rule}
    assert made.model_copy(update=as_before) == HERE
