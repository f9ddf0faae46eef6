"""Sweeps from the page: what may be begun, the process that makes the runs, what is found again."""

from __future__ import annotations

import html
import json
import math
import os
import re
import shutil
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from cli.calling import call

from agents.flock import Flock
from agents.individuals import normal
from agents.kinds import Kind, chase, flee, kind_table, replace_kind
from agents.policies import POLICIES, Policy
from app.studies.charts.run_group import CellRuns
from app.studies.run_axes import AGENTS, AxisModels
from app.studies.runs.database import FILE, Outcome
from app.studies.runs.store import Store, is_locked
from app.studies.runs.store_reader import StoreReader
from app.studies.study_runner import SPEC, STOP
from app.studies.sweeps.checked_sweep import read_sweep
from app.studies.sweeps.sweep_api import sweep
from app.studies.sweeps.sweep_table import wide_table
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.panels.sweep_panel import status
from app.viewer.lab.sweeps import laboratory_sweeps
from app.viewer.lab.sweeps.laboratory_sweeps import Sweeps, demand_from_page
from app.viewer.lab.sweeps.stored_sweeps import (
    DrawnSweep,
    content,
    read_drawn_sweep,
    scene_of,
    typical,
)
from app.viewer.lab.sweeps.sweep_chart import name_axis, picture
from app.viewer.lab.sweeps.sweep_request import (
    MOST_CELLS,
    Axis,
    SweepRequest,
    describe_limits,
)
from app.viewer.run.run_preset import preset_spec
from tests.viewer.http_client import ask
from tests.viewer.waiting import until
from worlds.input_error import InputError
from worlds.layout import world as build_world

OPENS = {"X-Flockscope": "scene"}
SPEC_OF = preset_spec("vem", agents=20, seed=2, parameters={"eta": 0.4, "v0": 0.05})
ASKED = SweepRequest(SPEC_OF, [Axis("eta", 0.0, 6.0, 3)], "polarisation", runs=2, ticks=30)
OF_PAGE = '[run]\nmodel = "vem"\nticks = 100\n'
GRID_OF_WORLDS = '[[design]]\nkind = "grid"\n[design.axes]\nworld = ["mine.toml"]\n'
LONG = replace(ASKED, axes=[Axis("eta", 0.0, 6.0, 50)], runs=100, ticks=4000)


@pytest.fixture(scope="module")
def laboratory(tmp_path_factory):
    made = Laboratory(SPEC_OF, port=0, running=False, results=tmp_path_factory.mktemp("results"))
    made.sweeps.watched = lambda: True
    assert made.simulation.ready.wait(60)
    until(lambda: made.parameters.controls and made.sweep.observed)
    yield made
    made.close()


@pytest.fixture(scope="module")
def finished(laboratory):
    """The folder of a sweep that was begun as the page does."""
    name = laboratory.sweeps.begin(ASKED)
    until(lambda: state_of(laboratory.sweeps, name) == "done", 90)
    until(lambda: laboratory.sweeps.making is None)
    return laboratory.sweeps.results / name


def state_of(sweeps: Sweeps, name: str) -> str:
    sweeps.now.set()
    found = sweeps.seen.of(name)
    return found.state if found else ""


def test_a_sweep_is_around_the_run_as_it_is_now(tmp_path):
    asked = replace(ASKED, axes=[Axis("eta", 0.0, 6.0, 3), Axis(AGENTS, 10, 40, 3, log=True)])
    path = tmp_path / SPEC
    path.write_text(asked.to_toml())
    made = read_sweep(path)
    assert [cell.axes for cell in made.cells][:4] == [
        {"eta": 0.0, "agents": 10},
        {"eta": 0.0, "agents": 20},
        {"eta": 0.0, "agents": 40},
        {"eta": 3.0, "agents": 10},
    ]
    assert {cell.spec.parameters["v0"] for cell in made.cells} == {0.05}
    assert asked.name == "vem-eta-agents"


def test_a_world_of_ones_own_goes_along(tmp_path):
    world = replace(build_world("obstacles", 2, None, lambda _: 1.0), name="mine")
    asked = replace(
        ASKED,
        spec=preset_spec("hwvem-nav", world=world, agents=10),
        axes=[Axis("eta", 0.0, 1.0, 2)],
    )
    (tmp_path / SPEC).write_text(asked.to_toml())
    (tmp_path / "world.toml").write_text(asked.world())
    (cell, _) = read_sweep(tmp_path / SPEC).cells
    assert len(Flock(cell.spec.but(seed=1)).world.obstacles) == len(world.obstacles)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"axes": [Axis("eta", 0.0, 9.0, 3)]}, r"eta = 9 is not in \[0, 6.28"),
        ({"axes": [Axis("eta", math.nan, 1.0, 3)]}, "eta = nan is not in"),
        ({"axes": [Axis("eta", 1.0, 1.0, 3)]}, "to itself"),
        ({"axes": [Axis("eta", 0.0, 1.0, 51)]}, "51 values of eta"),
        ({"axes": [Axis("eta", 0.0, 1.0, 3, log=True)]}, "by logarithms from 0"),
        ({"axes": [Axis("neighbours", 0.0, 1.0, 3)]}, "'neighbours'"),
        ({"axes": [Axis("eta", 0.0, 1.0, 3)] * 2}, "both axes"),
        ({"axes": [Axis("eta", 0, 1, 21), Axis("v0", 0, 0.1, 20)]}, "420 cells are not allowed"),
        ({"axes": [Axis(AGENTS, 10, 3001, 3)]}, "agents = 3001"),
        ({"runs": 101}, "101 runs of a cell"),
        ({"axes": [Axis("eta", 0, 1, 9), Axis("v0", 0, 0.1, 20)], "runs": 50}, "9,000 runs"),
        ({"runs": 0}, "0 runs"),
        ({"ticks": 20_001}, "20,001 ticks"),
        ({"axes": [Axis(AGENTS, 10, 3000, 9)], "runs": 99, "ticks": 20_000}, "steps of an agent"),
        ({"observable": "nonsense"}, "nonsense"),
        ({"observable": "binder"}, "over 2 or more"),
        ({"over": 31}, "the last 31 ticks"),
    ],
)
def test_what_is_too_much_or_nonsense_is_refused_before_anything_is_made(tmp_path, changes, said):
    sweeps = Sweeps(tmp_path)
    with pytest.raises(InputError, match=said):
        sweeps.begin(replace(ASKED, **changes))
    assert not list(tmp_path.iterdir())
    sweeps.close()


def test_the_bound_is_said_on_the_page(laboratory):
    assert f"{MOST_CELLS} cells" in describe_limits()
    laboratory.sweep.runs.value = 100
    laboratory.sweep.second.choose("v0")
    laboratory.sweep.first.count.value = laboratory.sweep.second.count.value = 50
    until(lambda: "not allowed from the page" in laboratory.sweep.said.content)
    until(lambda: laboratory.sweep.start.disabled)
    laboratory.sweep.second.over.value = "nothing else"
    laboratory.sweep.first.count.value = 5
    laboratory.sweep.runs.value = 3
    until(lambda: "15 runs" in laboratory.sweep.said.content)
    until(lambda: not laboratory.sweep.start.disabled)


def test_a_sweep_fills_in_and_is_found_again(laboratory, finished):
    panel = laboratory.sweep
    until(lambda: "6 of 6 runs" in panel.status.content)
    until(lambda: panel.picture.content.count("data-cell") == 3)
    assert not panel.go.visible
    assert panel.which.value == finished.name == "vem-eta"
    again = Sweeps(finished.parent)
    until(lambda: again.seen.shown is not None)
    assert again.seen.of(finished.name).done == 6
    assert again.seen.shown.cells[1].seeds == [1, 2]
    assert again.close() == ""


def test_a_picture_is_drawn_only_if_there_is_more_to_show(finished, monkeypatch):
    drawn = []
    monkeypatch.setattr(laboratory_sweeps, "picture", lambda one: drawn.append(one) or "<i></i>")
    again = Sweeps(finished.parent, watched=lambda: False)
    for _ in range(3):
        again.look()
    assert [one is again.seen.shown for one in drawn] == [True]
    assert again.seen.picture == "<i></i>"
    again.choose(finished.name, "polarisation")
    again.look()
    assert len(drawn) == 2
    again.close()


def test_a_run_of_a_sweep_is_the_run_that_opens(laboratory, finished):
    table = wide_table(StoreReader(finished))
    row = list(zip(table["place"], table["seed"], strict=True)).index((2, 2))
    scene = scene_of(finished, 2, 2, None)
    flock = Flock(scene.spec)
    flock.run(ASKED.ticks)
    assert flock.observe("polarisation") == table["polarisation"][row]
    answer = ask(laboratory.port, "/sweep/run?sweep=vem-eta&cell=2&seed=2", OPENS)
    assert json.loads(answer.text) == {"title": "vem-eta: eta = 3, seed 2", "asks": False}
    until(lambda: laboratory.simulation.state.spec.seed == 2, 60)
    until(lambda: laboratory.simulation.state.values.get("eta") == 3.0)
    assert "polarisation came to" in scene.watch


def test_a_click_on_a_cell_opens_the_run_nearest_to_its_mean(finished):
    assert typical(CellRuns({}, 1, [0.0, 0.6, 1.0], [7, 8, 9])) == 8
    assert typical(CellRuns({}, 1, broken=3)) is None
    cell = read_drawn_sweep(finished).cells[3]
    assert scene_of(finished, 3, None, None).spec.seed == typical(cell)


@pytest.mark.parametrize(
    "query",
    [
        "sweep=nonsense&cell=1",
        "sweep=../results/vem-eta&cell=1",
        "sweep=.&cell=1",
        "cell=1",
        "sweep=vem-eta",
        "sweep=vem-eta&cell=4",
        "sweep=vem-eta&cell=0",
        "sweep=vem-eta&cell=-1",
        "sweep=vem-eta&cell=1&seed=1e9",
        "sweep=vem-eta&cell=99999999999999999999999",
        "sweep=vem-eta&cell=%C2%B2",
    ],
)
def test_what_is_not_there_is_not_opened(laboratory, finished, query):
    assert finished.exists()
    answer = ask(laboratory.port, f"/sweep/run?{query}", OPENS)
    assert answer.status == 400
    assert answer.text.count("\n") == 1


def test_other_pages_can_neither_choose_nor_open(laboratory, finished):
    assert finished.exists()
    for path in ("/sweep/over?name=eta", "/sweep/run?sweep=vem-eta&cell=1"):
        assert ask(laboratory.port, path).status == 403
        assert ask(laboratory.port, path, OPENS | {"Sec-Fetch-Site": "cross-site"}).status == 403


def test_sweep_this_begins_the_form_with_a_parameter(laboratory):
    until(lambda: laboratory.simulation.state.spec.model == "vem")
    assert ask(laboratory.port, "/sweep/over?name=v0", OPENS).status == 200
    assert laboratory.sweep.first.axis().name == "v0"
    assert ask(laboratory.port, "/sweep/over?name=nonsense", OPENS).status == 400
    assert laboratory.sweep.first.axis().name == "v0"


def test_all_of_it_can_be_taken_along(finished):
    name, table = content(finished, "CSV")
    assert name == "vem-eta.csv"
    assert len(table.splitlines()) == 7
    assert tomllib.loads(content(finished, "Spec")[1].decode())["run"]["agents"] == 20
    assert content(finished, "PNG")[1].startswith(b"\x89PNG")
    assert b"<svg" in content(finished, "SVG")[1]
    with pytest.raises(InputError, match="not one of"):
        content(finished, "EXE")


def test_it_is_stopped_gone_on_with_and_outlives_the_laboratory(tmp_path):
    sweeps = Sweeps(tmp_path)
    name = sweeps.begin(LONG)
    with pytest.raises(InputError, match="one sweep at a time"):
        sweeps.begin(ASKED)
    until(lambda: state_of(sweeps, name) == "running" and sweeps.seen.of(name).done, 90)
    sweeps.stop(name)
    until(lambda: state_of(sweeps, name) == "stopped", 60)
    done = sweeps.seen.of(name).done
    assert 0 < done < 5000
    until(lambda: sweeps.making is None or not sweeps.making.runs)
    sweeps.go_on(name)
    until(lambda: is_locked(tmp_path / name), 60)
    until(lambda: sweeps.seen.of(name).done > done, 60)
    making = sweeps.making
    own = os.getpriority(os.PRIO_PROCESS, 0)
    assert os.getpriority(os.PRIO_PROCESS, making.process.pid) > own, "it gives way to the page"
    assert sweeps.close() == name
    assert making.runs, "a laboratory that ends leaves its sweep running"
    other = Sweeps(tmp_path)
    until(lambda: state_of(other, name) == "running")
    with pytest.raises(InputError, match="one sweep at a time"):
        other.begin(ASKED)
    other.stop(name)
    assert (tmp_path / name / STOP).exists() or not is_locked(tmp_path / name)
    until(lambda: state_of(other, name) == "stopped", 60)
    making.process.wait(60)
    other.close()


def test_what_the_command_refuses_is_said_and_leaves_nothing(tmp_path):
    sweeps = Sweeps(tmp_path)
    sweeps.begin(replace(ASKED, spec=SPEC_OF.but(world="nonsense")))
    until(lambda: sweeps.now.set() or sweeps.seen.fault, 60)
    assert "unknown world 'nonsense'" in sweeps.seen.fault
    assert not list(tmp_path.iterdir())
    sweeps.close()


def store_of(folder: Path, text: str, runs: int, agents: int = 20, **more: object) -> Path:
    with Store(folder, ["polarisation"]) as store:
        spec = {"agents": agents, "informed": None, **more}
        cell = {"axes": {"eta": 0.1}, "identity": {"spec": spec}}
        (number,) = store.store_plan([("a", json.dumps(cell))])
        store.tell(kind="sweep", runs=runs, limit=100, columns=["polarisation"], axes=["eta"])
        store.add(number, 1, Outcome("ok", {"polarisation": 0.5}))
    (folder / SPEC).write_text(text)
    return folder


@pytest.mark.parametrize(
    ("text", "runs", "agents", "said"),
    [
        (OF_PAGE, 101, 20, "101 runs of a cell"),
        (OF_PAGE, 10, 3001, "3,001 agents"),
        ('[run]\nmodel = "mine.py"\nticks = 9\n', 10, 20, "code of its own"),
        (OF_PAGE + 'kinds = [{ name = "a", model = "mine.py" }]\n', 10, 20, "code of its own"),
        (OF_PAGE + 'kinds = [{ name = "a", policy = "mine" }]\n', 10, 20, "code of its own"),
        (OF_PAGE + '[[observe]]\nmeasure = "m.py:f"\n', 10, 20, "code of its own"),
        (OF_PAGE + '[[observe]]\nname = "order"\nmeasure = "m.py:f"\n', 10, 20, "either name or"),
        (OF_PAGE + 'world = "mine.toml"\n', 10, 20, "not of the page's kind"),
        (OF_PAGE + GRID_OF_WORLDS, 10, 20, "not of the page's kind"),
        (OF_PAGE + '[[design]]\nkind = "csv"\nfile = "/etc/hosts"\n', 10, 20, "not of the page"),
        (OF_PAGE + '[cluster]\nkind = "slurm"\n', 10, 20, "not of the page's kind"),
        (OF_PAGE + "[[record]]\nevery = 1\n", 10, 20, "not of the page's kind"),
        (OF_PAGE, 10, "many", "does not say what its runs are"),
        ("run = 5", 10, 20, "run"),
    ],
)
def test_the_page_goes_on_with_what_it_could_have_begun_only(tmp_path, text, runs, agents, said):
    with pytest.raises(InputError, match=said):
        demand_from_page(store_of(tmp_path / "one", text, runs, agents))
    demand_from_page(store_of(tmp_path / "two", OF_PAGE, 10))


def test_a_store_of_anything_else_is_no_sweep_and_a_broken_one_is_said(tmp_path):
    with Store(tmp_path / "paper", ["k"]) as store:
        store.tell(kind="paper")
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / FILE).write_bytes(b"nonsense" * 40)
    sweeps = Sweeps(tmp_path)
    sweeps.look()
    for _ in range(2):  # what is not read anew is said again
        sweeps.look()
        assert sweeps.seen.sweeps == ()
        (said,) = sweeps.seen.unread
        assert said.startswith("broken is not shown: ")
        assert said.endswith("is not a store of runs: move it away")
        assert html.escape(said) in status(None, sweeps.seen)
    shutil.rmtree(tmp_path / "broken")
    sweeps.look()
    assert sweeps.seen.unread == ()
    assert "fs-error" not in status(None, sweeps.seen)
    sweeps.close()


def drawn(axes: dict, cells: dict[int, CellRuns]) -> str:
    return picture(
        DrawnSweep("a<b", AxisModels("vem"), axes, ("polarisation",), "polarisation", cells, 10)
    )


def test_a_curve_marks_what_has_no_value_and_says_its_names_safely():
    groups = {
        1: CellRuns({"eta": 0.0}, 1, [0.9, 1.0], [1, 2]),
        2: CellRuns({"eta": 3.0}, 2, [0.4], [1], gave_up=1),
        3: CellRuns({"eta": 6.0}, 3, broken=2),
        4: CellRuns({"eta": 6.2}, 4),
    }
    made = drawn({"eta": [0.0, 3.0, 6.0, 6.2]}, groups)
    assert made.count("data-cell") == 3
    assert made.count('class="fs-point"') == 2
    assert made.count('class="fs-run"') == 3
    assert made.count('class="fs-gave-up"') == made.count('class="fs-broken"') == 1
    assert "a<b" not in made
    assert "eta = 3: 0.4, 1 run; 1 gave up" in made


def test_a_map_has_a_colour_for_each_cell_with_a_value():
    values = [0.0, 1.0, 2.0]
    groups = {
        1 + 3 * k + j: CellRuns({"eta": x, "v0": y}, 1, [0.1 * (k + j)], [1])
        for k, x in enumerate(values)
        for j, y in enumerate(values)
    }
    groups[9] = CellRuns({"eta": 2.0, "v0": 2.0}, 1)
    made = drawn({"eta": values, "v0": values}, groups)
    assert made.count('class="fs-cell"') == made.count("data-cell") == 8
    assert len(set(re.findall("fill: (#[0-9a-f]{6})", made))) == 4
    sample = {k: CellRuns({"eta": 0.1 * k, "v0": 0.3 * k}, k, [0.5], [1]) for k in range(10)}
    axes = {name: [one.axes[name] for one in sample.values()] for name in ("eta", "v0")}
    assert "A sample" in drawn(axes, sample)


def test_a_sweep_around_agents_that_differ_says_so_in_its_file_and_refuses_that_axis():
    spec = preset_spec("couzin", agents=9, parameters={"s": normal(3.0, 0.5)})
    asked = SweepRequest(spec, [Axis("r_r", 0.5, 1.5, 2)], "polarisation", 2, 10)
    assert asked.values()["run"]["parameters"]["s"] == {"normal": [3.0, 0.5]}
    with pytest.raises(InputError, match=r"s = normal\(3, 0.5\) differs from agent to agent"):
        replace(asked, axes=[Axis("s", 2.0, 4.0, 2)]).values()


HUNT = preset_spec(
    "vem",
    agents=9,
    kinds=[Kind("shark", 2, v0=0.05, to={"flock": chase(2.0, 1.5, catch=0.1)})],
    to={"shark": flee(3.0)},
)


def test_a_sweep_from_the_page_has_the_kinds_of_the_flock(tmp_path):
    """As they are in the flock, but for what is swept over."""
    axes = [Axis("shark.agents", 0, 4, 3), Axis("shark.flock.weight", 0.5, 2.0, 2)]
    asked = SweepRequest(HUNT, axes, "catches", 2, 10)
    (tmp_path / SPEC).write_text(asked.to_toml())
    made = read_sweep(tmp_path / SPEC)
    assert [tuple(cell.axes.values()) for cell in made.cells] == [
        (count, weight) for count in (0, 2, 4) for weight in (0.5, 2.0)
    ]
    for cell in made.cells:
        kinds = kind_table(cell.spec.kinds, cell.spec.to)
        assert (kinds.kind("shark").agents, kinds.of("shark", "flock").weight) == (
            *cell.axes.values(),
        )
        assert kinds.kind("shark").parameters == {"v0": 0.05}
        assert kinds.of("flock", "shark") == flee(3.0)
    assert asked.name == "vem-shark.agents-shark.flock.weight"


LONERS = preset_spec(
    "vem", agents=9, kinds=[Kind("loner", 4, model="gregoire-chate", v0=0.05, to={"flock": "own"})]
)
"""The noise of `gregoire-chate` goes up to 1, that of `vem` up to 2 pi."""


def test_a_sweep_from_the_page_takes_numbers_of_a_model_of_a_kind(tmp_path):
    asked = SweepRequest(LONERS, [Axis("loner.eta", 0.0, 1.0, 3)], "polarisation", 2, 10)
    (tmp_path / SPEC).write_text(asked.to_toml())
    made = read_sweep(tmp_path / SPEC)
    assert [cell.spec.kinds for cell in made.cells] == [
        (replace_kind(LONERS.kinds[0], parameters={"v0": 0.05, "eta": eta}),)
        for eta in (0.0, 0.5, 1.0)
    ]
    with pytest.raises(InputError, match=r"loner.eta = 2 is not in \[0, 1\]"):
        replace(asked, axes=[Axis("loner.eta", 0.0, 2.0, 2)]).values()
    replace(asked, axes=[Axis("eta", 0.0, 2.0, 2)]).values()


def test_the_form_offers_the_numbers_of_a_model_of_a_kind(laboratory):
    """With the range and the unit of that model, also where the kind then goes by another one."""
    form = laboratory.sweep.first
    form.count.value = 9
    laboratory.simulation.setup(LONERS)
    until(lambda: "loner: noise η" in form.over.options)
    titles = {name: title for title, name in form.names.items()}
    assert titles["loner.v0"] == "loner: speed v₀, length/tick"
    assert titles["loner.eta"] == "loner: noise η"
    until(lambda: "loner.v0" in laboratory.sweep.place.content)  # a mark at its slider
    assert form.choose("loner.eta")
    assert (form.low.max, form.high.max) == (1.0, 1.0)
    assert form.axis() == Axis("loner.eta", 0.0, 1.0, 9)
    until(lambda: "9 × " in laboratory.sweep.said.content)
    assert form.choose("loner.v0")
    assert form.axis() == Axis("loner.v0", 0.0, 1.0, 9)
    kinds = [replace_kind(LONERS.kinds[0], model="vicsek1995")]
    laboratory.simulation.setup(LONERS.with_values(kinds=kinds))
    until(lambda: "loner: noise η, rad" in form.over.options)
    until(lambda: form.axis() == Axis("loner.v0", 0.0, 0.2, 9))


def test_a_stored_sweep_is_drawn_with_the_numbers_of_a_model_of_a_kind(tmp_path):
    sweep(
        LONERS,
        vary={"loner.eta": [0.2, 0.4]},
        runs=1,
        ticks=5,
        observe=["polarisation"],
        folder=tmp_path,
        workers=1,
    )
    drawn = read_drawn_sweep(tmp_path)
    assert drawn.models == AxisModels("vem", {"loner": "gregoire-chate"})
    assert name_axis(drawn, "loner.eta") == "loner: noise η"
    shown = call("sweep", "show", tmp_path)
    assert "loner.eta: eta of loner\n" in shown.stdout


@pytest.mark.parametrize(
    "run", [None, [], {}, {"model": 3, "kinds": {"a": 1}}, {"kinds": ["a", {}]}]
)
def test_a_store_that_says_no_models_has_none(run):
    assert AxisModels.of_table(run) == AxisModels("", {})


def test_the_agents_of_kinds_count_towards_what_may_be_begun():
    swept = SweepRequest(HUNT, [Axis("shark.agents", 0, 2_991, 2)], "polarisation", 1, 10)
    swept.values()
    with pytest.raises(InputError, match="3,001 agents are not allowed from the page"):
        replace(swept, axes=[Axis("shark.agents", 0, 2_992, 2)]).values()
    many = HUNT.with_values(kinds=[Kind("shark", 2_992)], to={})
    with pytest.raises(InputError, match="3,001 agents are not allowed from the page"):
        replace(swept, spec=many, axes=[Axis("eta", 0, 1, 2)]).values()


@pytest.mark.parametrize(
    ("axis", "said"),
    [
        (Axis("whale.agents", 0, 2, 2), "whale.agents: unknown kind 'whale'"),
        (Axis("shark.k", 1, 2, 2), "shark.k: k cannot differ"),
        (Axis("shark.v0", 0, 2, 2), r"shark.v0 = 2 is not in \[0, 1\]"),
        (Axis("shark.flock.radius", 0, 2, 2), "shark.flock.radius = 0 is not in"),
        (Axis("flock.shark.catch", 0, 2, 2), "only who chases can catch"),
    ],
)
def test_an_axis_that_the_kinds_have_not_is_refused_before_anything_is_begun(axis, said):
    with pytest.raises(InputError, match=said):
        SweepRequest(HUNT, [axis], "polarisation", 1, 10).values()


UNKNOWN = "unknown policy 'dodge': give its file by --rule FILE.py"
OF_A_FILE = (
    "dodge is a policy of a file: its sweeps are begun on the command line, "
    "flockscope sweep run FILE.toml --rule FILE.py"
)
FLOWN = SPEC_OF.with_values(kinds=[Kind("robot", 2, policy="dodge")])


@pytest.mark.parametrize(("known", "said"), [(False, UNKNOWN), (True, OF_A_FILE)])
def test_a_policy_that_the_process_of_a_sweep_has_not_is_refused_before_it_begins(
    tmp_path, monkeypatch, known, said
):
    """As the command line refuses it, whether or not the page itself knows the policy."""
    if known:
        monkeypatch.setitem(POLICIES, "dodge", Policy(lambda seen: seen, "dodge"))
    sweeps = Sweeps(tmp_path)
    with pytest.raises(InputError) as refusal:
        sweeps.begin(replace(ASKED, spec=FLOWN))
    assert str(refusal.value) == said
    assert not list(tmp_path.iterdir())
    sweeps.close()


def test_a_policy_that_a_sweep_has_not_is_said_beside_the_button(laboratory):
    """At once, in the line of the command line, and the button cannot be pressed."""
    panel = laboratory.sweep
    laboratory.simulation.setup(FLOWN)
    until(lambda: html.escape(UNKNOWN) in panel.said.content)
    until(lambda: panel.start.disabled)
    laboratory.simulation.setup(SPEC_OF)
    until(lambda: "fs-error" not in panel.said.content)
    until(lambda: not panel.start.disabled)


def test_what_is_gone_on_with_counts_the_agents_of_kinds_too(tmp_path):
    kinds = [[{"name": "a", "agents": count}] for count in (2_990, 2_991)]
    demand_from_page(store_of(tmp_path / "a", OF_PAGE, 10, 10, kinds=kinds[0]))
    with pytest.raises(InputError, match="3,001 agents are not allowed"):
        demand_from_page(store_of(tmp_path / "b", OF_PAGE, 10, 10, kinds=kinds[1]))
    with pytest.raises(InputError, match="does not say what its runs are"):
        demand_from_page(store_of(tmp_path / "c", OF_PAGE, 10, 10, kinds=["a"]))


def test_the_form_offers_what_the_kinds_of_the_flock_have(laboratory):
    """Until there are none again; what was chosen is kept as long as the flock has it."""
    form = laboratory.sweep.first
    form.count.value = 9
    laboratory.simulation.setup(HUNT)
    until(lambda: "shark: agents" in form.over.options)
    assert {"shark: speed v₀, length/tick", "shark to flock: catch, length"} < {*form.over.options}
    until(lambda: "shark.flock.weight" in laboratory.sweep.place.content)  # a mark at its slider
    assert ask(laboratory.port, "/sweep/over?name=shark.flock.catch", OPENS).status == 200
    assert form.axis() == Axis("shark.flock.catch", 0.0, 0.2, 9)
    assert ask(laboratory.port, "/sweep/over?name=shark.agents", OPENS).status == 200
    assert form.axis() == Axis("shark.agents", 0.0, 4.0, 5)
    until(lambda: "5 × " in laboratory.sweep.said.content)
    form.high.value = 3.0
    differ = {**HUNT.parameters, "eta": normal(0.4, 0.1)}
    laboratory.simulation.setup(HUNT.with_parameters(differ))
    until(lambda: "eta.spread" in form.names.values())
    assert (form.axis().name, form.axis().high) == ("shark.agents", 3.0)
    laboratory.simulation.setup(SPEC_OF)
    until(lambda: "shark.agents" not in form.names.values())
    until(lambda: (axis := form.axis()) is not None and axis.name == "eta")
