"""`flockscope sensitivity`: a table, words and bars from the runs of a sweep, gone on with."""

import json

import pytest

from cli.calling import call, refusal

FILE = """
[run]
model = "vem"
agents = 12
size = 2.0
ticks = 40
[[design]]
kind = "morris"
trajectories = 3
[design.axes]
eta = { from = 0, to = 6 }
r = [0.2, 0.3]
[replicates]
count = 2
[[observe]]
name = "polarisation"
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(FILE)
    return path


@pytest.mark.exhaustive
def test_stopped_on_the_way_it_goes_on_to_the_same_answer(tmp_path, file):
    whole = call("sensitivity", file, "--out", tmp_path / "a", "--json", "--quiet")
    assert whole.exit_code == 0, whole.stderr
    value = json.loads(whole.stdout)
    (found,) = value["sensitivity"]
    assert (found["observable"], found["kind"]) == ("polarisation", "morris")
    assert found["influences"][0]["axis"] == "eta"
    assert found["words"][0].startswith("polarisation depends most on eta (mu* ")
    assert {"sensitivity.png", "sensitivity.svg"} <= {p.name for p in (tmp_path / "a").iterdir()}
    part = call("sensitivity", file, "--out", tmp_path / "b", "--limit", 5, "--quiet")
    assert part.exit_code == 0
    assert part.stdout == ""
    assert "go on with: flockscope sensitivity" in part.stderr
    rest = call("sensitivity", tmp_path / "b", "--json", "--quiet")
    assert json.loads(rest.stdout)["sensitivity"] == value["sensitivity"]
    assert json.loads(rest.stdout)["taken"] == 5


def test_people_get_a_table_words_and_a_picture_where_they_want_it(tmp_path, file):
    out, picture = tmp_path / "a", tmp_path / "bars.pdf"
    result = call("sensitivity", file, "--out", out, "--picture", picture)
    assert result.exit_code == 0, result.stderr
    assert "mu*" in result.stdout
    assert "polarisation depends most on eta" in result.stdout
    assert picture.read_bytes().startswith(b"%PDF")
    assert "exists" in refusal("sensitivity", file, "--out", out, "--picture", picture, "--quiet")


def test_failed_runs_have_no_indices(tmp_path, file):
    (tmp_path / "mine.py").write_text("def m(flock):\n    return 1 / (flock.seed - 1)\n")
    file.write_text(FILE.replace('name = "polarisation"', 'measure = "mine.py:m"'))
    result = call("sensitivity", file, "--out", tmp_path / "a", "--quiet")
    assert result.exit_code == 3
    assert result.stdout == ""
    assert "6 runs failed: flockscope sweep show" in result.stderr
    assert not (tmp_path / "a" / "sensitivity.png").exists()


def test_what_cannot_be_analysed_is_refused_before_anything_runs(tmp_path, file):
    file.write_text(FILE.replace("morris", "grid").replace("trajectories = 3", ""))
    line = "design grid is not allowed: one of kind saltelli, for Sobol's indices, or morris"
    out = tmp_path / "a"
    file.write_text(
        FILE.replace('"morris"\ntrajectories = 3', '"grid"').replace("{ from = 0, to = 6 }", "[0]")
    )
    assert line in refusal("sensitivity", file, "--out", out)
    file.write_text(FILE)
    assert "unknown observable 'x'" in refusal("sensitivity", file, "--observable", "x")
    assert "'vem' is no FILE.toml and no folder of a sweep" in refusal("sensitivity", "vem")
    assert not out.exists()
