"""The import graph: no module stands on itself, not even by an import inside of a function."""

from __future__ import annotations

import grimp
import networkx as nx
import pytest

PACKAGES = ("app", "agents", "worlds")


def circles(graph: grimp.ImportGraph) -> list[list[str]]:
    """Sets of modules that reach each other."""
    arrows = [
        (one, other)
        for one in graph.modules
        for other in graph.find_modules_directly_imported_by(one)
    ]
    strong = nx.strongly_connected_components(nx.DiGraph(arrows))
    return sorted(sorted(circle) for circle in strong if len(circle) > 1)


@pytest.fixture(scope="module")
def graph() -> grimp.ImportGraph:
    """All imports, those inside of functions and those for type checkers too."""
    return grimp.build_graph(*PACKAGES, cache_dir=None)


def test_there_is_no_circle(graph):
    assert circles(graph) == []


def test_a_circle_would_be_found():
    graph = grimp.ImportGraph()
    for module in "abcd":
        graph.add_module(module)
    for importer, imported in (("a", "b"), ("b", "c"), ("c", "b"), ("c", "d")):
        graph.add_import(importer=importer, imported=imported)
    assert circles(graph) == [["b", "c"]]


def test_imports_inside_of_functions_are_in_the_graph(graph):
    assert graph.direct_import_exists(importer="app.cli.listing", imported="app.cli.choices")
    assert graph.direct_import_exists(importer="app.cli.choices", imported="agents.catalogue")
