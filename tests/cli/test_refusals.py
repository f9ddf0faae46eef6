"""What cannot be done: one line that names the thing, the value, what is allowed, where it is."""

import os
import re
import resource
import subprocess

import pyarrow.parquet as pq
import pytest

from agents import Flock
from agents.spec import Spec
from cli.calling import PROGRAM, call, refusal
from worlds import memory
from worlds.input_error import InputError

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
        (["vem", "--noise", "angle"], ["unknown noise 'angle'", "(known: angular,"]),
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
        (["hwvem", "--set", "p3=1"], ["unknown parameter 'p3'", "did you mean 'p1'?"]),
        (["vem", "--set", "agent=50"], ["unknown parameter 'agent': did you mean --agents 50?"]),
        (["vem", "--set", "agents=50"], ["did you mean --agents 50?", "--set agents"]),
        (["vem", "--set", "qqq=5"], ["unknown parameter 'qqq' (known: r, eta"]),
        (["nope.toml"], ["'nope.toml' cannot be read: No such file"]),
        (["vem", "--seconds", "3"], ["--seconds 3 is not allowed: vem counts ticks"]),
        (["vem", "--seconds", "-1"], ["--seconds -1 is outside [0, 1e6)"]),
        (["vem", "--seconds", "3", "--ticks", "3"], ["--ticks and --seconds exclude each other"]),
        (["reynolds", "--seconds", "0.1", "--over", "90"], ["--over 90 is more than"]),
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
        ('model = "vem"\nagents = "many"', ["agents = 'many'", "a whole number >= 0", "line 2"]),
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
    assert "MODEL vem cannot be given with" in line
    assert "x.parquet, which says it already" in line


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
        path = nowhere.with_suffix(".toml") if option == "--save-spec" else nowhere
        line = refusal("run", "vem", "--ticks", 1, "--quiet", option, path)
        assert f"cannot be written: there is no folder '{nowhere.parent}'" in line


def test_more_agents_than_memory_is_refused(monkeypatch):
    line = refusal("run", "vem", "--agents", 10**13, "--size", "10")
    assert "agents = 10000000000000 is not allowed: about 1.39e+06 GB of memory" in line
    monkeypatch.setattr(memory, "memory_available", lambda: 8e9)
    line = refusal("run", "vem", "--agents", 10**9)
    assert line == (
        "flockscope: agents = 1000000000 is not allowed: about 139 GB of memory would be needed, "
        "this machine has 8 GB (--agents)"
    )


def test_a_full_disk_is_one_line_and_keeps_the_frames_that_fitted(tmp_path):
    assert call("run", "hwvem", "--agents", 2000, "--ticks", 1, "--quiet").exit_code == 0

    def little_room():
        resource.setrlimit(resource.RLIMIT_FSIZE, (4_000_000, 4_000_000))

    made = subprocess.run(
        [*PROGRAM, "run", "hwvem", "--agents", "2000", "--ticks", "60", "--quiet",
         "--record", str(tmp_path / "run.parquet")],
        capture_output=True, text=True, preexec_fn=little_room, check=False,
    )  # fmt: skip
    assert made.returncode == 2
    assert made.stdout == ""
    assert made.stderr.count("\n") == 1
    assert "run.parquet' cannot be written: File too large" in made.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["run.parquet"]
    found = re.search(r"it holds (\d+) frames that fitted, the last of tick (\d+)$", made.stderr)
    ticks = pq.read_table(tmp_path / "run.parquet")["tick"].to_pylist()
    assert int(found[1]) == len(set(ticks)) > 0
    assert int(found[2]) == max(ticks) == len(set(ticks)) - 1
    assert len(ticks) == 2001 * len(set(ticks)), "a frame is whole or not there"


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["list", "model"], ["unknown name 'model'", "'models'", "`flockscope list`"]),
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
    ("args", "line"),
    [
        (["run", "vem", "--tikcs", "3"],
         "unknown option '--tikcs': did you mean '--ticks'? (flockscope run --help)"),
        (["run", "vem", "--ticks", "few"],
         "--ticks 'few' is not allowed: a whole number is needed (flockscope run --help)"),
        (["run", "vem", "--ticks"], "--ticks needs a value"),
        (["run", "vem", "--json=3"], "--json takes no value"),
        (["run", "vem", "wvem"], "unexpected argument 'wvem' (flockscope run --help)"),
        (["run", "vem", "agent=50"],
         "unexpected argument 'agent=50': did you mean '--agents 50'? (flockscope run --help)"),
        (["run", "vem", "eta=0.5"],
         "unexpected argument 'eta=0.5': did you mean '--set eta=0.5'? (flockscope run --help)"),
        (["run", "vem", "--eta", "0.5"],
         "unknown option '--eta': did you mean '--set eta=...'? (flockscope run --help)"),
        (["run", "vem", "--steps", "5"],
         "unknown option '--steps': did you mean '--ticks'? (flockscope run --help)"),
        (["picture", "vem", "--nise", "5"],
         "unknown option '--nise': did you mean '--noise'? (flockscope picture --help)"),
        (["world", "list", "--wobble"],
         "unknown option '--wobble' (flockscope world list --help)"),
        (["flight", "simulate", "--ticks", "4"],
         "unknown option '--ticks': did you mean '--seconds'? (flockscope flight simulate --help)"),
        (["film", "vem", "--ticks", "4", "--to", "9"],
         "--ticks and --to exclude each other: both say how long it lasts"),
        (["recover"], "FILE is missing (flockscope recover --help)"),
        (["lab", "--port", "99999", "--no-open"],
         "--port '99999' is not allowed: a number <= 65535 is needed (flockscope lab --help)"),
        (["world", "show", "wrap", "--dim", "7"],
         "--dim '7' is not allowed: a number <= 3 is needed (flockscope world show --help)"),
        (["lab", "--beside", "vem", "--beside", "ivem"],
         "--beside is given 2 times (flockscope lab --help)"),
        (["run", "vem", "--seed", "1", "--seed=1"],
         "--seed is given 2 times (flockscope run --help)"),
    ],
)  # fmt: skip
def test_wrong_usage_is_one_line_and_exit_code_2(args, line):
    assert refusal(*args) == f"flockscope: {line}"


def test_a_wrong_command_is_named_with_the_nearest():
    assert "unknown command 'rnu': did you mean 'run'? (known: lab, class, run" in refusal("rnu")
    assert "unknown command 'sho': did you mean 'show'?" in refusal("world", "sho")


def test_what_may_be_repeated_may_be_repeated():
    args = ("run", "vem", "--ticks", 1, "--set", "eta=0.1", "--set", "r=2", "--json", "--json")
    assert call(*args, "--quiet").exit_code == 0


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["--seed", "9" * 40], ["seed = 9999", "the largest is 9223372036854775807", "--seed"]),
        (["--threads", "1000000"], ["threads = 1000000", "the largest is 1024"]),
        (["--ticks", "9" * 30], ["--ticks 999", "the largest is 1000000000000000"]),
        (["--world", "plan.dxf"],
         ["'plan.dxf' is a drawing", "`flockscope world import plan.dxf --out plan.toml`"]),
        (["--world", "a b.WKT"], ["`flockscope world import 'a b.WKT' --out 'a b.toml'`"]),
        (["--world", "x.geojson"], ["world import"]),
        (["--world", "x.json"], ["world import"]),
    ],
)  # fmt: skip
def test_what_ended_in_a_traceback_is_refused_in_one_line(args, words):
    line = refusal("run", "vem", *args)
    for word in words:
        assert word in line


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = " + "[" * 100_000, "tables or lists lie more than 50 deep"),
        ("x = " + "{a=" * 100_000, "tables or lists lie more than 50 deep"),
        ("a." * 100_000 + "b = 1", "tables or lists lie more than 50 deep"),
        ("x = " + "[" * 60 + "]" * 60, "tables or lists lie more than 50 deep"),
        ("x = " + "9" * 5000, "too many digits"),
    ],
)
def test_a_file_that_is_nested_too_deep_is_refused(tmp_path, text, words):
    path = tmp_path / "deep.toml"
    path.write_text(text)
    assert words in refusal("run", "--spec", path)
    assert words in refusal("run", "vem", "--world", path)
    assert words in refusal("live", "run", path, "--dry")


def test_a_seed_or_a_spec_too_large_is_refused_from_python():
    with pytest.raises(
        InputError, match=r"seed = 16069\d+\.\.\.\d+ is not allowed: the largest is"
    ):
        Flock("vem", rng=2**200)
    with pytest.raises(
        InputError, match=r"seed = 9\d+ is not allowed: the largest is 9\d+ \(here\)"
    ):
        Spec.from_values({"model": "vem", "agents": 3, "informed": 0, "seed": 2**63,
                          "world": "wrap", "size": (1.0, 1.0)}, "here")  # fmt: skip
    assert Flock("vem", agents=2, rng=2**63 - 1).spec.seed == 2**63 - 1


@pytest.mark.parametrize(
    "args", [("run", "nope"), ("run", "vem", "--nope", "2"), ("list", "nothing")]
)
def test_the_exit_code_says_so_where_no_word_can_be_written(args):
    with open("/dev/full", "w") as full:
        made = subprocess.run([*PROGRAM, *args], stderr=full, stdout=subprocess.DEVNULL)
    assert made.returncode == 2


def test_a_result_that_cannot_be_written_is_an_error_in_one_line():
    with open("/dev/full", "w") as full:
        command = [*PROGRAM, "list", "models"]
        made = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True)
    assert (made.returncode, made.stderr) == (2, "flockscope: No space left on device\n")


@pytest.mark.parametrize("kilobytes", [200_000, 400_000])
def test_too_little_memory_for_the_libraries_is_one_line(kilobytes):
    """What lacks differs from machine to machine: LLVM, a library of NumPy, a thread."""
    limit = 1024 * kilobytes
    made = subprocess.run(
        [*PROGRAM, "run", "vem", "--ticks", "1"],
        capture_output=True, text=True, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)),
    )  # fmt: skip
    assert made.returncode == 2, made.stderr
    told = f"there is not enough memory: `ulimit -v` allows {kilobytes} kB; allow more, or lift it"
    assert made.stderr == f"flockscope: {told}\n"
