"""The results of a class: who gets which value, what counts, mean and spread, tables, pictures."""

from __future__ import annotations

import io
import json
import math
import pickle
import random
from collections import Counter
from itertools import pairwise
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
import scipy  # its parts are imported when they are asked for
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure

from app.classroom.collect.class_curve import ClassCurve
from app.classroom.collect.class_picture import FORMATS, draw, picture
from app.classroom.collect.class_table import points_from_csv, to_csv, to_json
from app.classroom.collect.collection import MOST_OF_ONE, Collection, spread_order
from app.classroom.collect.hand_in import ResultGroup, hand_in
from app.classroom.collect.question import question_of
from app.studies.judge.judge import ranges_of
from app.studies.judge.statistics import summary
from tests.classroom.small import AGREE, LED, ORDER, SCENE, VALUES, made, told
from worlds.input_error import InputError

CHOSEN = question_of(VALUES | {"values": []}, SCENE)
ALL = question_of(VALUES | {"counts": "all"}, SCENE)


def collected(points, question=ORDER):
    """A collection of these points."""
    found = Collection(question)
    for point in points:
        found.add(point)
    return found


def of_class(seed=3, students=30):
    """Results of a class, some values with several, some runs in which it did not happen."""
    rng = random.Random(seed)
    for k in range(students):
        value = rng.choice(ORDER.values)
        result = None if rng.random() < 0.1 else rng.gauss(math.exp(-value), 0.1)
        yield told(value, result, f"S{k}", seed=k)


@given(st.integers(2, 50), st.integers(1, 120))
def test_values_are_given_equally_often_and_cover_the_range_early(count, students):
    question = question_of(VALUES | {"values": [6.0 * k / count for k in range(count)]}, SCENE)
    found = Collection(question)
    given_values = [found.give(f"S{k}").value for k in range(students)]
    times = Counter(given_values)
    assert max(times.values()) - min([times[value] for value in question.values]) <= 1
    assert given_values[:2] == [question.values[0], question.values[-1]][:students]
    assert len({found.give(f"S{k}").seed for k in range(students)}) == students
    for first in range(2, min(count, students) + 1):
        there = sorted(question.values.index(value) for value in given_values[:first])
        gap = max(b - a for a, b in pairwise(there))
        assert gap <= 2 * math.ceil((count - 1) / (first - 1))


def test_a_student_keeps_their_value_and_one_who_goes_gives_it_back():
    found = Collection(ORDER)
    first = [found.give(name) for name in "abc"]
    assert [found.give(name) for name in "abc"] == first
    found.take_back("b")
    assert found.give("d").value == first[1].value
    found.add(told(first[2].value, 0.5, "c"))
    found.take_back("c")
    assert found.give("c") == first[2]
    assert spread_order(2) == [0, 1]


def test_a_student_begins_with_the_class_s_run_and_their_value():
    found = Collection(ORDER)
    for name in ("a", "b", "c"):
        spec, mine = found.begins(name, SCENE), found.give(name)
        assert spec == SCENE.but(seed=mine.seed, parameters={"eta": mine.value})
        assert not hand_in(ORDER, name, spec, SCENE).differs
    free = Collection(CHOSEN)
    assert free.begins("a", SCENE) == SCENE.but(seed=1)
    assert free.begins("b", SCENE) == SCENE.but(seed=2)


def test_the_last_result_of_a_student_counts_or_all_do():
    points = [told(0.0, 1.0, "a", 1), told(1.5, 0.5, "b", 2), told(3.0, 0.2, "a", 3)]
    assert collected(points).counting == [False, True, True]
    assert collected(points, ALL).counting == [True] * 3
    assert [group.value for group in collected(points).groups()] == [1.5, 3.0]


@pytest.mark.parametrize("seed", range(5))
def test_mean_and_spread_are_those_of_scipy(seed):
    found = collected(of_class(seed))
    frame = pd.DataFrame(
        [(p.value, p.result) for p in found.points], columns=["value", "result"]
    ).astype(float)
    groups = {group.value: group for group in found.groups()}
    assert list(groups) == sorted(frame["value"].unique())
    for value, rows in frame.groupby("value"):
        results, group = rows["result"].dropna().to_numpy(), groups[value]
        assert (group.runs, group.gave_up) == (len(results), int(rows["result"].isna().sum()))
        if len(results) < 2:
            assert math.isnan(group.sd)
            assert math.isnan(group.half)
            continue
        assert group.mean == pytest.approx(results.mean(), rel=1e-12)
        assert group.sd == pytest.approx(np.sqrt(((results - results.mean()) ** 2).sum()
                                                 / (len(results) - 1)), rel=1e-12)  # fmt: skip
        low, high = scipy.stats.t.interval(
            0.95, len(results) - 1, results.mean(), scipy.stats.sem(results)
        )
        assert group.half >= 0.999 * (high - results.mean()), "no narrower than Student's t"
        low, high = summary(ranges_of(results)).interval
        assert group.half == max(group.mean - low, high - group.mean), "that of the papers"


def test_one_run_that_two_hand_in_is_one_run():
    found = collected([told(1.5, 0.5, "a", 1), told(1.5, 0.5, "b", 1), told(1.5, 0.7, "c", 2)])
    assert found.groups()[0].values == (0.5, 0.7)
    assert found.told() == "3 results of 3 students; 1 run handed in twice, counted once"


def test_a_run_that_differs_is_in_no_mean():
    found = collected([made(1.5), made(1.5, 2, "B"), made(1.5, 3, "C", v0=0.5)])
    assert found.groups()[0].runs == 2
    assert found.told() == "3 results of 3 students; 1 not of the class's scene, in no mean"


@given(st.lists(st.floats(0.0, 6.28), min_size=1, max_size=200))
def test_chosen_values_come_into_bins_that_leave_none_out(values):
    points = [told(value, value, f"S{k}", k) for k, value in enumerate(values)]
    groups = collected(points, CHOSEN).groups()
    assert sum(group.runs for group in groups) == len(values)
    assert sorted(one for group in groups for one in group.values) == sorted(values)
    for group, after in pairwise(groups):
        assert group.low <= group.value <= group.high < after.low
    if len(set(values)) <= 12:
        assert [group.value for group in groups] == sorted(set(values))
    else:
        assert len(groups) <= 15


def test_values_over_decades_come_into_bins_of_equal_ratio():
    values = np.geomspace(1.0, 100.0, 100).tolist()
    question = question_of(VALUES | {"parameter": "p2", "values": []}, LED)
    points = [told(value, 1.0, f"S{k}", k) for k, value in enumerate(values)]
    runs = [group.runs for group in collected(points, question).groups()]
    assert len(runs) == 10
    assert max(runs) - min(runs) <= 2


def test_there_is_an_end_to_what_one_student_hands_in():
    found = collected([told(0.0, 1.0, "a", k) for k in range(MOST_OF_ONE)])
    with pytest.raises(InputError, match="100 results of a are there"):
        found.add(told(0.0, 1.0, "a", 0))
    found.add(told(0.0, 1.0, "b", 0))


def test_a_table_is_read_back_by_pandas_to_the_bit_and_by_us():
    question = question_of(VALUES | {"free": ["v0"]}, SCENE)
    names = ["Ada", 'B "x", y', "Zoë 山"]
    points = [hand_in(question, name, SCENE.but(seed=k, parameters={"eta": 0.1 + k, "r": 1.0 + k}),
                      SCENE) for k, name in enumerate(names)]  # fmt: skip
    points.append(told(3.0, None, "D", free=(0.03,)))
    found = collected(points, question)
    text = to_csv(found)
    frame = pd.read_csv(io.StringIO(text))
    assert list(frame.columns) == [
        "number", "student", "eta [rad]", "v0 [length/tick]", "polarisation-over-10",
        "status", "counts", "seed", "ticks", "differs", "reason", "when",
    ]  # fmt: skip
    assert frame["student"].tolist() == [point.student for point in points]
    assert frame["eta [rad]"].tolist() == [point.value for point in points]
    results = frame["polarisation-over-10"]
    assert results[:3].tolist() == [point.result for point in points[:3]]
    assert math.isnan(results[3])
    assert frame["counts"].tolist() == [True] * 4
    assert frame["differs"][1] == "other r: 2, not 1"
    assert pd.to_datetime(frame["when"])[0] == points[0].when
    specs = [point.spec for point in points]
    assert points_from_csv(text, question, lambda number: specs[number - 1], "here") == points


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("number,student", "student,number", "has not the columns"),
        (",ok,", ",fine,", "'fine' is no status"),
        (",ok,", ",gave-up,", "a run that is gave-up"),
        (",1.5,", ",x,", "'x' is not a finite number"),
        (",1.5,", ",nan,", "'nan' is not a finite number"),
        (",1.5,0.5,", ",1.5,,", "or else a reason"),
        (",1,40,", ",-1,40,", "'-1' is not a whole number"),
        ("2026-03-02T10:15:00+00:00", "yesterday", "is no time"),
        ("2026-03-02T10:15:00+00:00", "2026-03-02", "is no time"),
        ("1,Ada", "2,Ada", "not in order"),
        ("1,Ada", "1,=Ada", "formula"),
        ("1,Ada", "1, Ada", "not written as a name is"),
        ("1,Ada", '1,"Ada', "no CSV"),
        ("1,Ada", "1", "not as its columns"),
        (",1,40,", ",1,40,a\x07", "no line of text"),
    ],
)
def test_a_table_of_a_stranger_is_refused_in_one_line(before, after, said):
    text = to_csv(collected([told(1.5, 0.5, "Ada")]))
    assert before in text
    with pytest.raises(InputError, match=said) as refused:
        points_from_csv(text.replace(before, after, 1), ORDER, lambda _: "", "here")
    assert "\n" not in str(refused.value)


def test_the_plot_of_a_page_is_small_json_without_nan():
    found = collected([*of_class(), told(6.0, None, "late")])
    group = ResultGroup(0.0, 0.0, 0.0, (1.0,))
    found.curve = ClassCurve("vem-eta", (group,), ("other v0: 1, not 2",))
    said = to_json(found)
    text = json.dumps(said, allow_nan=False)
    assert len(text) < 100 * len(found.points) + 1000
    assert json.loads(text) == said
    noise = {"name": "eta", "title": "Noise", "symbol": "η", "unit": "rad", "limits": [0.0, 6.24]}
    assert said["x"] == noise | {"log": False}
    assert said["points"][-1] == [30, "late", 6.0, None, True, ""]
    for row, group in zip(said["groups"], found.groups(), strict=True):
        assert row[:2] == [pytest.approx(group.value), group.runs]
        if group.runs:
            assert row[2] == pytest.approx(group.mean, rel=1e-5)
        if group.runs > 1:
            assert row[5:] == pytest.approx(group.summary.interval, rel=1e-5)
    assert said["curve"]["groups"] == [[0.0, 1, 1.0, None, None, None, None]]


def test_pictures_are_what_they_say_and_always_the_same():
    points = [*of_class(), told(6.0, None, "late"), told(1.5, 0.2, "x", 77, differs=("other v0",))]
    title = r"Order $\frac{ & <b> </svg>"
    found = collected(points, question_of(VALUES | {"title": title}, SCENE))
    groups = tuple(ResultGroup(v, v, v, (0.9, 0.8)) for v in ORDER.values)
    found.curve = ClassCurve("a$b$c", groups, ())
    drawn = {kind: picture(found, kind) for kind in FORMATS}
    assert drawn["png"].startswith(b"\x89PNG")
    assert drawn["pdf"].startswith(b"%PDF")
    words = "".join(ElementTree.fromstring(drawn["svg"]).itertext())
    for said in (title, "Noise η (rad)", "polarisation over the last 10 ticks", "sweep a$b$c",
                 "mean and 95 % interval", "it did not happen here",
                 "not of the class's scene"):  # fmt: skip
        assert said in words
    assert drawn["svg"] == picture(pickle.loads(pickle.dumps(found)), "svg")
    with pytest.raises(InputError, match="kind of picture 'gif'"):
        picture(found, "gif")


def test_the_page_and_the_picture_of_a_class_end_where_the_quantities_end():
    found = collected([told(1.5, 0.4, "A", 1), told(1.5, 0.97, "B", 2), told(3.0, 0.9, "C", 3)])
    assert found.groups()[0].summary.interval[1] > 1.0
    axes = Figure().subplots()
    draw(axes, found)
    said = to_json(found)
    assert list(axes.get_ylim()) == said["y"]["limits"] == [0.0, 1.0]
    assert list(axes.get_xlim()) == said["x"]["limits"]
    assert said["x"]["limits"][0] == 0.0
    ticks = Collection(AGREE)
    ticks.add(told(5.0, 217.0, "A"))
    assert to_json(ticks)["y"]["limits"] == [0.0, 250.0]


def test_a_question_without_results_has_a_picture():
    assert picture(Collection(CHOSEN), "svg")
    assert to_json(Collection(ORDER))["told"] == "0 results of 0 students"
