"""The notebooks say at their end what is so, and are kept without outputs."""

from __future__ import annotations

from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "docs" / "tutorials"
NOTEBOOKS = sorted(path.stem for path in FOLDER.glob("*.ipynb"))


def test_there_are_six():
    assert len(NOTEBOOKS) == 6


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_the_last_cell_of_a_notebook_asserts_what_its_text_says(name):
    """tests/test_site.py runs them: a cell that raises fails there."""
    import nbformat  # takes two seconds, which collecting need not take

    last = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4).cells[-1].source
    assert last.startswith(("assert", "for", "means"))
    assert "assert" in last


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_is_kept_without_its_outputs(name):
    import nbformat

    made = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    assert all(not cell.outputs for cell in made.cells if cell.cell_type == "code")
    assert made.cells[0].source.startswith("# ")
