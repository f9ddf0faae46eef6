"""The import graph: no module stands on itself, not even by an import inside of a function."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import grimp
import networkx as nx
import pytest

import agents
import worlds

ROOT = Path(__file__).parents[1]
PACKAGES = ("app", "agents", "worlds")
LAZY = {
    ("agents/strips/strip_engine.py", "distributed"),  # an extra, for flocks in ranks
    ("agents/strips/strip_engine.py", "agents"),  # the file beside it that imports the same
    ("agents/recordings/parquet_table.py", "pyarrow"),  # as for those who record
    ("agents/recordings/snapshot_reader.py", "pyarrow"),
    ("agents/recordings/part_stream.py", "pyarrow"),
    # 0.2 s and 40 MB, for those who record or load a flock
    ("agents/recordings/recorder.py", "pyarrow"),
    ("agents/flock.py", "pandas"),  # 0.3 s, for tables alone
    ("agents/conditions.py", "scipy"),  # 0.2 s, for runs with gusts
    ("agents/observables/groups.py", "scipy"),  # 0.1 s, for who counts groups
    ("agents/observables/neighbours.py", "scipy"),  # the same, for layers
    ("agents/observables/anisotropy.py", "scipy"),  # hulls, for the structure of flocks alone
    ("agents/observables/order.py", "scipy"),  # 0.5 s, for ranks of speeds alone
    ("agents/observables/leadership.py", "scipy"),  # a quantile, for leaders alone
    ("agents/observables/formation.py", "scipy"),  # 0.2 s, for the best spacing alone
    ("agents/state/start.py", "scipy"),  # 0.2 s, for starts with a spacing alone
    ("worlds/generators/forest.py", "scipy"),  # 0.6 s, for forests alone
    ("worlds/readers/join.py", "scipy"),  # 0.3 s, for drawings whose lines are joined
    ("worlds/readers/degrees.py", "pyproj"),  # an extra, for plans in degrees
    ("worlds/readers/formats/svg.py", "svgelements"),  # 0.1 s, for those who read an SVG file
    ("worlds/readers/formats/dxf.py", "ezdxf"),  # an extra, for those who read a drawing
}
"""Libraries that a file of agents or worlds imports within a function, because they are slow."""


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


def lazy_imports(tree: ast.AST) -> Iterator[str]:
    """The packages that are imported inside of functions."""
    for function in ast.walk(tree):
        if isinstance(function, ast.FunctionDef):
            for node in ast.walk(function):
                if isinstance(node, ast.Import):
                    yield from (one.name.partition(".")[0] for one in node.names)
                if isinstance(node, ast.ImportFrom):
                    yield (node.module or "").partition(".")[0]


LOADED = """
import sys
from flockscope import Flock
Flock("vem", agents=30, rng=1).run(1)
found = [name for name, module in sys.modules.items() if type(module).__name__ == "module"]
print(*{name.partition(".")[0] for name in found}, *{"scipy.linalg", "scipy.spatial"} & {*found})
"""
NOT_LOADED = (
    *("pandas", "networkx", "pyarrow", "matplotlib", "sklearn", "dask", "IPython", "tqdm", "PIL"),
    *("viser", "aiohttp", "websockets", "typer", "rich", "ezdxf", "svgelements", "segno"),
    *("scipy.linalg", "scipy.spatial"),
)
"""Libraries, each of 20 to 500 ms, that no flock needs before something of them is asked for."""


def test_a_first_flock_loads_no_library_that_it_does_not_need():
    command = [sys.executable, "-c", LOADED]
    done = subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT)
    loaded = set(done.stdout.split())
    assert {"mesa", "numba", "numpy"} <= loaded
    assert loaded.isdisjoint(NOT_LOADED)


DEFERRED = """
import pickle, sys
from agents.mesa_import import mesa

def is_put_off(module):
    return type(module).__name__ == "DeferredModule"

assert is_put_off(sys.modules["pandas"]) and is_put_off(sys.modules["scipy.spatial"])
import pandas as pd
import pandas.api.types
import networkx as nx
assert mesa.agent.pd.DataFrame is pd.DataFrame is pickle.loads(pickle.dumps(pd.DataFrame))
assert pandas.api.types.is_number(1.0)
graph = nx.path_graph(3)
laid_out = mesa.discrete_space.network.nx.spring_layout(graph, seed=1)
assert sorted(laid_out) == sorted(nx.spring_layout(graph, seed=1)) == [0, 1, 2]
assert not hasattr(pd, "no_such_name")
apart = mesa.experimental.continuous_space.continuous_space.cdist([[0.0, 0.0]], [[3.0, 4.0]])
assert apart.tolist() == [[5.0]]
assert not [name for name, one in sys.modules.items() if name[:5] == "scipy" and is_put_off(one)]
assert mesa.discrete_space.grid.KDTree([[0.0, 0.0]]).query([3.0, 4.0])[0] == 5.0
print(type(sys.modules["pandas"]).__name__)
"""
CHILD_FIRST = """
import sys
from agents.mesa_import import mesa
import scipy.spatial.transform as child
import scipy.spatial
import scipy.spatial.distance
assert scipy.spatial.transform is child is sys.modules["scipy.spatial.transform"]
assert child.__spec__.origin and type(scipy.spatial.distance).__name__ == "module"
from tqdm.auto import tqdm
assert list(tqdm(range(3), disable=True)) == [0, 1, 2]
"""


def test_what_mesa_puts_off_is_there_when_it_is_asked_for():
    command = [sys.executable, "-c", DEFERRED]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert (done.stdout, done.stderr) == ("module\n", "")


def test_a_module_of_a_package_that_is_put_off_is_imported_once():
    command = [sys.executable, "-c", CHILD_FIRST]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert (done.returncode, done.stderr) == (0, "")


def test_only_slow_libraries_are_imported_inside_of_functions():
    found = set()
    for package in (agents, worlds):
        top = Path(package.__path__[0])
        for path in top.rglob("*.py"):
            for name in lazy_imports(ast.parse(path.read_text(encoding="utf-8"))):
                found.add((path.relative_to(top.parent).as_posix(), name))
    assert found == LAZY


VISERS_OWN = re.compile(
    r"\b(from viser import _|from viser\._|from viser\.infra|import viser\.(_|infra))"
    r"|\._(impl|websock_\w+|gui_input\w*|handle_(gui|file)\w*|connected_clients|event_loop"
    r"|viser_server|incoming_handlers|current_file\w+|resolve_client|prop_hints)\b"
)
"""Private names of viser."""


def test_one_file_alone_knows_private_names_of_viser():
    top = Path(__file__).parent.parent
    found = {
        path.relative_to(top).as_posix()
        for path in (top / "app").rglob("*.py")
        if VISERS_OWN.search(path.read_text(encoding="utf-8"))
    }
    assert found == {"app/front/viser_internals.py"}
