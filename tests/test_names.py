"""No model, rule, body or observable is known by name outside of its own file and the catalogue."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from agents.catalogue import BODIES, MODELS
from agents.observables.catalogue import OBSERVABLES

TREE = Path(__file__).parents[1]
NAMES = {
    *MODELS,
    *BODIES,
    *OBSERVABLES,
    *(model.rule.name for model in MODELS.values()),
    *(model.body.name for model in MODELS.values()),
}
ALLOWED = {
    "app/studies": set(OBSERVABLES),  # what is measured of a paper's runs is the paper's choice
    "app/classroom/collect": set(OBSERVABLES),  # and of a class its lessons'
    "app/tracks": set(OBSERVABLES),  # measures of tracks are called as those of flocks
    "app/tracks/measures/leaders.py": {"leadership"},  # who leads whom, a measure of tracks
    "app/live": {"safe", "car"},  # a room that is not armed; a car
    "app/viewer/live": {"safe", "car"},
    "app/viewer/scene": {"safe", "car"},  # what the legend calls one
    "app/cli/live": {"safe"},
    "app/cli/take/recording.py": {"car"},  # a real one
    "app/cli/terminal/outcome_table.py": {"crashes"},  # who crashed, in the JSON of a run
    "app/cli/formation.py": {"thesis"},  # a spacing that a thesis gives
    "app/cli/world.py": {"layers"},  # of a drawing
}
"""Words that mean something else where they stand, or that must stand there."""


def named(text: str) -> Iterator[tuple[int, str]]:
    """The names that stand in a file as text: line and name."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Constant) and node.value in NAMES:
            yield node.lineno, node.value


def allowed(path: str) -> set[str]:
    """The names that may stand in a file."""
    return {
        name
        for place, names in ALLOWED.items()
        if path == place or path.startswith(f"{place}/")
        for name in names
    }


def test_a_name_would_be_found():
    assert list(named('MODEL = "hwvem"\nshown = {"mean-neighbours": 1, "others": 2}')) == [
        (1, "hwvem"),
        (2, "mean-neighbours"),
    ]
    assert allowed("app/live/control/arm.py") == {"safe", "car"}
    assert allowed("app/live.py") == set()


def test_no_name_stands_outside_of_its_own_file_and_the_catalogue():
    paths = [*(TREE / "app").rglob("*.py"), TREE / "docs" / "make.py"]
    found = [
        f"{where}:{line}: {name}"
        for path in paths
        for where in [path.relative_to(TREE).as_posix()]
        for line, name in named(path.read_text(encoding="utf-8"))
        if name not in allowed(where)
    ]
    assert len(paths) > 200
    assert found == []
