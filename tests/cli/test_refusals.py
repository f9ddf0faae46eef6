"""What cannot be done: one line that names the thing, the value, what is allowed, where it is."""

import resource
import subprocess

import pytest

from cli.calling import PROGRAM, call, refusal

MODELS = "vem, vem-a, ivem"


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["vemm"], ["unknown model 'vemm'", "did you mean 'vem'?", MODELS]),
        ([], ["MODEL", "flockscope list models"]),
        (["vem", "--agents", "0"], ["agents = 0", ">= 1", "--agents"]),
        (["vem", "--seed", "-1"], ["seed = -1", ">= 0", "--seed"]),
        (["vem", "--informed", "-2"], ["informed = -2", ">= 0"]),
        (["vem", "--dim", "4"], ["dim = 4", "2 or 3 dimensions", "--dim"]),
        (["ivem", "--dim", "3"], ["dim = 3", "2-D", "--dim"]),
        (["vem", "--size", "0"], ["size = 0.0", "(0, 1e9)", "--size"]),
        (["vem", "--size", "nan"], ["size = nan", "(0, 1e9)"]),
        (["vem", "--size", "1,2,3", "--dim", "2"], ["3 sides", "2-D"]),
        (["vem", "--size", "wide"], ["--size 'wide'", "number"]),
        (["vem", "--world", "wrp"], ["unknown world 'wrp'", "did you mean 'wrap'?"]),
        (["vem", "--world", "no.toml"], ["no.toml", "No such file"]),
        (["vem", "--activation", "rand"], ["unknown activation 'rand'", "'random'"]),
        (["vem", "--noise", "angle"], ["unknown noise 'angle'", "'angular'"]),
        (["vem", "--threads", "0"], ["threads = 0", ">= 1"]),
        (["vem", "--ticks", "-1"], ["--ticks -1", ">= 0"]),
        (["vem", "--every", "0"], ["--every 0", ">= 1"]),
        (["vem", "--observe", "polarization"], ["'polarization'", "'polarisation'"]),
        (["vem", "--set", "eta=9"], ["eta = 9 rad", "[0, 6.2832]", "--set eta"]),
        (["vem", "--set", "eta=-0.1"], ["eta = -0.1 rad", "[0, 6.2832]"]),
        (["vem", "--set", "eta=nan"], ["eta = nan", "[0, 6.2832]"]),
        (["vem", "--set", "eta=inf"], ["eta = inf", "[0, 6.2832]"]),
        (["vem", "--set", "eta=much"], ["eta = 'much'", "[0, 6.2832]"]),
        (["vem", "--set", "eta"], ["--set eta", "NAME=VALUE"]),
        (["vem", "--set", "=3"], ["--set =3", "NAME=VALUE"]),
        (["hwvem", "--set", "p3=1"], ["unknown parameter 'p3'", "did you mean 'p2'?"]),
        (["hwvem", "--set", "layers=late"], ["layers = 'late'", "delayed, instant"]),
        (["--spec", "no.toml"], ["'no.toml'", "No such file"]),
        (["--state", "no.parquet"], ["'no.parquet'", "No such file"]),
    ],
)
def test_a_run_is_refused_in_one_line(args, words):
    line = refusal("run", *args)
    for word in words:
        assert word in line


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('model = "hwven"', ["'hwven'", "'hwvem'", "line 1"]),
        ('model = "vem"\nagents = "many"', ["agents = 'many'", ">= 1", "line 2"]),
        ('model = "vem"\nagnts = 3', ["unknown key 'agnts'", "'agents'", "line 2"]),
        ("model = 3", ["model = 3 is not a name", "line 1"]),
        ('model = "vem"\nworld = "wrp"', ["'wrp'", "'wrap'", "line 2"]),
        ('model = "vem"\nsize = [1.0, "x"]', ["size = ", "(0, 1e9)", "line 2"]),
        ('model = "vem"\n\n# noise\n[parameters]\neta = 9', ["eta = 9 rad", "6.2832", "line 5"]),
        ('model = "vem"\nparameters = { r = 1.0, eta = nan }', ["eta = nan", "line 2"]),
        ('model = "vem"\n[parameters]\nets = 1', ["unknown parameter 'ets'", "'eta'", "line 3"]),
        ('model = "vem"\nparameters = 4', ["parameters is not a table", "line 2"]),
        ('model = "vem"\nstart = "given"', ["start = 'given'", "--state", "line 2"]),
        ("model =\nseed = 3", ["is not TOML", "line 1"]),
        ("agents = 5", ["MODEL"]),
    ],
)
def test_a_spec_is_refused_with_file_and_line(tmp_path, text, words):
    spec = tmp_path / "run.toml"
    spec.write_text(text)
    line = refusal("run", "--spec", spec)
    for word in words:
        assert word in line
    assert str(spec) in line or word == "MODEL"


def test_a_file_that_is_not_what_it_claims_is_refused(tmp_path):
    wrong = tmp_path / "wrong"
    wrong.write_bytes(b"PAR1\x00\xff\xfe" * 9)
    assert "is not a text file" in refusal("run", "--spec", wrong)
    assert "is not a state or a recording" in refusal("run", "--state", wrong)
    (tmp_path / "world.toml").write_text("edges = [")
    assert "is not TOML" in refusal("run", "vem", "--world", tmp_path / "world.toml")
    assert "cannot be read" in refusal("run", "--spec", tmp_path)


def test_a_state_says_what_it_is_already(tmp_path):
    line = refusal("run", "vem", "--state", tmp_path / "x.parquet")
    assert "MODEL vem cannot be given with --state" in line


def test_a_parameter_that_a_state_cannot_take_is_refused(tmp_path):
    state = tmp_path / "state.parquet"
    assert call("run", "vem", "--ticks", 1, "--save", state, "--quiet").exit_code == 0
    assert "p1" in refusal("run", "--state", state, "--set", "p1=1")


def test_a_recording_is_not_overwritten_unless_asked(tmp_path):
    path = tmp_path / "run.parquet"
    path.write_text("mine")
    assert "exists already" in refusal("run", "vem", "--record", path)
    assert path.read_text() == "mine"
    args = ("run", "vem", "--ticks", 2, "--record", path, "--overwrite", "--quiet")
    assert call(*args).exit_code == 0
    assert path.read_bytes()[:4] == b"PAR1"


def test_a_folder_that_is_not_there_is_refused(tmp_path):
    nowhere = tmp_path / "no" / "run.parquet"
    for option in ("--record", "--save", "--save-spec"):
        line = refusal("run", "vem", "--ticks", 1, "--quiet", option, nowhere)
        assert "cannot be written: No such file" in line


def test_more_agents_than_memory_is_refused():
    line = refusal("run", "vem", "--agents", 10**13, "--size", "10")
    assert "not enough memory" in line


def test_a_full_disk_is_one_line_and_leaves_nothing(tmp_path):
    assert call("run", "hwvem", "--agents", 2000, "--ticks", 1, "--quiet").exit_code == 0

    def little_room():
        resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, 1_000_000))

    made = subprocess.run(
        [*PROGRAM, "run", "hwvem", "--agents", "2000", "--ticks", "60", "--quiet",
         "--record", str(tmp_path / "run.parquet")],
        capture_output=True, text=True, preexec_fn=little_room, check=False,
    )  # fmt: skip
    assert made.returncode == 2
    assert made.stdout == ""
    assert made.stderr.count("\n") == 1
    assert "run.parquet' cannot be written: File too large" in made.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["list", "model"], ["unknown list 'model'", "'models'"]),
        (["paper", "liu2021-tabel1"], ["unknown paper", "did you mean 'liu2021-table1'?"]),
        (["paper", "liu2021-table1", "--runs", "1"], ["--runs 1", ">= 2"]),
        (["paper", "liu2021-table1", "--workers", "0"], ["--workers 0", ">= 1"]),
        (["paper", "liu2021-table1", "--models", "hwven"], ["'hwven'", "'hwvem'"]),
        (["paper", "liu2021-table1", "--agents", "300"], ["'300'", "100, 200, 500"]),
        (["paper", "liu2021-table1", "--agents", "few"], ["--agents 'few'", "whole number"]),
        (["recover", "no.parquet.part"], ["no.parquet.part", "No such file"]),
        (["recover", "run.parquet"], ["run.parquet", "not a .part file"]),
    ],
)
def test_other_commands_are_refused_in_one_line(args, words):
    line = refusal(*args)
    for word in words:
        assert word in line


@pytest.mark.parametrize(
    "args",
    [["rnu"], ["run", "vem", "--tikcs", "3"], ["run", "vem", "--ticks", "few"], ["recover"]],
)
def test_wrong_usage_is_exit_code_2(args):
    result = call(*args)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
