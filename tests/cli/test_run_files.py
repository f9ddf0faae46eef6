"""`flockscope run FILE`: specs, scenes, states and recordings, as the laboratory opens them."""

from __future__ import annotations

import json

import numpy as np
import pytest

from agents.flock import Flock
from agents.spec import Spec
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.run.run_preset import preset_spec
from tests.cli.calling import call, refusal
from worlds.layout import world

RUN = {"agents": 20, "seed": 5, "parameters": {"eta": 0.7}}


def observed(*args) -> tuple[dict, str]:
    """The spec of what is run and its polarisation; what is told."""
    result = call("run", *args, "--json", "--observe", "polarisation")
    assert result.exit_code == 0, result.stderr
    made = json.loads(result.stdout)
    return made, result.stderr


@pytest.fixture
def spec():
    return preset_spec("vem", **RUN)


def test_a_spec_runs_as_its_flock_does(tmp_path, spec):
    path = tmp_path / "spec.toml"
    path.write_text(spec.to_toml())
    flock = Flock(spec)
    flock.run(30)
    made, _ = observed(path, "--ticks", 30)
    assert made["observables"]["polarisation"] == flock.observe("polarisation")
    changed, _ = observed(path, "--ticks", 30, "--set", "eta=2", "--agents", 9)
    assert changed["spec"]["parameters"]["eta"] == 2.0
    assert changed["spec"]["agents"] == 9


def test_a_scene_is_run_without_its_page(tmp_path, spec):
    path = tmp_path / "scene.toml"
    path.write_text(SavedScene("mine", spec, beside=Spec("ivem"), speed=3.0).to_toml())
    made, told = observed(path, "--ticks", 5)
    flock = Flock(spec)
    flock.run(5)
    assert made["observables"]["polarisation"] == flock.observe("polarisation")
    assert f"ivem, which {path} shows beside it, is not run" in told
    by_option, _ = observed("--spec", path, "--ticks", 5)
    assert by_option["observables"] == made["observables"]


def test_a_scene_carries_its_own_world(tmp_path):
    spec = preset_spec("vem", agents=12, seed=2, world=world("obstacles"))
    path = tmp_path / "scene.toml"
    path.write_text(SavedScene("mine", spec).to_toml())
    flock = Flock(spec)
    flock.run(5)
    made, _ = observed(path, "--ticks", 5)
    assert made["observables"]["polarisation"] == flock.observe("polarisation")


@pytest.mark.parametrize("name", ["state.parquet", "recording.parquet", "nameless"])
def test_a_state_and_a_recording_go_on_whatever_they_are_called(tmp_path, name, spec):
    path, whole = tmp_path / name, Flock(spec)
    option = "--record" if name == "recording.parquet" else "--save"
    made = tmp_path / "made.parquet"
    (tmp_path / "spec.toml").write_text(spec.to_toml())
    observed(tmp_path / "spec.toml", "--ticks", 7, "--every", 2, option, made)
    made.rename(path)
    whole.run(12)
    gone_on, _ = observed(path, "--ticks", 5)
    assert gone_on["tick"] == 12
    assert gone_on["observables"]["polarisation"] == whole.observe("polarisation")


def test_what_a_file_says_cannot_be_said_again(tmp_path, spec):
    state, toml = tmp_path / "state.parquet", tmp_path / "spec.toml"
    toml.write_text(spec.to_toml())
    observed(toml, "--ticks", 1, "--save", state)
    line = refusal("run", state, "--agents", 3)
    assert f"--agents 3 cannot be given with {state}, which says it already" in line
    line = refusal("run", toml, "--state", state)
    assert f"--state {state} cannot be given with {toml}, which says it already" in line
    assert f"--spec {toml} cannot be given with" in refusal("run", state, "--spec", toml)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"[run]\nmodel = 'vemm'\n", "unknown model 'vemm': did you mean 'vem'?"),
        (b"[run]\nmodel = 'vem'\n[run.parameters]\neta = 99\n", "eta = 99 rad is outside"),
        (b"tick,id,x\n", "is a recording as CSV, which has no spec"),
        (b"PK\x03\x04", "is a ZIP, as of two flocks side by side"),
        (b"PAR1\x00", "is not a state or a recording"),
        (b"\x89PNG\x00", "is no file that the laboratory opens"),
    ],
)
def test_other_files_are_refused_in_one_line(tmp_path, content, words):
    path = tmp_path / "file.dat"
    path.write_bytes(content)
    assert words in refusal("run", path)


def test_seconds_are_the_ticks_that_reach_them():
    made, _ = observed("reynolds", "--agents", 9, "--seconds", 0.31, "--set", "dt=0.1")
    assert (made["tick"], made["ticks"]) == (4, 4)
    assert made["time"] == pytest.approx(0.4)
    made, _ = observed("reynolds", "--agents", 9, "--seconds", 0.3, "--set", "dt=0.1")
    assert made["tick"] == 3


def test_films_take_the_same_lengths(tmp_path):
    pytest.importorskip("matplotlib")
    out = ("--out", tmp_path / "film.gif", "--overwrite", "--renderer", "plain", "--json")
    run = ("film", "reynolds", "--agents", 5, "--seed", 1, "--set", "dt=0.1", "--pixels", "320x320")
    ends = [
        json.loads(call(*run, "--from", 2, *length, *out, "--quiet").stdout)["last_tick"]
        for length in (("--to", 5), ("--ticks", 3), ("--seconds", 0.3))
    ]
    assert ends == [5, 5, 5]


def test_sweeps_take_the_same_lengths():
    lines = [
        call("sweep", "check", "reynolds", "--vary", "agents=4,5", "--runs", 1,
             "--set", "dt=0.1", *length).stdout
        for length in (("--ticks", 5), ("--seconds", 0.5))
    ]  # fmt: skip
    assert all("2 runs of 5 ticks" in line for line in lines)
    args = ("sweep", "check", "reynolds", "--runs", 1, "--seconds", 2)
    assert "give --ticks" in refusal(*args, "--vary", "dt=0.1,0.2")
    assert "vem counts ticks" in refusal(
        "sweep", "check", "vem", "--vary", "eta=1,2", "--seconds", 2
    )
    line = refusal("sweep", "check", "vem", "--vary", "agent=10,20")
    assert "unknown parameter 'agent': did you mean 'agents'?" in line


def test_python_suggests_among_all_words_that_it_takes():
    for words, meant in (
        ({"agent": 5}, "agents"),
        ({"sead": 1}, "seed"),
        ({"thread": 1}, "threads"),
    ):
        with pytest.raises(ValueError, match=f"did you mean '{meant}'"):
            Flock("vem", **words)
    assert np.isfinite(Flock("vem", agents=5).position).all()
