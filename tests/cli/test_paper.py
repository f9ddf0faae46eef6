"""`flockscope paper`: JSON, files, resuming, Ctrl-C."""

import json
import signal

import pytest
from experiments.small import TEXT

from app.studies.figures.convergence import ConvergenceSettings
from app.studies.runs.store_reader import StoreReader, readable
from cli.calling import call, refusal, start, wait_until

SMALL = ("paper", "liu2021-table1", "--agents", "100", "--models", "vem,hwvem", "--runs", "6")


def test_it_prints_json_and_writes_its_files(tmp_path):
    result = call(*SMALL, "--out", tmp_path, "--json", "--quiet")
    assert result.exit_code == 0, result.stderr
    assert result.stderr == ""
    made = json.loads(result.stdout)
    compared = [row for row in made["rows"] if row["measure"] == "k_con"]
    assert [(row["model"], row["runs"]) for row in compared] == [("vem", 6), ("hwvem", 6)]
    assert made["rows"][0]["published_mean"] == 84.31
    assert made["runs"] == {"made": 12, "taken": 0}
    assert {path.name for path in tmp_path.iterdir()} == {
        "runs.sqlite", "summary.csv", ".lock", "liu2021-table1.png", "liu2021-table1.svg",
    }  # fmt: skip


def test_a_second_call_takes_what_is_done_and_says_the_same(tmp_path):
    first = call(*SMALL, "--out", tmp_path, "--no-pictures")
    again = call(*SMALL, "--out", tmp_path, "--no-pictures")
    assert again.stdout == first.stdout
    assert "paper  " in again.stdout
    assert "0 runs made" in again.stderr
    assert "12 taken from" in again.stderr


@pytest.mark.exhaustive
def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(tmp_path):
    args = ("paper", "liu2021-table1", "--agents", "500", "--models", "vem-a", "--out", tmp_path)

    def done():
        return StoreReader(tmp_path).counts["ok"] if readable(tmp_path) else 0

    process = start(*args, "--runs", 100, "--quiet", "--json")
    wait_until(lambda: done() > 2, process)
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 130
    assert stdout == ""
    (line,) = stderr.strip().split("\n")
    assert "go on with: flockscope paper liu2021-table1" in line
    assert 3 <= done() < 100
    first = min(seed for _, seed, status, *_ in StoreReader(tmp_path).runs([]) if status == "ok")
    result = call(*args, "--runs", max(first, 3), "--json", "--quiet", "--no-pictures")
    assert json.loads(result.stdout)["runs"]["taken"] >= 1


def test_a_folder_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    result = call(*SMALL, "--out", tmp_path / "file" / "deep", "--quiet")
    assert result.exit_code == 2
    assert "cannot be written" in result.stderr
    assert result.stderr.count("\n") == 1


def test_a_table_of_ones_own_is_judged_as_the_papers_are(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(TEXT.replace("mean = 5.0", "mean = 50.0", 1))
    result = call("paper", path, "--out", tmp_path / "out", "--json", "--quiet", "--runs", 20)
    assert result.exit_code == 0, result.stderr
    made = json.loads(result.stdout)
    assert (made["name"], made["title"]) == ("mine", "Small")
    assert made["rows"][0]["verdict"] == "differs"
    assert (tmp_path / "out" / "mine.svg").exists()
    assert "cannot be read" in refusal("paper", tmp_path / "other.toml")


def test_a_run_that_raises_is_told_and_its_seed_is_left_out(tmp_path, monkeypatch):
    before = ConvergenceSettings.run

    def run(settings, flock, between):
        if flock.seed == 2 and flock.model.name == "hwvem":
            raise ValueError("no such luck")
        return before(settings, flock, between)

    (tmp_path / "mine.toml").write_text(TEXT)
    monkeypatch.setattr(ConvergenceSettings, "run", run)
    args = ("paper", tmp_path / "mine.toml", "--out", tmp_path, "--json", "--quiet")
    result = call(*args)
    assert result.exit_code == 3
    assert "seed 2: ValueError: no such luck" in result.stderr
    made = json.loads(result.stdout)
    assert [row["runs"] for row in made["rows"]] == [3, 3]
    assert made["runs"] == {"made": 8, "taken": 0}
    monkeypatch.setattr(ConvergenceSettings, "run", before)
    assert call(*args).exit_code == 3, "what failed is not made again unasked"
    again = call(*args, "--retry-failed")
    assert again.exit_code == 0
    assert json.loads(again.stdout)["runs"] == {"made": 1, "taken": 7}


QUICK = ("--no-pictures", "--runs", "2")


def test_it_says_beforehand_what_so_many_runs_can_decide(tmp_path):
    result = call("paper", "wu2023-plain", *QUICK, "--out", tmp_path)
    assert "2 runs can decide 0 of 1 claims" in result.stderr
    assert "too few to bear out: settled (44)" in result.stderr
    assert "4 runs to make, about " in result.stderr


@pytest.mark.parametrize(("strict", "code"), [((), 0), (("--strict",), 3)])
def test_strict_is_told_by_the_exit_code(tmp_path, strict, code):
    result = call("paper", "jacobs-fig2", "--out", tmp_path, "--no-pictures", *strict)
    assert result.exit_code == code
    assert "does not hold  all: at 0 below -1000" in result.stdout
    assert "expected: does not hold; (3) is bounded" in " ".join(result.stdout.split())


def test_all_of_them_end_with_a_table_of_verdicts(tmp_path, monkeypatch):
    names = ["jacobs-fig2", "wu2023-plain"]
    monkeypatch.setattr("app.studies.experiment_reader.experiment_names", lambda: names)
    result = call("paper", "--all", *QUICK, "--out", tmp_path)
    assert result.exit_code == 0, result.stderr
    table = result.stdout[result.stdout.index("verdicts on rows") :]
    lines = [line.split() for line in table.splitlines()]
    assert ["jacobs-fig2", "2", "2", "1"] in lines
    assert ["wu2023-plain", "2", "1"] in lines
    assert ["all", "2", "1", "1"] in lines
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    value = json.loads(call("paper", "--all", *QUICK, "--out", tmp_path, "--json").stdout)
    assert [one["name"] for one in value["papers"]] == names
    claims = value["papers"][0]["claims"]
    assert [one["verdict"] for one in claims] == ["holds", "holds", "does not hold"]
    assert claims[2]["expected"] == "does not hold"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "say which paper, or --all"),
        (("liu2021-fig6", "--all"), "say which paper, or --all"),
        (("--all", "--agents", "100"), "leave --agents and --models out"),
        (("--all", "--runs", "0"), "--runs"),
    ],
)
def test_what_cannot_be_meant_is_refused(words, said):
    result = call("paper", *words)
    assert result.exit_code == 2
    assert said in result.stderr
    assert result.stderr.count("\n") == 1
