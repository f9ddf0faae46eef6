"""`flockscope new rule`: a start that runs, or a refusal in one line and nothing written."""

from __future__ import annotations

import pytest

from agents.catalogue import FILES, MODELS, from_file
from agents.flock import Flock
from tests.cli.calling import call


@pytest.mark.parametrize("more", [(), ("--from", "couzin"), ("--from", "hwvem-nav")])
def test_what_is_written_runs(tmp_path, more):
    file = tmp_path / "my_own.py"
    result = call("new", "rule", file, *more)
    assert (result.exit_code, result.stdout) == (0, "")
    assert result.stderr == f"written: {file}\n"
    try:
        model = from_file(str(file))
        flock = Flock(model.name, agents=9, rng=1, interpret=True)
        flock.run(2)
    finally:
        FILES.pop("my-own", None)
    assert flock.model.rule.name == "my-own"
    if more:
        assert flock.model.body is MODELS[more[1]].body
        assert flock.spec.world == MODELS[more[1]].world
    else:
        assert 35 <= len(file.read_text().splitlines()) <= 50


@pytest.mark.parametrize(
    ("name", "more", "words"),
    [
        ("there.py", (), "is there already"),
        ("mine.txt", (), "it must end in .py"),
        ("vem.py", (), "there is a model 'vem' already"),
        ("a b.py", (), "letters, digits, - and _"),
        ("mine.py", ("--from", "cousin"), "did you mean 'couzin'"),
    ],
)
def test_what_cannot_be_is_refused_and_nothing_is_written(tmp_path, name, more, words):
    (tmp_path / "there.py").write_text("mine")
    result = call("new", "rule", tmp_path / name, *more)
    assert result.exit_code == 2
    assert words in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["there.py"]
    assert (tmp_path / "there.py").read_text() == "mine"
