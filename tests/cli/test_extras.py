"""What an extra is for is refused in one line without it; the rest works."""

import importlib.util

import pytest

from cli.calling import call, refusal
from worlds import plug_ins

INSTALL = (
    "needs the package pyarrow, which is not installed: install the extra parquet: "
    '`uv sync --extra parquet` or `pip install ".[parquet]"` in its folder'
)


@pytest.fixture(autouse=True)
def without_parquet(monkeypatch):
    """As if pyarrow were not installed."""
    found = importlib.util.find_spec
    monkeypatch.setattr(
        plug_ins, "find_spec", lambda name: None if name == "pyarrow" else found(name)
    )


@pytest.mark.parametrize(
    ("words", "what"),
    [
        (("run", "vem", "--record", "mission.parquet"), "--record"),
        (("run", "vem", "--record", "mission.csv"), "--record"),
        (("run", "vem", "--save", "state.parquet"), "--save"),
        (("run", "--state", "state.parquet"), "reading 'state.parquet'"),
        (("recover", "mission.parquet.part"), "recovering 'mission.parquet.part'"),
        (("live", "emulate", "--record", "folder"), "--record"),
        (("live", "lab", "--record", "folder"), "--record"),
    ],
)
def test_parquet_is_named(words, what, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert refusal(*words) == f"flockscope: {what} {INSTALL}"
    assert not list(tmp_path.iterdir())


def test_a_run_that_keeps_nothing_needs_none():
    assert call("run", "vem", "--agents", 3, "--ticks", 2).exit_code == 0
