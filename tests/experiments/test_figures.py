"""A figure is one file: what it measures and how it is drawn are found by their names."""

from __future__ import annotations

import pytest

from app.studies import figures
from app.studies.experiment import experiment_names, read_experiment

NEW = """
from typing import ClassVar

from app.studies.figures.energy import EnergySettings


class HummingSettings(EnergySettings):
    kind: ClassVar[str] = "humming"


def draw_hum(figure, seed):
    figure.text(0.5, 0.5, f"seed {seed}")


PICTURES = {"hum": draw_hum}
"""


@pytest.fixture
def found_anew():
    def forget():
        for found in (figures.figure_files, figures.kinds, figures.pictures):
            found.cache_clear()

    yield forget
    forget()


def test_papers_use_every_kind_and_every_picture():
    papers = [read_experiment(name) for name in experiment_names()]
    assert {paper.settings.kind for paper in papers} == set(figures.kinds())
    assert {paper.picture for paper in papers} == set(figures.pictures())


def test_no_two_figures_have_a_kind_or_a_picture_of_the_same_name():
    names = [name for file in figures.figure_files() for name in getattr(file, "PICTURES", ())]
    assert len(names) == len(set(names))
    for kind, settings in figures.kinds().items():
        assert settings.kind == kind
        assert settings.measures


def test_a_file_in_the_folder_is_all_that_a_new_figure_needs(tmp_path, monkeypatch, found_anew):
    (tmp_path / "humming.py").write_text(NEW, encoding="utf-8")
    monkeypatch.setattr(figures, "__path__", [*figures.__path__, str(tmp_path)])
    found_anew()
    assert figures.kinds()["humming"].measures == figures.kinds()["energy"].measures
    paper = read_experiment("wu2023-theorem1")
    drawn = figures.draw(paper.__class__(**{**vars(paper), "picture": "hum"}), [], tmp_path, 7)
    assert "seed 7" in drawn["svg"].read_text(encoding="utf-8")
