"""Flocks whose agents differ, as pages that run by themselves: flight, catches, sliders, legend."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from agents.flock import Flock, measure_observable
from agents.individuals import each, lognormal, normal, one_of, uniform
from agents.kinds import Kind, chase, replace_kind
from agents.observables.catalogue import OF_KIND, kind_observables
from tests.browser.accessibility import find_violations_in_both_themes
from tests.browser.test_export import moved
from tests.viewer.waiting import until


class Change(NamedTuple):
    """A slider that is moved, and what does the same here."""

    slider: str
    value: float
    act: Callable[[Flock], None]


def shifted(name: str, value: float) -> Change:
    """Another mean of what agents differ in."""
    return Change(
        name, value, lambda flock: flock.set(**{name: flock.individuals[name].about(value)})
    )


def spread(name: str, value: float) -> Change:
    """Another spread."""
    return Change(
        f"{name}.spread",
        value,
        lambda flock: flock.set(**{name: flock.individuals[name].with_moments(spread=value)}),
    )


def of_kind(kind: str, name: str, value: float, drawn_from: Any = None, what: str = "") -> Change:
    """Another number of a kind."""
    number = value if drawn_from is None else drawn_from
    return Change(
        f"{kind}.{name}{what}", value, lambda flock: flock.set_kind(kind, **{name: number})
    )


def related(name: str, value: float, **relation: Any) -> Change:
    """Another chase of the flock by sharks."""
    return Change(
        f"shark.flock.{name}",
        value,
        lambda flock: flock.relate("shark", "flock", chase(**relation)),
    )


HUNT = {"weight": 2.0, "radius": 1.5, "catch": 0.15}
CASES: dict[str, tuple[dict[str, Any], list[Change]]] = {
    "pairs, and who is caught is gone": (
        {
            "model": "vem",
            "agents": 60,
            "eta": uniform(0.2, 1.0),
            "kinds": [Kind("shark", 3, v0=0.06, to={"flock": chase(**HUNT)})],
        },
        [
            shifted("eta", 0.9),
            spread("eta", 0.7),
            of_kind("shark", "v0", 0.07),
            related("weight", 3.0, **HUNT | {"weight": 3.0}),
            related("radius", 1.0, weight=3.0, radius=1.0, catch=0.15),
            related("catch", 0.25, weight=3.0, radius=1.0, catch=0.25),
            Change("r", 1.2, lambda flock: flock.set(r=1.2)),
        ],
    ),
    "space, and who is caught stands still": (
        {
            "model": "couzin",
            "agents": 40,
            "s": normal(3.0, 0.5),
            "r_r": one_of(0.5, 1.0, 1.5),
            "kinds": [
                Kind(
                    "shark",
                    3,
                    s=normal(4.5, 0.3),
                    start=((0, 0, 0), (5, 5, 5)),
                    to={"flock": chase(2.0, 12.0, catch=2.0, caught="frozen", first=True)},
                ),
                Kind("slow", 10, s=lognormal(2.0, 0.3), to={"flock": "own"}),
            ],
            "to": {"slow": "own"},
        },
        [
            shifted("s", 3.5),
            shifted("r_r", 1.2),
            of_kind("shark", "s", 4.0, normal(4.0, 0.3)),
            of_kind("slow", "s", 0.8, lognormal(2.0, 0.8), ".spread"),
        ],
    ),
    "a scalar sweep, and who is caught begins elsewhere": (
        {
            "model": "hwvem",
            "agents": 40,
            "p1": 0.1,
            "v0": uniform(0.02, 0.04),
            "kinds": [
                Kind(
                    "shark",
                    2,
                    start=((0, 0), (1, 1)),
                    to={"flock": chase(1.0, 1.0, catch=0.2, caught="moved")},
                )
            ],
        },
        [
            spread("v0", 0.005),
            related("catch", 0.3, weight=1.0, radius=1.0, catch=0.3, caught="moved"),
        ],
    ),
    "in random order, and those of a kind are only counted": (
        {
            "model": "hwvem",
            "agents": 40,
            "activation": "random",
            "kinds": [Kind("shark", 3, to={"shark": chase(1.0, 1.0, catch=0.3, caught="counted")})],
        },
        [
            Change(
                "shark.shark.weight",
                0.5,
                lambda flock: flock.relate(
                    "shark", "shark", chase(0.5, 1.0, catch=0.3, caught="counted")
                ),
            )
        ],
    ),
    "late messages, and who is caught is gone": (
        {
            "model": "hwvem",
            "agents": 40,
            "delay": 3.0,
            "v0": uniform(0.02, 0.04),
            "kinds": [Kind("shark", 3, to={"flock": chase(1.0, catch=0.25)})],
        },
        [shifted("v0", 0.035), Change("r", 1.3, lambda flock: flock.set(r=1.3))],
    ),
    "a number for each agent": (
        {
            "model": "vem",
            "agents": 40,
            "v0": each(np.linspace(0.01, 0.05, 42)),
            "kinds": [Kind("two", 2, v0=each([0.1, 0.2]), to={"flock": "own"})],
        },
        [
            shifted("v0", 0.04),
            of_kind("two", "v0", 0.16, each([0.11, 0.21])),
        ],
    ),
}


def demand_same(flock: Flock, there: dict[str, Any]) -> None:
    """The page's flock is as the one here: positions within rounding, all else exactly."""
    ids, kind = list(map(int, there["ids"])), list(there["kind"])
    assert ids == flock.ids.tolist()
    assert kind == flock.arrays.kind.tolist()
    position = np.reshape(there["position"], flock.position.shape)
    assert position == pytest.approx(flock.position, abs=1e-9)
    if flock.kinds.catchers:
        assert there["catches"] == len(flock.catches)


STATE = """(ticks) => page.ask({ ticks }).then(({ ids, kind, position, rows }) => ({
  ids: [...ids].map(Number), kind: [...kind], position: [...position], catches: rows.at(-1)[2],
}))"""


MEASURED = """() => {
  const shown = page.manifest.measures.map(({ name }) => name);
  return page.requests.ask({ shown }).then(({ rows }) => {
    const [, ...values] = rows.at(-1);
    return shown.map((name, k) => [name, values[k]]);
  });
}"""


def demand_same_measures(flock: Flock, page: Any) -> None:
    """The page measures what a flock here does, also of each kind alone."""
    values = dict(page.evaluate(MEASURED))
    assert {"direction", *kind_observables(flock)} < set(values)
    assert ("kind-distance" in values) == bool(flock.kinds.kinds)
    for name, value in values.items():
        whole, _, kind = name.partition(OF_KIND)
        expected = measure_observable(flock, whole, kind or None)
        assert value == pytest.approx(expected, rel=1e-6, abs=1e-6, nan_ok=True), name


@pytest.mark.parametrize("case", CASES)
def test_a_page_flies_agents_that_differ_as_here_also_when_sliders_are_moved(opened, case):
    words, changes = CASES[case]
    flock = Flock(rng=3, **words)
    with opened(Flock(rng=3, **words)) as page:
        demand_same(flock, page.evaluate(STATE, 0))
        for change in changes:
            flock.run(20)
            demand_same(flock, page.evaluate(STATE, 20))
            change.act(flock)
            moved(page, change.slider, change.value)
        flock.run(20)
        demand_same(flock, page.evaluate(STATE, 20))
        assert not flock.kinds.catchers or len(flock.catches) > 0
        demand_same_measures(flock, page)
        # Another start keeps what sliders say; a list has as many numbers as it has.
        more = 0 if "each" in {one.kind for one in flock.individuals.values()} else 3
        agents = flock.options.agents + more
        numbers = dict(flock.parameters.model_dump()) | dict(flock.individuals)
        if case == "a number for each agent":
            numbers["v0"] = words["v0"].about(0.04)
            agents = 40
        spec = flock.spec.with_parameters(numbers, agents=agents, seed=11, kinds=flock.kinds.kinds)
        anew = Flock(spec)
        page.evaluate("(agents) => page.beginAnew(String(agents), '11')", agents)
        for ticks in (0, 20):
            anew.run(ticks)
            demand_same(anew, page.evaluate(STATE, ticks))


def fill_count(page: Any, kind: str, count: int | str) -> None:
    """Write how many agents a kind has into its field."""
    field = page.get_by_label(kind, exact=True)
    field.fill(str(count))
    field.press("Enter")


@pytest.mark.parametrize("case", [one for one in CASES if "each" not in one])
def test_another_number_of_agents_of_a_kind_begins_the_run_that_it_begins_here(opened, case):
    """Also of none, and then again of some; what sliders say stays, and so does the seed."""
    words, changes = CASES[case]
    flock = Flock(rng=3, **words)
    with opened(Flock(rng=3, **words)) as page:
        for change in changes:
            change.act(flock)
            moved(page, change.slider, change.value)
        for more in ((4, -100), (-100, 0), (0, 3)):
            counts = [
                max(0, kind.agents + by) for kind, by in zip(flock.kinds.kinds, more, strict=False)
            ]
            kinds = [
                replace_kind(kind, agents=count)
                for kind, count in zip(flock.kinds.kinds, counts, strict=True)
            ]
            for kind in kinds:
                fill_count(page, kind.name, kind.agents)
            until(lambda: page.evaluate("page.busy") == 0, 60, "the flock to begin")
            numbers = dict(flock.parameters.model_dump()) | dict(flock.individuals)
            anew = Flock(flock.spec.with_parameters(numbers, kinds=kinds, to=flock.kinds.to))
            assert [len(anew.rows_of(kind.name)) for kind in kinds] == counts
            for ticks in (0, 40):
                anew.run(ticks)
                demand_same(anew, page.evaluate(STATE, ticks))
            demand_same_measures(anew, page)


def test_a_page_of_a_kind_without_agents_takes_some(opened):
    def flock(sharks: int) -> Flock:
        kind = Kind("shark", sharks, v0=uniform(0.04, 0.06), to={"flock": chase(**HUNT)})
        return Flock("vem", agents=60, rng=3, size=4.0, kinds=[kind])

    with opened(flock(0)) as page:
        assert page.locator("#legend").inner_text().split("\n") == ["flock 60", "shark 0"]
        fill_count(page, "shark", 4)
        until(lambda: page.evaluate("page.busy") == 0, 60, "the flock to begin")
        anew = flock(4)
        for ticks in (0, 60):
            anew.run(ticks)
            demand_same(anew, page.evaluate(STATE, ticks))
        assert len(anew.catches)


def test_a_page_says_how_many_agents_of_a_kind_it_takes(opened):
    with opened(hunting()) as page:
        labels = page.locator("#counts label").all_inner_texts()
        assert [label.strip() for label in labels] == ["flock", "shark"]
        limit = "20\u2009000"
        assert find_violations_in_both_themes(page) == []
        assert f"{limit} at most in all" in page.locator("#anew").inner_text()
        for count, said in (
            ("19941", f"20\u2009001 agents are too many: {limit} at most in all."),
            ("1.5", f"shark: a whole number from 0 to {limit} agents."),
            ("-1", f"shark: a whole number from 0 to {limit} agents."),
            ("", f"shark: a whole number from 0 to {limit} agents."),
        ):
            fill_count(page, "shark", count)
            until(lambda said=said: page.locator("#say").inner_text() == said, 60, "a refusal")
            assert page.get_by_label("shark", exact=True).input_value() == "3"
            assert page.evaluate("page.state.ids.length") == 63
            page.click("#reset")
        fill_count(page, "flock", 0)
        said = f"flock: 1 to {limit}."
        until(lambda: page.locator("#say").inner_text() == said, 60, "a refusal")


def test_the_address_has_the_numbers_of_kinds(opened):
    with opened(hunting()) as page:
        fill_count(page, "shark", 5)
        said = "#agents=60&seed=3&shark.agents=5"
        until(lambda: page.evaluate("location.hash") == said, 60, "the address")
        assert page.locator("#legend").inner_text().split("\n") == ["flock 60", "shark 5"]
        page.reload()
        until(lambda: page.evaluate("'page' in globalThis"), 60, "the flock to be there")
        assert page.get_by_label("shark", exact=True).input_value() == "5"
        assert page.evaluate("page.state.ids.length") == 65


def test_a_flock_without_kinds_has_no_numbers_of_kinds(opened):
    with opened(Flock("vem", agents=4, rng=1, eta=normal(0.5, 0.1))) as page:
        assert page.locator("#counts").count() == 0
        assert page.locator("#anew label").all_inner_texts() == ["Agents", "Seed"]


def hunting() -> Flock:
    """A flock that three sharks chase; those whom they catch stand still."""
    shark = Kind("shark", 3, v0=0.06, to={"flock": chase(**HUNT, caught="frozen")})
    return Flock("vem", agents=60, rng=3, kinds=[shark])


def test_kinds_have_their_colours_and_numbers_and_a_click_tells_the_kind(opened):
    flock = hunting()
    with opened(hunting()) as page:
        assert page.input_value("#colour") == "kind"
        assert page.locator("#legend").inner_text().split("\n") == ["flock 60", "shark 3"]
        assert page.locator(".chart select").nth(1).input_value() == "catches"
        page.evaluate("page.ask({ ticks: 100 })")
        flock.run(100)
        counts = [len(flock.rows_of(name)) for name in ("flock", "shark")]
        caught = len(flock.catches)
        assert caught
        expected = [f"flock {counts[0]}", f"shark {counts[1]}", f"caught {caught}"]
        assert page.locator("#legend").inner_text().split("\n") == expected
        assert page.locator(".chart output").nth(1).inner_text() == f"{caught} agents"
        for name, number in (("shark", 1), ("flock", 0), ("caught", -1)):
            page.evaluate(
                """(number) => {
                  const row = page.state.kind.findIndex((one) => one === number);
                  page.view.picked = page.state.ids[row];
                  page.show();
                }""",
                number,
            )
            assert f", {name}: " in page.locator("#picked").inner_text()
        for colour in ("heading", "group", "kind"):
            page.select_option("#colour", colour)
            until(lambda: page.evaluate("page.busy") == 0, 60, "the colours")


def test_the_sliders_of_a_kind_stand_below_its_name_and_say_whose_they_are(opened):
    with opened(hunting()) as page:
        assert page.locator("#sliders h2").all_inner_texts() == ["shark"]
        labels = page.locator("#sliders input").evaluate_all(
            "(all) => all.map((one) => one.getAttribute('aria-label'))"
        )
        assert "shark: Speed, length/tick" in labels
        assert "shark: Chases flock: weight" in labels
        assert "shark: Catches flock within, length" in labels
        assert len(labels) == len(set(labels))


def test_a_list_of_numbers_is_for_as_many_agents_as_it_has(opened):
    with opened(Flock("vem", agents=4, rng=1, v0=each([0.01, 0.02, 0.03, 0.04]))) as page:
        page.fill("#agents", "5")
        page.press("#agents", "Enter")
        until(lambda: "numbers of 4 agents" in page.locator("#say").inner_text(), 60, "a refusal")
        assert page.input_value("#agents") == "4"
        assert page.evaluate("page.state.ids.length") == 4


def test_a_slider_of_the_time_step_acts(opened):
    """It was fixed in every page."""
    flock = Flock("couzin", agents=20, rng=3)
    with opened(Flock("couzin", agents=20, rng=3)) as page:
        flock.set(tau=0.05)
        moved(page, "tau", 0.05)
        flock.run(20)
        there = page.evaluate("page.ask({ ticks: 20 }).then((answer) => [...answer.position])")
        assert np.reshape(there, flock.position.shape) == pytest.approx(flock.position, abs=1e-9)
        assert page.evaluate("page.state.time") == pytest.approx(flock.elapsed)
