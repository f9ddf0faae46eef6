"""`flockscope paper`: JSON, files, resuming, Ctrl-C."""

import json
import signal

from cli.calling import call, start, wait_until

SMALL = ("paper", "liu2021-table1", "--agents", "100", "--models", "vem,hwvem", "--runs", "6")


def test_it_prints_json_and_writes_its_files(tmp_path):
    result = call(*SMALL, "--out", tmp_path, "--json", "--quiet")
    assert result.exit_code == 0, result.stderr
    assert result.stderr == ""
    made = json.loads(result.stdout)
    assert [(row["model"], row["runs"]) for row in made["rows"]] == [("vem", 6), ("hwvem", 6)]
    assert made["rows"][0]["published_mean"] == 84.31
    assert made["runs"] == {"made": 12, "taken": 0}
    assert {path.name for path in tmp_path.iterdir()} == {
        "runs.csv", "summary.csv", "liu2021-table1.png", "liu2021-table1.svg",
    }  # fmt: skip


def test_a_second_call_takes_what_is_done_and_says_the_same(tmp_path):
    first = call(*SMALL, "--out", tmp_path, "--no-pictures")
    again = call(*SMALL, "--out", tmp_path, "--no-pictures")
    assert again.stdout == first.stdout
    assert "published" in again.stdout
    assert "0 runs made" in again.stderr
    assert "12 taken from" in again.stderr


def test_ctrl_c_keeps_what_is_done_and_says_how_to_go_on(tmp_path):
    args = ("paper", "liu2021-table1", "--agents", "500", "--models", "vem-a", "--out", tmp_path)
    runs = tmp_path / "runs.csv"

    def lines():
        return runs.read_text().count("\n") if runs.exists() else 0

    process = start(*args, "--runs", 100, "--quiet", "--json")
    wait_until(lambda: lines() > 3, process)
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=10)
    assert process.returncode == 130
    assert stdout == ""
    (line,) = stderr.strip().split("\n")
    assert "go on with: flockscope paper liu2021-table1" in line
    kept = lines() - 1
    assert 3 <= kept < 100
    assert runs.read_text().endswith("\n")
    result = call(*args, "--runs", 3, "--json", "--quiet", "--no-pictures")
    assert json.loads(result.stdout)["runs"]["taken"] >= 1


def test_a_folder_that_cannot_be_written_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    result = call(*SMALL, "--out", tmp_path / "file" / "deep", "--quiet")
    assert result.exit_code == 2
    assert "cannot be written" in result.stderr
    assert result.stderr.count("\n") == 1
