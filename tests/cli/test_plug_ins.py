"""Plug-ins: one that cannot be used is named, left out and warned of in one line."""

import subprocess
import sys

import pytest

from cli.calling import PROGRAM

RULE = """
import dataclasses
from flockscope.rules import VEM
"""
MODULES = {
    "broken": ("import nothing_of_that_name", "NAME", "cannot be loaded (ModuleNotFoundError"),
    "raising": ("raise SystemExit(3)", "NAME", "cannot be loaded (SystemExit: 3)"),
    "no_rule": ("NAME = 3", "NAME", "a Rule or a Model is needed, not int"),
    "thief": (RULE + "NAME = dataclasses.replace(VEM, title='Mine')", "NAME",
              "has the name 'vem', which is built in"),
    "worldly": ("from flockscope import InputError, World\n" + RULE +
                "NAME = dataclasses.replace(VEM, name='worldly', title='Another')", "NAME", ""),
    "right": (RULE + "NAME = dataclasses.replace(VEM, name='mine', title='My rule')", "NAME", ""),
}  # fmt: skip
LINK = """
from flockscope.live import CarLink, InputError, levels, open_wire

def open_link(place):
    raise InputError(f"the radio of {place.where} is off")
"""


@pytest.fixture
def environment(tmp_path, monkeypatch):
    """A package with one entry point for each module."""
    entries = "".join(f"{name} = {name}_rule:{what}\n" for name, (_, what, _) in MODULES.items())
    info = tmp_path / "plugged-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: plugged\nVersion: 1.0\n")
    links = "[flockscope.links]\ntext = text_radio:open_link\n"
    (info / "entry_points.txt").write_text(f"[flockscope.rules]\n{entries}{links}")
    (tmp_path / "text_radio.py").write_text(LINK)
    for name, (code, _, _) in MODULES.items():
        (tmp_path / f"{name}_rule.py").write_text(code)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))


@pytest.mark.usefixtures("environment")
def test_a_plug_in_that_cannot_be_used_is_left_out_with_a_line():
    made = subprocess.run(
        [*PROGRAM, "list", "models", "--json"], capture_output=True, text=True, check=False
    )
    assert made.returncode == 0, made.stderr
    lines = made.stderr.rstrip("\n").split("\n")
    wrong = {name: words for name, (_, _, words) in MODULES.items() if words}
    assert len(lines) == len(wrong)
    for name, words in wrong.items():
        (line,) = [one for one in lines if f"plug-in '{name}' ({name}_rule:NAME" in one]
        assert line.startswith("flockscope: ")
        assert words in line
        assert line.endswith("it is left out")
    assert '"My rule"' in made.stdout
    assert '"Mine"' not in made.stdout
    assert '"Vicsek model"' in made.stdout


@pytest.mark.usefixtures("environment")
@pytest.mark.parametrize(
    "first", ["import flockscope.live", "import flockscope._flocks", "from flockscope import World"]
)
def test_the_face_may_be_imported_while_plug_ins_are_collected(first):
    code = (
        f"{first}\n"
        "import warnings\n"
        "warnings.simplefilter('ignore')\n"
        "from flockscope.live import InputError, open_link\n"
        "from flockscope import MODELS\n"
        "print([name in MODELS for name in ('mine', 'worldly')])\n"
        "try:\n    open_link('text:there')\n"
        "except InputError as refusal:\n    print(refusal)\n"
    )
    made = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )  # fmt: skip
    assert made.stdout == "[True, True]\nthe radio of there is off\n", made.stderr


EVERYTHING = """
import dataclasses
from flockscope.observables import Observable, Range
from flockscope.rules import POINT_MASS

HEAVY = dataclasses.replace(POINT_MASS, name="heavy", title="Heavy")
MANY = Range(0.0, limit="N")
HEADS = Observable("head-count", "Agents", "agents", MANY, lambda flock: len(flock.position))
YARD = {"title": "Yard", "edges": "solid", "size": 9.0}
NOT_A_YARD = 3
def opened(address): raise ValueError(address.kind)
"""
GROUPS = {
    "bodies": "heavy = everything:HEAVY\nwrong_body = everything:YARD",
    "observables": "head-count = everything:HEADS\nwrong_observable = everything:YARD",
    "layouts": "yard = everything:YARD\nwrong_layout = everything:NOT_A_YARD",
    "sources": "mine = everything:opened\nwrong_source = everything:YARD",
}
SCRIPT = """
from flockscope import Flock
from flockscope.live import open_source
flock = Flock("olfati-saber-heavy", agents=3, world="yard", rng=1, interpret=True)
flock.run(1)
try:
    open_source("mine:x")
except ValueError as kind:
    print(flock.model.title, flock.world.size, flock.observe("head-count"), kind)
"""


def test_bodies_observables_layouts_and_sources_come_in_the_same_way(tmp_path, monkeypatch):
    info = tmp_path / "plugged-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: plugged\nVersion: 1.0\n")
    entries = "\n".join(f"[flockscope.{group}]\n{lines}\n" for group, lines in GROUPS.items())
    (info / "entry_points.txt").write_text(entries)
    (tmp_path / "everything.py").write_text(EVERYTHING)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    made = subprocess.run(
        [sys.executable, "-c", SCRIPT], capture_output=True, text=True, check=False
    )
    assert made.returncode == 0, made.stderr
    assert made.stdout.split("\n")[0].endswith("(9.0, 9.0) 3 mine")
    for wrong in ("body", "observable", "layout", "source"):
        assert f"the plug-in 'wrong_{wrong}'" in made.stderr
