"""Every command that the page, a message or a help text prints is typed, as a user would."""

from __future__ import annotations

import ast
import re
import shlex
from pathlib import Path

import pytest
import tomlkit
from pages.running import parse, visit

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.recordings.recorder import Recorder
from app.cli.main import COMMANDS
from app.studies.experiment_reader import experiment_names
from app.viewer.gallery.saved_scene import SavedScene, command_line
from app.viewer.gallery.scene_collection import find_scene, scene_names
from app.viewer.run.flock_run import FlockRun
from app.viewer.run.frame_builder import FrameRequest
from app.viewer.run.run_preset import preset_spec
from tests.cli.calling import call

ROOT = Path(__file__).parents[2]
COMMAND = re.compile(rf"flockscope ({'|'.join(COMMANDS)})\b[^`'<>\n;()#]*")
PAPER = re.compile(r"flockscope paper ([\w.-]+)")
RUN = {
    "flockscope list": "list",
    "flockscope list models": "list models",
    "flockscope list papers": "list papers",
    "flockscope list lessons": "list lessons",
    "flockscope list hwvem": "list hwvem",
    "flockscope list NAME, as in": "list wrap",
    "flockscope list KIND, as in": "list worlds",
    "flockscope list MODEL shows those of a model": "list couzin",
    "flockscope run {thing[]}": "run vem --ticks 1",
    "flockscope export --lesson {thing[]}": "export --lesson who-leads --out {folder}/page.html",
    "flockscope run FILE.toml": "run {spec} --ticks 2",
    "flockscope run FILE.parquet": "run {state} --ticks 2",
    "flockscope run FILE": "run {scene} --ticks 2",
    "flockscope run MODEL --observe {thing[]}{over}": "run vem --observe groups --ticks 1",
    "flockscope world show {thing[]}": "world show wrap --out {folder}/wrap.png",
    "flockscope world import {command}": "world import {drawing} --out {folder}/yard.toml",
    "flockscope recover {self.part}": "recover {part}",
    "flockscope sweep run FILE.toml": "sweep run {sweep_file} --out {sweep} --workers 1",
    "flockscope sweep run FILE.toml --rule FILE.py": (
        "sweep run {sweep_file} --rule {policy} --out {folder}/flown --workers 1"
    ),
    "flockscope sweep run {shlex.quote(str(folder))}": "sweep run {sweep} --workers 1",
    "flockscope sweep run {folder.name}": "sweep run {sweep} --workers 1",
    "flockscope sweep list": "sweep list --in {folder}",
    "flockscope sweep show {folder} names them": "sweep show {sweep}",
    "flockscope sweep show {reader.folder}": "sweep show {sweep}",
    "flockscope sweep export": "sweep export {sweep} {folder}/runs.csv",
    "flockscope sweep plot {folder.name}": "sweep plot {sweep}",
    "flockscope tracks formats": "tracks formats",
}
"""Printed command -> what is typed; it ends with exit code 0. Sweeps: in this order."""
VISITED = {
    "flockscope lab": "lab",
    "flockscope lab FILE": "lab {state}",
    "flockscope lab {thing[]}": "lab vem",
    "flockscope lab scene.toml": "lab {scene}",
}
"""The same of those that serve a page: it is there."""
PARSED = {
    "flockscope export --scene {card.name}": "export --scene mill",
    "flockscope export {chosen[0]} {scene or lesson}": "export --lesson who-leads",
    "flockscope export {shlex.quote(path.name)}": "export {scene}",
    "flockscope export{shown} --paper {name}": "export vem --paper liu2021-table1",
    "flockscope sweep stop {folder}": "sweep stop weights",
    "flockscope sweep stop {going}": "sweep stop weights",
    "flockscope sensitivity {folder}": "sensitivity weights",
    "flockscope sensitivity {reader.folder}": "sensitivity weights",
    "flockscope optimise {folder}": "optimise weights",
    "flockscope export spec.toml": "export spec.toml",
    "flockscope paper {thing[]}": "paper liu2021-table1",
    "flockscope lab --tracks FILE": "lab --tracks herd.csv",
    "flockscope class {thing[]}": "class order-against-noise",
    "flockscope class {keeping.path}": "class monday.class",
    "flockscope class FILE opens it again": "class monday.class",
    "flockscope live recover {self.recording}": "live recover monday",
}
"""The same of those that need a sweep that runs, a class, cars or hours: they are read only, and
tried in the tests of their own."""
NAMES = {
    "flockscope sweep run": "sweep run",
    "flockscope sweep show": "sweep show",
    "flockscope class": "class",
    "flockscope paper": "paper",
    "flockscope run": "run",
    "flockscope film": "film",
    "flockscope tracks": "tracks",
    "flockscope tracks convert": "tracks convert",
    "flockscope picture": "picture",
    "flockscope live": "live",
    "flockscope live lab": "live lab",
    "flockscope world import": "world import",
}
"""Named in a sentence, without what it takes: there is such a command."""


def docstrings(tree: ast.AST) -> set[int]:
    """The constants that nobody is shown: of modules, classes, functions and values."""
    found = set()
    for node in ast.walk(tree):
        body = getattr(node, "body", [])
        for statement in body if isinstance(body, list) else []:
            if isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant):
                found.add(id(statement.value))
    return found


def helped(tree: ast.AST) -> set[int]:
    """The docstrings of functions of the command line, which are its help."""
    return {
        id(node.body[0].value)
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and isinstance(node.body[0], ast.Expr)
    }


def texts(path: Path) -> list[str]:
    """What of a file people may be shown; what is put into it stands in braces."""
    source = path.read_text("utf-8")
    if path.suffix != ".py":
        return [source]
    tree = ast.parse(source)
    hidden = docstrings(tree)
    if "cli" in path.parts:
        hidden -= helped(tree)
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            hidden |= {id(part) for part in node.values}
            found.append("".join(map(part_of, node.values)))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found += [node.value] * (id(node) not in hidden)
    return found


def part_of(part: ast.expr) -> str:
    """A part of a formatted text."""
    if isinstance(part, ast.Constant):
        return str(part.value)
    assert isinstance(part, ast.FormattedValue)
    return re.sub(r"\['\w+'\]", "[]", "{" + ast.unparse(part.value) + "}")


def printed() -> dict[str, str]:
    """All commands that are printed, and where one of them stands."""
    found = {}
    for folder in ("app", "agents", "worlds", "flockscope", "static"):
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix not in (".py", ".js", ".html"):
                continue
            for text in texts(path):
                for match in whole(text):
                    found.setdefault(match, str(path.relative_to(ROOT)))
    return found


def whole(text: str) -> list[str]:
    """The commands in a text, with parentheses that belong to what is put in."""
    kept = re.sub(r"\{[^{}]*\}", lambda found: found[0].replace("(", "⟨").replace(")", "⟩"), text)
    matches = [one[0].replace("⟨", "(").replace("⟩", ")") for one in COMMAND.finditer(kept)]
    return [one.strip(' ".,:\\') for one in matches]


@pytest.fixture(scope="module")
def commands_printed() -> dict[str, str]:
    return printed()


def test_every_printed_command_is_typed_here(commands_printed):
    known = {**RUN, **VISITED, **PARSED, **NAMES}
    unknown = {
        command: place
        for command, place in commands_printed.items()
        if command not in known and not PAPER.fullmatch(command)
    }
    assert unknown == {}, "type it in this file"
    assert [one for one in known if one not in commands_printed] == [], "printed nowhere"
    assert len(commands_printed) > 40


def test_papers_that_models_name_are_there(commands_printed):
    names = {paper[1] for command in commands_printed if (paper := PAPER.fullmatch(command))}
    assert len(names) > 10
    assert names <= set(experiment_names())


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The files that are typed: as the page gives them, with what was changed on the way."""
    folder = tmp_path_factory.mktemp("printed")
    spec = preset_spec("vem", agents=12, seed=1)
    run = FlockRun(Flock(spec), 1, FrameRequest())
    run.advance(3)
    run.change(lambda run: run.set("eta", 1.0))
    run.advance(3)
    made = {name: folder / name for name in ("spec.toml", "scene.toml", "state.parquet")}
    made["spec.toml"].write_bytes(run.spec())
    made["state.parquet"].write_bytes(run.save())
    made["scene.toml"].write_text(SavedScene("mine", spec).to_toml())
    sweep = {"run": {"model": "vem", "ticks": 3, "agents": 5}, "replicates": {"count": 1}}
    sweep |= {"design": [{"kind": "grid", "axes": {"eta": [0.0, 1.0]}}]}
    sweep |= {"observe": [{"name": "polarisation"}]}
    (folder / "weights.toml").write_text(tomlkit.dumps(sweep))
    policy = "from flockscope import policy\n\n@policy\ndef straight(seen):\n    return seen"
    (folder / "straight.py").write_text(policy)
    (folder / "yard.wkt").write_text("POLYGON((0 0, 9 0, 9 9, 0 9, 0 0))")
    recorder = Recorder(folder / "cut.parquet", run.flock)
    recorder.__enter__()
    recorder.write()
    recorder.flush()
    return {
        **{path.stem: path for path in made.values()},
        "folder": folder,
        "sweep_file": folder / "weights.toml",
        "sweep": folder / "weights",
        "policy": folder / "straight.py",
        "drawing": folder / "yard.wkt",
        "part": folder / "cut.parquet.part",
    }


def test_the_spec_from_the_page_says_what_was_changed(files):
    assert files["spec"].read_text().startswith("# Changed while it ran: eta 0 → 1 at tick 3.")


def words(typed: str, files: dict[str, Path]) -> list[str]:
    return [word.format(**files) for word in shlex.split(typed)]


@pytest.mark.parametrize("typed", dict.fromkeys(RUN.values()))
def test_it_runs_as_it_is_printed(typed, files, monkeypatch):
    monkeypatch.chdir(files["folder"])
    result = call(*words(typed, files))
    assert result.exit_code == 0, result.stderr


@pytest.mark.parametrize("typed", dict.fromkeys(VISITED.values()))
def test_its_page_is_served(typed, files, monkeypatch):
    result = visit([*words(typed, files), "--port", "0"], monkeypatch)
    assert result.exit_code == 0, result.stderr


@pytest.mark.parametrize("typed", [*PARSED.values(), *NAMES.values()])
def test_there_is_such_a_command(typed):
    first, *rest = typed.split()
    if typed in PARSED.values():
        parse([first, *rest])
    else:
        shown = call(first, *rest, "--help")
        assert shown.exit_code == 0
        assert shown.stdout


@pytest.mark.parametrize("name", [*scene_names(), *(f"model:{name}" for name in MODELS)])
def test_what_the_gallery_prints_for_a_scene_is_understood(name):
    line = command_line(find_scene(name)).split("#")[0]
    program, *typed = shlex.split(line)
    assert program == "flockscope"
    parse(typed)
