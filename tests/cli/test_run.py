"""`flockscope run`: its numbers, its JSON, specs, states."""

import json

import numpy as np
import pytest

from agents import Flock
from agents.spec import Spec
from cli.calling import call


def outcome(*args):
    result = call("run", *args, "--json", "--quiet")
    assert result.exit_code == 0, result.stderr
    assert result.stderr == ""
    return json.loads(result.stdout)


def test_it_gives_what_a_script_gives():
    made = outcome("hwvem", "--agents", 60, "--ticks", 20, "--seed", 3, "--set", "p1=0.2")
    flock = Flock("hwvem", agents=60, rng=3, p1=0.2)
    flock.run(20)
    assert made["observables"]["polarisation"] == flock.observe("polarisation")
    assert made["observables"]["consistency"] == flock.observe("consistency")
    assert (made["tick"], made["ticks"]) == (20, 20)
    assert Spec(**made["spec"]) == flock.spec


def test_the_same_seed_gives_the_same_numbers_and_another_seed_others():
    first, again, other = (
        outcome("vem", "--set", "eta=1.5", "--seed", seed, "--ticks", 30)["observables"]
        for seed in (5, 5, 6)
    )
    assert first == again
    assert first != other


@pytest.fixture
def built(monkeypatch):
    """The models of the flocks that are built."""
    models = []
    begin = Flock.__init__

    def noted(flock, model, **more):
        models.append(getattr(model, "model", model))
        begin(flock, model, **more)

    monkeypatch.setattr(Flock, "__init__", noted)
    return models


@pytest.mark.parametrize(
    "more",
    [
        (),
        ("--json",),
        ("--record", "new.parquet", "--every", 2),
        ("--save", "new.parquet", "--save-spec", "new.toml"),
        ("--over", 3, "--observe", "all"),
        ("--interpret",),
    ],
)
@pytest.mark.parametrize(
    "what",
    [
        ("vem", "--seed", 1, "--activation", "random"),
        ("hwvem-nav", "--agents", 12),
        ("run.toml",),
        ("--spec", "run.toml", "--agents", 7),
        ("state.parquet",),
    ],
)
def test_a_run_builds_one_flock(what, more, built, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    flock = Flock("vem", agents=5, rng=1)
    flock.save("state.parquet")
    (tmp_path / "run.toml").write_text(flock.spec.to_toml())
    built.clear()
    result = call("run", *what, "--ticks", 3, *more)
    assert result.exit_code == 0, result.stderr
    assert built == ["hwvem-nav" if "hwvem-nav" in what else "vem"]


def test_every_option_reaches_the_spec():
    made = outcome(
        "vem", "--agents", 30, "--size", "4,6,5", "--dim", 3, "--world", "open", "--informed", 2,
        "--activation", "random", "--noise", "vectorial", "--threads", 2, "--ticks", 2,
        "--set", "eta=0.5", "--set", "r=0.8",
    )  # fmt: skip
    spec = made["spec"]
    assert spec["size"] == [4.0, 6.0, 5.0]
    assert (spec["agents"], spec["informed"], spec["world"]) == (30, 2, "open")
    assert (spec["activation"], spec["noise"]) == ("random", "vectorial")
    assert (spec["parameters"]["eta"], spec["parameters"]["r"]) == (0.5, 0.8)


def test_all_observables_are_valid_json_even_for_a_lone_agent():
    made = outcome("vem", "--agents", 1, "--ticks", 1, "--observe", "all")
    assert made["observables"]["nearest-neighbour"] is None
    assert made["observables"]["polarisation"] == pytest.approx(1.0)


def test_the_table_for_people_names_what_was_observed():
    result = call("run", "vem", "--ticks", 3, "--seed", 1, "--observe", "groups,polarisation")
    assert result.exit_code == 0
    assert "Vicsek model: 100 agents" in result.stdout
    assert "groups" in result.stdout
    assert "consistency" not in result.stdout


def test_no_ticks_is_a_run():
    assert outcome("vem", "--ticks", 0)["tick"] == 0


def test_a_spec_comes_back_to_the_bit(tmp_path):
    spec = tmp_path / "run.toml"
    first = outcome("hwvem", "--agents", 40, "--seed", 8, "--set", "p2=3.3", "--set", "eta=0.1",
                    "--save-spec", spec)  # fmt: skip
    again = outcome("--spec", spec)
    assert again["observables"] == first["observables"]
    assert again["spec"] == first["spec"]


def test_options_and_settings_win_over_a_spec(tmp_path):
    spec = tmp_path / "run.toml"
    spec.write_text('model = "hwvem"\nagents = 40\nseed = 8\n[parameters]\np1 = 1.0\np2 = 7.0\n')
    made = outcome("--spec", spec, "--agents", 30, "--set", "p1=0.5", "--ticks", 1)["spec"]
    assert (made["agents"], made["seed"]) == (30, 8)
    assert (made["parameters"]["p1"], made["parameters"]["p2"]) == (0.5, 7.0)


def test_a_spec_of_other_versions_is_told(tmp_path):
    spec = tmp_path / "run.toml"
    spec.write_text('model = "vem"\n[versions]\nnumba = "0.1"\n')
    result = call("run", "--spec", spec, "--ticks", 1, "--json")
    assert result.exit_code == 0
    assert "numba 0.1, here" in result.stderr
    assert "random-numbers 1, here 2" in result.stderr, "what was written before they had versions"
    json.loads(result.stdout)


def test_a_state_of_other_random_numbers_is_told(tmp_path):
    state = tmp_path / "state.parquet"
    flock = Flock("vem", agents=5, rng=1)
    saved = flock.spec.with_values(versions={"numba": "0.1"})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Flock, "spec", property(lambda _: saved))
        flock.save(state)
    said = call("run", state, "--ticks", 1).stderr
    assert "the state was saved with random-numbers 1, here 2; numba 0.1, here" in said


def test_a_state_goes_on_to_the_bit(tmp_path):
    state = tmp_path / "state.parquet"
    made_of = ("hwvem", "--agents", 50, "--seed", 4, "--set", "eta=0.3")
    outcome(*made_of, "--ticks", 17, "--save", state)
    again = outcome("--state", state, "--ticks", 23)
    whole = outcome(*made_of, "--ticks", 40)
    assert again["tick"] == 40
    assert again["observables"] == whole["observables"]


def test_settings_change_the_parameters_of_a_state(tmp_path):
    state = tmp_path / "state.parquet"
    outcome("vem", "--ticks", 2, "--save", state)
    again = ("--state", state, "--ticks", 1, "--set", "eta=1.25", "--save", state, "--overwrite")
    made = outcome(*again)
    assert made["spec"]["parameters"]["eta"] == 1.25
    assert Flock.load(state).tick == 3


def test_long_runs_in_stretches_are_one_run():
    made = outcome("vem", "--agents", 20, "--ticks", 3000, "--seed", 2, "--set", "eta=0.4")
    flock = Flock("vem", agents=20, rng=2, eta=0.4)
    flock.run(3000)
    assert made["observables"]["polarisation"] == flock.observe("polarisation")
    assert np.isfinite(flock.position).all()
