"""The WebAssembly of pages is kept on disk by what it does, and never stale."""

from __future__ import annotations

import numpy as np
import pytest

import agents.web.web_modules
from agents.flock import Flock
from agents.web.web_modules import AT_HAND, FOLDER, PageFunction, module_of
from agents.web.web_program import web_program
from worlds.compilation import entry


def twice(values):
    """Double the first value."""
    values[0] = 2.0 * values[0]
    return values[0]


def thrice(values):
    """Triple the first value."""
    values[0] = 3.0 * values[0]
    return values[0]


@pytest.fixture
def compiled_modules(tmp_path, monkeypatch):
    """Notes each module that is compiled; nothing is kept at first."""
    made = []
    make = agents.web.web_modules.web_module

    def web_module(code, own):
        made.append(tuple(code))
        return make(code, own)

    monkeypatch.setenv("FLOCKSCOPE_CACHE", str(tmp_path))
    monkeypatch.setattr(agents.web.web_modules, "web_module", web_module)
    AT_HAND.clear()
    yield made
    AT_HAND.clear()


def function(python=twice, kind=float, **names):
    """What a page may call, by its name."""
    return {names.get("name", "go"): PageFunction(entry(python), (np.ones(2, kind),))}


def test_another_process_need_not_compile_it(compiled_modules):
    first = module_of(function())
    assert module_of(function()) == first
    AT_HAND.clear()  # as in another process
    assert module_of(function()) == first
    assert compiled_modules == [("go",)]


@pytest.mark.parametrize(
    "other", [function(thrice), function(kind=np.float32), function(name="come")]
)
def test_what_does_something_else_is_compiled(compiled_modules, other):
    first = module_of(function())
    assert module_of(other) != first
    assert len(compiled_modules) == 2


def test_what_is_damaged_is_compiled_anew_and_told(compiled_modules, tmp_path, capsys):
    first = module_of(function())
    (file,) = (tmp_path / FOLDER).iterdir()
    file.write_bytes(file.read_bytes()[:-1] + b"?")
    AT_HAND.clear()
    agents.engine.cache.WARNED_OF.clear()
    assert module_of(function()) == first
    assert "are damaged: they are compiled anew" in capsys.readouterr().err
    assert len(compiled_modules) == 2


def test_what_others_may_write_to_is_not_read(compiled_modules, tmp_path):
    module_of(function())
    (file,) = (tmp_path / FOLDER).iterdir()
    file.chmod(0o666)
    AT_HAND.clear()
    module_of(function())
    assert len(compiled_modules) == 2


@pytest.mark.long  # compiles two modules anew, each time
def test_flocks_that_differ_by_seed_number_and_values_share_a_module(compiled_modules):
    one = web_program(Flock("vem", agents=5, rng=1))
    AT_HAND.clear()
    other = web_program(Flock("vem", agents=9, rng=2, eta=1.0))
    assert one.module == other.module
    assert len(compiled_modules) == 1
    nearest = web_program(Flock("vem", agents=9, rng=2, neighbours="nearest"))
    assert nearest.module != one.module
