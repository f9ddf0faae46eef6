"""The face promises exactly what it lists, says what each is, and costs nothing to import."""

from __future__ import annotations

import inspect
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import flockscope

ROOT = Path(__file__).parents[2]
MODULES = ("flockscope", *(f"flockscope.{name}" for name in flockscope._MODULES))
PAGES = [
    ROOT / "README.md", *(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "rules").glob("*.md")
]  # fmt: skip


def public(module):
    """The names of a module that are no modules and do not begin with an underscore."""
    there = {name for name, value in vars(module).items() if not inspect.ismodule(value)}
    return {name for name in there if not name.startswith("_")}


@pytest.mark.parametrize("name", MODULES)
def test_all_that_is_listed_is_there(name):
    module = import_module(name)
    assert sorted(set(module.__all__)) == sorted(module.__all__)
    for promised in module.__all__:
        assert getattr(module, promised) is not None, promised


@pytest.mark.parametrize("name", MODULES[1:])
def test_nothing_is_there_that_is_not_listed(name):
    module = import_module(name)
    own = {"TYPE_CHECKING", "Any", "annotations"}
    assert public(module) - own <= set(module.__all__)


def test_each_name_at_the_top_is_told_to_type_checkers():
    text = (ROOT / "flockscope" / "__init__.py").read_text(encoding="utf-8")
    told = re.findall(r"^    from flockscope\.\w+ import (\w+) as \1$", text, re.MULTILINE)
    assert sorted(told) == sorted(flockscope.__all__)
    assert set(dir(flockscope)) == {*flockscope.__all__, *flockscope._MODULES, "__version__"}


@pytest.mark.parametrize("name", MODULES)
def test_everything_says_what_it_is(name):
    module = import_module(name)
    assert module.__doc__
    for promised in module.__all__:
        thing = getattr(module, promised)
        if inspect.isclass(thing) or inspect.isroutine(thing):
            assert (thing.__doc__ or "").strip(), promised


def test_a_name_that_is_not_promised_is_refused():
    with pytest.raises(ImportError, match="cannot import name 'Bird' from 'flockscope'"):
        from flockscope import Bird  # noqa: F401
    with pytest.raises(AttributeError, match=r"'flockscope\.live' has no attribute 'Bird'"):
        _ = flockscope.live.Bird


@pytest.mark.parametrize(
    ("module", "old", "new"),
    [
        ("flockscope.rules", "Wish", "Decision"),
        ("flockscope.rules", "Refusal", "InputError"),
        ("flockscope.live", "Place", "LinkAddress"),
        ("flockscope.observables", "LeftOut", "OmittedRowsWarning"),
        ("flockscope.worlds", "Refusal", "InputError"),
        ("flockscope", "Refusal", "InputError"),
    ],
)
def test_an_old_name_still_works_and_tells_the_new_one(module, old, new):
    with pytest.warns(FutureWarning, match=rf"\.{old} is called {new} now"):
        assert getattr(import_module(module), old) is getattr(import_module(module), new)


def run(code, **more):
    """Run Python in a process of its own."""
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, **more
    )


def test_importing_it_imports_nothing_heavy():
    heavy = "{'viser', 'matplotlib', 'numba', 'mesa', 'numpy', 'pydantic', 'typing'}"
    ran = run(f"import sys, flockscope; print({heavy} & set(sys.modules))")
    assert ran.stdout == "set()\n", ran.stderr


def test_worlds_need_no_flock_and_flocks_no_window():
    ran = run(
        "import sys; from flockscope import World, Flock; "
        "print({'viser', 'matplotlib.pyplot', 'app'} & set(sys.modules))"
    )
    assert ran.stdout == "set()\n", ran.stderr
    ran = run(
        "import sys; from flockscope import MODELS, Spec; "
        "print({'mesa', 'pandas', 'networkx'} & set(sys.modules))"
    )
    assert ran.stdout == "set()\n", ran.stderr
    ran = run(
        "import sys; from flockscope import World, world; world('wrap', size=3.0); "
        "print({'mesa', 'numba', 'scipy', 'matplotlib'} & set(sys.modules))"
    )
    assert ran.stdout == "set()\n", ran.stderr


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_pages_import_the_face_only(page):
    text = page.read_text(encoding="utf-8")
    assert not re.findall(r"^\s*(?:from|import) (?:app|agents|worlds)\b.*", text, re.MULTILINE)
    for module, names in re.findall(
        r"^from (flockscope[\w.]*) import (\([^)]*\)|.*)$", text, re.MULTILINE
    ):
        promised = set(import_module(module).__all__)
        assert set(re.findall(r"\w+", names)) <= promised, module


def test_the_module_is_the_command(tmp_path):
    ran = subprocess.run(
        [sys.executable, "-m", "flockscope", "--version"],
        capture_output=True, text=True, check=False, cwd=tmp_path,
    )  # fmt: skip
    assert ran.returncode == 0
    assert ran.stdout.startswith("flockscope ")
