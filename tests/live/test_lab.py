"""A laboratory's file: what it says, and one line with its place for what is wrong in it."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from app.live.control.injected_target import INJECTED
from app.live.control.pose import TrackingArea
from app.live.device_kinds import name_of
from app.live.laboratory.lab_file import find_line, lab_from_toml, read_lab
from live.rooms import LAB, lab
from worlds.input_error import InputError


def test_what_a_file_does_not_say_is_as_in_the_reading():
    one = lab()
    assert (one.rate, one.limits.stale, one.limits.frozen, one.limits.long_gap) == (
        100.0,
        0.1,
        0.35,
        1.0,
    )
    red = one.cars["red"]
    assert (red.steer, red.throttle, red.reverse, red.speed, red.lag) == (1.0, 1.0, 0.0, 1.0, 0.15)
    assert one.addresses == {"red": 1, "blue": 2}
    assert one.bodies == {"red": "red", "blue body": "blue"}


def test_a_laboratory_comes_back_from_its_own_file():
    one = lab(LAB.replace("fence = 0.5", f"fence = {0.5 + math.ulp(0.5)!r}"))
    assert lab_from_toml(one.to_toml(), "again") == one


def test_the_injected_car_may_be_a_tracked_body():
    one = lab(LAB.replace('path = "circle"\nradius = 2.0', 'path = "body"\nbody = "wand"'))
    assert one.bodies["wand"] == INJECTED


REFUSED = [
    ('link = "dry"', "link = 2026-01-01", "link = {'a date': '2026-01-01'} is not allowed", None),
    ("low = [-3.0, -3.0]\n", "", "[area] has no low", 6),
    ("fence", "fense", "unknown key 'fense': did you mean 'fence'? (known: low, high, fence)", 9),
    ("rule = ", "rules = ", "the laboratory has no rule", 0),
    ("address = 1", "address = 2", "red and blue have one address, 2", 19),
    (
        "address = 1",
        "address = 0",
        "cars.red.address = 0 is not allowed: a number >= 1 is needed",
        16,
    ),
    (
        "address = 1",
        'address = "1"',
        "cars.red.address = '1' is not allowed: a whole number is needed",
        16,
    ),
    (
        "address = 1",
        "address = true",
        "cars.red.address = True is not allowed: a whole number is needed",
        16,
    ),
    ("address = 1\n", "", "[cars.red] has no address", 15),
    ('"blue body"', '"red"', "red and blue have one body, 'red'", 20),
    ("[cars.red]", "[cars.injected]", "a car cannot be called 'injected'", 15),
    ("[cars.red]", "[cars.'']", "a car cannot be called ''", 15),
    (
        "address = 2",
        "address = 2\nspeed = 2",
        (
            "fence = 0.5 m is too little: blue may run on for 1.00 m (its speed, its lag and "
            "limits.frozen make that)"
        ),
        9,
    ),
    (
        "address = 2",
        "address = 2\nthrottle = 1.5",
        "cars.blue.throttle = 1.5 is not allowed: a number <= 1 is needed",
        20,
    ),
    ("address = 2", "address = 2\nspeed = inf", "cars.blue.speed = inf is not allowed", None),
    ("address = 2", "address = 2\nlag = nan", "cars.blue.lag = nan is not allowed", None),
    ("[-3.0, -3.0]", "[-3.0]", "area.low = [-3.0] is not allowed", None),
    ("[-3.0, -3.0]", "[-3.0, -3.0, 0.0]", "area.low = [-3.0, -3.0, 0.0] is not allowed", None),
    (
        "[-3.0, -3.0]",
        "[2.0, -3.0]",
        "there is no room within a fence of 0.5 m between x = 2 and 3",
        6,
    ),
    (
        "fence = 0.5",
        "fence = 3.0",
        "there is no room within a fence of 3 m between x = -3 and 3",
        None,
    ),
    ("fence = 0.5", "fence = -1", "area.fence = -1 is not allowed", None),
    (
        "radius = 2.0",
        "radius = 2.6",
        (
            "the injected car's path reaches (-2.6, -2.6), which is not within the fence, "
            "0.5 m inside the area"
        ),
        13,
    ),
    (
        "radius = 2.0",
        "centre = [1, 0]",
        "the injected car's path reaches (3, 2), which is not within the fence",
        None,
    ),
    (
        'path = "circle"',
        'path = "square"',
        (
            "injected.path = 'square' is not allowed: 'circle', 'eight', "
            "'route', 'hand', 'body' or 'none' is needed"
        ),
        12,
    ),
    ('path = "circle"', 'path = "body"', "the injected car has no body", 11),
    ('path = "circle"', 'path = "eight"', "the injected car's path reaches (-2, -4)", None),
    ('path = "circle"', 'path = "route"', 'a route and path = "route" need each other', None),
    (
        'path = "circle"',
        'path = "route"\nroute = [[1, 1], [2, 2], [2, 2]]',
        "a route needs two points or more, each apart from the next",
        None,
    ),
    (
        'path = "circle"',
        'path = "route"\nroute = [[1, 1], [2, 2.6]]',
        "the injected car's path reaches (2, 2.6)",
        None,
    ),
    ('path = "circle"', 'body = "wand"', 'a body of the injected car needs path = "body"', 12),
    (
        'path = "circle"',
        'path = "body"\nbody = "red"',
        "the injected car and red have one body, 'red'",
        13,
    ),
    (
        "[injected]",
        "[limits]\nstale = 0.3\n[injected]",
        "limits.stale = 0.3 is not allowed: a number <= 0.25 is needed",
        12,
    ),
    (
        "[injected]",
        "[limits]\nlong_gap = 0.25\nstale = 0.25\n[injected]",
        "long_gap must be longer than stale",
        11,
    ),
    ("[injected]", "[limits]\nwatchdog = 1\n[injected]", "unknown key 'watchdog'", None),
    (
        "[area]",
        "rate = 10\n[limits]\nstale = 0.05\n[area]",
        "stale must be longer than a tick of 0.1 s",
        7,
    ),
    ('link = "dry"', "link = 3", "link = 3 is not allowed: a text is needed", 3),
    ('link = "dry"', 'link = ""', "link = '' is not allowed", None),
    ("[area]", "[area", "room.toml is not TOML", None),
    (
        '"mock:"',
        '"simulated:here"',
        "source = 'simulated:here' is of software and has no place: simulated",
        2,
    ),
    (
        'source = "mock:"\nlink = "dry"',
        'source = "simulated"\nlink = "udp:127.0.0.1:5005"',
        "source = 'simulated' needs link = 'simulated' or 'dry', not 'udp:127.0.0.1:5005'",
        3,
    ),
    ('"dry"', '"simulated"', "link = 'simulated' needs source = 'simulated', not 'mock:'", 3),
    (
        'source = "mock:"\nlink = "dry"',
        'source = "simulated"\nlink = "simulated?port=65536"',
        "port = 65536 is outside [0, 65535] (link 'simulated?port=65536')",
        3,
    ),
    (
        'source = "mock:"\nlink = "dry"',
        'source = "simulated"\nlink = "simulated:here"',
        "the link 'simulated:here' leads to the room in software: write simulated",
        3,
    ),
]
"""What stands in the file, what is put in its place, what is said, of which line (0: none)."""


@pytest.mark.parametrize(("old", "new", "says", "line"), REFUSED)
def test_what_is_wrong_is_refused_in_one_line_with_its_place(old, new, says, line):
    assert old in LAB
    with pytest.raises(InputError) as refused:
        lab(LAB.replace(old, new, 1))
    told = str(refused.value)
    assert told.startswith(says)
    assert "\n" not in told
    if line is not None:
        assert told == f"{says} (room.toml{f', line {line}' if line else ''})"


CHOICES_REFUSED = [
    ("sources", '"" = "mock:"', "nothing can be called ''", 2),
    ("sources", '"a\\nb" = "mock:"', "nothing can be called 'a\\nb'", 2),
    ("sources", '"Emulated  cars" = "mock:"', "'Emulated  cars' cannot be told from", 2),
    ("links", '"emulated cars" = "dry"', "'emulated cars' cannot be told from 'emulated cars'", 2),
    ("links", '"Dry Run" = "udp:10.0.0.9:1"', "'Dry Run' cannot be told from 'dry run'", 2),
    ("sources", '"mock:" = "mock:"', "'mock:' cannot be told from 'mock:'", 2),
    ("sources", 'a = "mock:"\nA = "mock:"', "'A' cannot be told from 'a'", 3),
    ("sources", 'a = "mocc:"', "unknown kind of source 'mocc': did you mean 'mock'? (known:", 2),
    ("sources", 'a = "mock"', "source 'mock' is not of the form kind:place", 2),
    ("sources", 'a = "simulated"', "'simulated' can be chosen anyway, as 'emulated cars'", 2),
    ("sources", "a = 3", "sources.a = 3 is not allowed: a text is needed", 2),
    ("links", 'a = "seriel:/dev/x"', "unknown link 'seriel': did you mean 'serial'? (known:", 2),
    ("links", 'a = "serial:x?baud"', "'baud' is no option=value (link 'serial:x?baud')", 2),
    ("links", 'a = "simulated?port=1"', "'simulated?port=1' can be chosen anyway, as", 2),
]
"""A table, what stands in it, what is said, of which of its lines (the first is its head)."""


@pytest.mark.parametrize(("table", "entries", "says", "line"), CHOICES_REFUSED)
def test_what_cannot_be_chosen_is_refused_with_its_line(table, entries, says, line):
    at = LAB.splitlines().index("[area]")
    with pytest.raises(InputError) as refused:
        lab(LAB.replace("[area]", f"[{table}]\n{entries}\n\n[area]"))
    told = str(refused.value)
    assert told.startswith(says)
    assert told.endswith(f"(room.toml, line {at + line})")
    assert "\n" not in told


def test_a_body_cannot_be_the_injected_car_in_software():
    software = LAB.replace('"mock:"', '"simulated"').replace('"dry"', '"simulated"')
    assert lab(software).link == "simulated"
    assert lab(software.replace('"circle"\nradius = 2.0', '"hand"')).injected.path == "hand"
    with pytest.raises(InputError) as refused:
        lab(software.replace('path = "circle"\nradius = 2.0', 'path = "body"\nbody = "wand"'))
    assert str(refused.value) == (
        'injected.path = "body" cannot be emulated: use "circle", "hand" or "none" there '
        "(room.toml, line 12)"
    )


def test_another_value_is_checked_as_those_of_the_file_are():
    one = lab()
    assert one.with_values("here", rule="couzin-cars") == one.model_copy(
        update={"rule": "couzin-cars"}
    )
    with pytest.raises(InputError, match=r"link = 'simulated' needs source .* \(here\)$"):
        one.with_values("here", link="simulated")


def test_a_laboratory_without_cars_is_refused():
    with pytest.raises(InputError, match=r"the laboratory has no cars \(room.toml\)"):
        lab(LAB[: LAB.index("[cars")])


def test_a_slower_car_may_have_a_narrower_fence():
    text = LAB.replace("fence = 0.5", "fence = 0.25").replace("address", "throttle = 0.5\naddress")
    assert lab(text).area.fence == 0.25
    with pytest.raises(InputError, match=r"red may run on for 0\.25 m"):
        lab(text.replace("fence = 0.25", "fence = 0.2499"))


@pytest.mark.parametrize(
    ("content", "says"), [(None, "cannot be read"), (b"\xff\xfe", "is not a text file")]
)
def test_a_file_that_cannot_be_read(tmp_path, content, says):
    path = tmp_path / "lab.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match=says):
        read_lab(path)


def test_a_file_is_read(tmp_path):
    path = tmp_path / "lab.toml"
    path.write_text(LAB)
    assert read_lab(path) == lab()


LINES = """a = 1
b = { c = 2, d = { e = 3 } }
f = [
  1,
  2,
]
[g]
h.i = 4
"j k" = 5
[g."l.m"]
n = 6
"""


@pytest.mark.parametrize(
    ("keys", "line"),
    [
        (["a"], 1),
        (["b"], 2),
        (["b", "c"], 2),
        (["b", "d", "e"], 2),
        (["f"], 3),
        (["g"], 7),
        (["g", "missing"], 7),
        (["g", "h"], 8),
        (["g", "h", "i"], 8),
        (["g", "j k"], 9),
        (["g", "l.m"], 10),
        (["g", "l.m", "n"], 11),
        (["missing"], None),
        ([], None),
    ],
)
def test_the_line_of_a_key(keys, line):
    tomllib.loads(LINES)
    assert find_line(LINES, keys) == line


@settings(max_examples=100, deadline=None)
@given(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0), st.floats(0.0, 1.0), st.floats(0.1, 9.0))
def test_what_is_clamped_is_within_the_fence_and_moved_no_further_than_needed(x, y, fence, side):
    area = TrackingArea(low=(-1.0, -2.0), high=(-1.0 + 2.0 * fence + side, 8.0), fence=fence)
    inside = area.distance_inside(x, y)
    at = area.clamp(x, y)
    assert area.distance_inside(*at) >= -1e-12
    if inside >= 0.0:
        assert at == pytest.approx((x, y), abs=1e-12)
    else:
        assert max(abs(at[0] - x), abs(at[1] - y)) == pytest.approx(-inside, abs=1e-12)


def test_the_file_on_the_page_says_what_holds_without_it():
    page = (Path(__file__).parents[2] / "docs" / "live-file.md").read_text(encoding="utf-8")
    (text,) = re.findall(r"^```toml\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    shown = lab_from_toml(text, "docs/live-file.md")
    assert shown.limits == lab().limits
    assert shown.area.fence == lab().area.fence
    assert shown.injected == lab().injected
    assert shown.simulated == lab().simulated
    assert shown.sources
    assert shown.links
    for name in ("red", "blue"):
        rest = {"address": 0, "body": ""}
        one = shown.cars[name].model_dump() | rest
        assert one == lab().cars[name].model_dump() | rest


def test_the_own_link_of_a_laboratory_is_called_by_its_file_alone():
    own = lab(LAB.replace('"dry"', '"/home/ann/my_radio.py:/dev/ttyACM0"'))
    assert name_of(own.link) == "my_radio.py:/dev/ttyACM0"
