"""An option of a run is declared once: commands, files, `Flock` and Setup have it from there."""

from __future__ import annotations

import subprocess
import sys

NEW = """    gait: Literal["walk", "trot"] = option(
        "Gait", "How they go", "walk", words={"walk": "walking", "trot": "trotting"}
    )
    loud: bool = option("Loud", "Whether they call", False, bool)

    @property
    def chosen("""
"""Two options more, put into the declaration of `Options`."""

CODE = f"""
import importlib.util, sys
from contextlib import nullcontext
from types import SimpleNamespace

found = importlib.util.find_spec("agents.spec")
text = open(found.origin).read()
mark = "    @property\\n    def chosen("
assert text.count(mark) == 1
spec = importlib.util.module_from_spec(found)
sys.modules["agents.spec"] = spec
exec(compile(text.replace(mark, {NEW!r}), found.origin, "exec"), spec.__dict__)

from agents import Flock
from app.cli.main import load
from app.studies.experiment_file import PaperRow, PaperSweep
from app.viewer.lab.panels.setup import SetupPanel
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation_state import SimulationState

OPTIONS, Spec = spec.OPTIONS, spec.Spec
assert {{"gait", "loud", "activation", "agents"}} <= OPTIONS.keys()


class Gui:
    def __init__(self):
        self.made = {{}}

    def __getattr__(self, _kind):
        def add(label, options=(), initial_value=None, **more):
            one = SimpleNamespace(on_update=lambda _: None, options=options, hint=more.get("hint"))
            one.value = options if initial_value is None else initial_value
            self.made[label] = one
            return one
        return add


    def add_folder(self, _label, **_more):
        return nullcontext()


gui = Gui()
panel = SetupPanel(gui, SimulationState(preset_spec("vem", gait="trot")))
for name, option in OPTIONS.items():
    for command in ("run", "lab"):
        [made] = [one for one in load(command).params if one.name == name]
        assert made.opts == ["--" + name.replace("_", "-")] and option.help in made.help, name
    assert name in Spec.model_fields
    assert option.help in gui.made[option.title].hint, name
for name in spec.Options.model_fields:
    assert name in PaperRow.model_fields and name in PaperSweep.model_fields, name

assert (gui.made["Gait"].value, gui.made["Loud"].value) == ("trotting", False)
gui.made["Gait"].value, gui.made["Loud"].value = "walking", True
chosen, _ = panel.chosen_pairing()
assert (chosen.gait, chosen.loud) == ("walk", True)
flock = Flock("vem", agents=3, gait="trot", loud=True)
assert (flock.options.gait, flock.options.loud) == ("trot", True)
again = Spec.from_toml(flock.spec.to_toml())
assert again == flock.spec and again.gait == "trot"
assert PaperRow(model="vem", agents=3, gait="trot").chosen == {{"gait": "trot"}}
try:
    Flock("vem", gait="trott")
except ValueError as error:
    assert "unknown gait 'trott': did you mean 'trot'?" in str(error), error
else:
    raise AssertionError("it was not refused")
print("had from the declaration:", *OPTIONS)
"""


def test_an_option_that_is_declared_is_everywhere():
    made = subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True)
    assert made.returncode == 0, made.stderr
    assert made.stdout.split()[-2:] == ["gait", "loud"]
