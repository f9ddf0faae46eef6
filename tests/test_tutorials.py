"""The notebooks run from the first cell to the last, and what they say at their end is so."""

from __future__ import annotations

from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "docs" / "tutorials"
NOTEBOOKS = sorted(path.stem for path in FOLDER.glob("*.ipynb"))


def test_there_are_four():
    assert len(NOTEBOOKS) == 4


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_runs(name, tmp_path):
    """Its last cell asserts what its text says; a cell that raises fails the test."""
    import nbformat  # takes two seconds, which collecting need not take
    from nbclient import NotebookClient

    made = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    assert made.cells[-1].source.startswith(("assert", "for", "means"))
    assert "assert" in made.cells[-1].source
    resources = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(made, timeout=300, resources=resources).execute()
    pictures = [
        output
        for cell in made.cells
        for output in cell.get("outputs", ())
        if "image/png" in output.get("data", {})
    ]
    assert pictures, "each shows a picture"


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_is_kept_without_its_outputs(name):
    import nbformat

    made = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    assert all(not cell.outputs for cell in made.cells if cell.cell_type == "code")
    assert made.cells[0].source.startswith("# ")
