"""`flockscope optimise`: a table, words and a picture; killed at any moment it goes on with it."""

import importlib.util
import json
import signal

import pytest

from app.studies.runs.store_reader import StoreReader, readable
from cli.calling import call, refusal, start, wait_until
from worlds import plug_ins

FILE = """
title = "Calm"
[run]
model = "vem"
agents = 12
size = 2.0
ticks = 60
[search]
algorithm = "ga"
evaluations = 48
population = 8
[search.axes]
eta = { from = 0, to = 6 }
r = { from = 0.2, to = 0.4 }
[replicates]
count = 4
fresh = 20
[[objective]]
observable = "polarisation"
aim = "most"
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "calm.toml"
    path.write_text(FILE)
    return path


def done(folder):
    return sum(StoreReader(folder).counts.values()) if readable(folder) else 0


def told(result):
    """What does not depend on where it was run, and how often it was stopped."""
    assert result.exit_code == 0, result.stderr
    value = json.loads(result.stdout)
    return {key: value[key] for key in value.keys() - {"folder", "files", "made", "taken"}}


@pytest.mark.exhaustive
def test_killed_and_gone_on_with_it_is_the_same_answer(tmp_path, file):
    whole = told(call("optimise", file, "--out", tmp_path / "a", "--json", "--quiet"))
    out = tmp_path / "b"
    for kind in (signal.SIGKILL, signal.SIGTERM):
        before = done(out)
        process = start("optimise", file, "--out", out, "--workers", 1, "--quiet")
        wait_until(lambda before=before: done(out) >= before + 20, process)
        process.send_signal(kind)
        _, stderr = process.communicate(timeout=60)
        assert process.returncode == (-9 if kind == signal.SIGKILL else 130), stderr
    assert "go on with: flockscope optimise" in stderr
    rest = call("optimise", out, "--json", "--quiet")
    assert told(rest) == whole
    assert json.loads(rest.stdout)["taken"] >= 40
    assert whole["best"][0]["point"]["eta"] < 1.5, "the least noise, as far as few runs tell"
    assert whole["words"][0].startswith("most polarisation: ")
    assert "convergence.png" in {path.name for path in out.iterdir()}
    status = json.loads(call("sweep", "status", out, "--json").stdout)
    assert (status["state"], status["title"]) == ("done", "Calm")


def test_people_get_a_table_words_and_a_picture_where_they_want_it(tmp_path, file):
    file.write_text(FILE.replace("48", "8"))
    picture, out = tmp_path / "c.svg", tmp_path / "a"
    part = call("optimise", file, "--out", out, "--limit", 9, "--quiet")
    assert (part.exit_code, part.stdout) == (0, "")
    assert "go on with: flockscope optimise" in part.stderr
    result = call("optimise", file, "--out", out, "--picture", picture)
    assert result.exit_code == 0, result.stderr
    assert "the default" in result.stdout
    assert "the best" in result.stdout
    assert "8 evaluations of 8 different points" in result.stdout
    assert b"<svg" in picture.read_bytes()
    assert "exists" in refusal("optimise", file, "--out", out, "--picture", picture)


def test_failed_runs_give_code_3(tmp_path, file):
    (tmp_path / "mine.py").write_text("def m(flock):\n    return 1 / (flock.seed - 1)\n")
    mine = '[[observe]]\nmeasure = "mine.py:m"\n[[objective]]\nobservable = "m"'
    file.write_text(
        FILE.replace('[[objective]]\nobservable = "polarisation"', mine).replace("48", "8")
    )
    result = call("optimise", file, "--out", tmp_path / "a", "--quiet")
    assert result.exit_code == 3
    assert "there is no best" in result.stdout
    assert "ZeroDivisionError" in result.stderr


@pytest.mark.parametrize(("algorithm", "package"), [("ga", "pymoo"), ("cma", "cma")])
def test_a_package_that_is_missing_is_named(tmp_path, file, monkeypatch, algorithm, package):
    found = importlib.util.find_spec
    monkeypatch.setattr(
        plug_ins, "find_spec", lambda name: None if name == package else found(name)
    )
    file.write_text(FILE.replace('"ga"', f'"{algorithm}"'))
    line = refusal("optimise", file, "--out", tmp_path / "a", "--quiet")
    assert f"needs the package {package}, which is not installed: install the extra exp" in line
    assert not (tmp_path / "a").exists()


def test_what_is_no_optimisation_is_refused(tmp_path):
    line = refusal("optimise", "vem")
    assert "'vem' is no FILE.toml and no folder of an optimisation" in line
    assert "search: it is missing" in refusal(
        "optimise", written(tmp_path, FILE.replace("[search]", "[serch]"))
    )


def written(folder, text):
    path = folder / "other.toml"
    path.write_text(text.replace("[search.axes]", "[serch.axes]"))
    return path
