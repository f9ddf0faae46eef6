"""The place from which pages say that their commands are run."""

from __future__ import annotations

import webbrowser

import pytest

from pages.blocks import ROOT

CHECKOUT = (
    "README.md", "LICENSE", "pyproject.toml", "uv.lock",
    "agents", "app", "benchmarks", "docs", "experiments", "flockscope", "static", "tests", "worlds",
)  # fmt: skip
"""What lies in that folder."""


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A folder like a fresh checkout, in which examples may write what they like."""
    folder = tmp_path / "flockscope"
    folder.mkdir()
    for name in CHECKOUT:
        (folder / name).symlink_to(ROOT / name)
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture(autouse=True)
def no_window(monkeypatch):
    """Python of pages that shows a flock opens no browser."""
    monkeypatch.setattr(webbrowser, "open", lambda _: True)


@pytest.fixture(autouse=True)
def catalogue(monkeypatch):
    """The models are afterwards those of before: pages bring some of their own."""
    from agents import catalogue

    models = dict(catalogue.MODELS)
    monkeypatch.setattr(catalogue, "FILES", {})
    yield
    catalogue.MODELS.clear()
    catalogue.MODELS.update(models)
