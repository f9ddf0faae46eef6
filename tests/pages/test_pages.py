"""Every block of README and docs is run as it is printed, or a reason stands in a table."""

from __future__ import annotations

import json
import os
import re
import shlex
import tomllib
import warnings
import zipfile
from contextlib import suppress
from pathlib import Path

import ezdxf
import numpy as np
import pytest
import tomlkit

from agents.flock import Flock
from agents.spec import KEYS, Spec
from app.cli.main import COMMANDS
from app.live.laboratory.lab_file import lab_from_toml
from app.studies.optimisation.study import OptimisationFile
from app.studies.sweeps.sweep_file import SweepFile
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.lab.runs_file import RunsFile
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.kept_runs import KeptRuns
from pages.blocks import BLOCKS, PAGES, ROOT, Block, blocks_of, inline_commands, text_of
from pages.not_run import ELSEWHERE, PRINTED
from pages.plan import (
    NOT_RUN,
    OTHERWISE,
    NotAsPrintedError,
    altered,
    arguments,
    commands,
    otherwise,
)
from pages.running import parse, run, visit
from worlds.layout import world_from_layout
from worlds.readers import read_geometry

GROUPS = ("world", "flight", "formation", "live", "sweep", "new", "tracks")
"""Commands that have commands of their own."""
CHECKOUT = ("README.md", "docs/installing.md")
"""Pages that say how flockscope is called in a checkout."""
ENDINGS = {"python": (".py",), "json": (".json", ".geojson"), "": ()}
"""Endings of the files that blocks are saved as, where they are not the language's name."""


def file_of(block):
    """The file that a page has a block saved as, "" if it is none."""
    endings = ENDINGS.get(block.language, (f".{block.language}",))
    return block.file if block.file.endswith(endings) and endings else ""


def file_from(page, name):
    """The block that a page has saved under a name."""
    (code,) = [block.code for block in blocks_of(page) if file_of(block) == name]
    return code


def draw_plan(path):
    """A drawing as somebody has one: a floor, a wall and a pillar, each on its layer, in metres."""
    drawing = ezdxf.new(units=6)
    space = drawing.modelspace()
    for layer, low, high in (("FLOOR", (0, 0), (20, 12)), ("WALLS", (8, 0), (8.5, 7))):
        corners = [low, (high[0], low[1]), high, (low[0], high[1])]
        space.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
    space.add_circle((14, 6), 0.5, dxfattribs={"layer": "PILLARS"})
    drawing.saveas(path)


def draw_bottleneck(path):
    """A drawing with the layers that JuPedSim asks for."""
    drawing = ezdxf.new(units=6)
    for layer, low, high in (
        ("jps-walkablearea", (0, 0), (20, 12)),
        ("jps-exits", (18, 5), (19, 7)),
        ("jps-distributions", (1, 1), (6, 11)),
    ):
        corners = [low, (high[0], low[1]), high, (low[0], high[1])]
        drawing.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
    path.parent.mkdir(parents=True, exist_ok=True)
    drawing.saveas(path)


def draw_box(path):
    """A floor with a hole, in one geometry without a name, as JuPedSim's examples are."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("POLYGON ((0 0, 24 0, 24 9, 0 9, 0 0), (4 4, 4 6, 7 6, 7 4, 4 4))\n")


def draw_campus(path):
    """A building as a map on the web exports it, in degrees and without a word about it."""
    ring = [[8.65, 49.87], [8.651, 49.87], [8.651, 49.871], [8.65, 49.871], [8.65, 49.87]]
    path.write_text(json.dumps({"type": "Polygon", "coordinates": [ring]}))


def draw_room(path):
    """A room in centimetres, on layers of Inkscape."""
    layer = 'xmlns:i="http://www.inkscape.org/namespaces/inkscape" i:groupmode="layer" i:label='
    path.write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 800 500">'
        f'<g {layer}"walkable"><rect width="800" height="500"/></g>'
        f'<g {layer}"pillars"><circle cx="400" cy="250" r="30"/></g></svg>'
    )


def draw_ros_map(path):
    """A map of ROS, its image beside it, or both in a ZIP file."""
    text = "image: walls.pgm\nresolution: 0.5\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n"
    image = b"P5\n8 6\n255\n" + b"".join(b"\xfe" * 4 + b"\0" + b"\xfe" * 3 for _ in range(6))
    if path.suffix == ".zip":
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr("walls.yaml", text)
            archive.writestr("walls.pgm", image)
    else:
        path.write_text(text)
        path.with_name("walls.pgm").write_bytes(image)


def draw_arena(path):
    """A map of the MovingAI benchmarks."""
    path.write_text("type octile\nheight 3\nwidth 5\nmap\n.....\n..@T.\n.....\n")


def draw_station(path):
    """A scenario of Vadere."""
    shape = {"type": "RECTANGLE", "x": 4.0, "y": 4.0, "width": 1.0, "height": 2.0}
    attributes = {"bounds": {"x": 0.0, "y": 0.0, "width": 12.0, "height": 9.0},
                  "boundingBoxWidth": 0.5, "bounded": True}  # fmt: skip
    topography = {"attributes": attributes, "obstacles": [{"id": 1, "shape": shape}]}
    path.write_text(json.dumps({"name": "station", "scenario": {"topography": topography}}))


def keep_a_run(path):
    """The file in which a laboratory keeps its runs."""
    readings = FlockReadings(Flock("vem", agents=8, seed=1))
    for _ in range(2):
        readings.flock.advance(5)
        readings.read(at_once=True)
    path.parent.mkdir(exist_ok=True)
    rows = KeptRuns(storage=RunsFile(path))
    rows.follow([readings])
    rows.close()


def keep_fish(path):
    """The fish of trajectorytools where FLOCKSCOPE_REAL_TRACKS has them, else made ones."""
    folder = os.environ.get("FLOCKSCOPE_REAL_TRACKS", "")
    found = sorted(Path(folder).rglob("test_trajectories_idtrackerai.npy")) if folder else []
    if found:
        path.write_bytes(found[0].read_bytes())
        return
    flock = Flock("couzin", agents=8, dim=2, world="open", rng=1)
    places = 100.0 * flock.trace(500)
    held = {"trajectories": places, "frames_per_second": 28, "body_length": 58.0}
    np.save(path, np.array(held, object), allow_pickle=True)


def learn_nothing(path):
    """A policy as docs/learn_to_evade.py writes it, that goes straight on."""
    script = {}
    exec((ROOT / "docs" / "learn_to_evade.py").read_text("utf-8"), script)
    script["write_policy"](np.zeros(31), path)


READERS_OWN = {
    ("docs/steer.md", "evade.py"): learn_nothing,
    ("docs/tracks.md", "fish.npy"): keep_fish,
    ("docs/laboratory-plots.md", "results/runs.jsonl"): keep_a_run,
    ("docs/first-examples.md", "lab.toml"): lambda path: path.write_text(
        file_from("docs/live.md", "lab.toml")
    ),
    ("docs/worlds-from-drawings.md", "plan.dxf"): draw_plan,
    ("docs/worlds-from-drawings.md", "office.wkt"): draw_box,
    ("docs/worlds-from-drawings.md", "campus.geojson"): draw_campus,
    ("docs/worlds-drawing-formats.md", "room.svg"): draw_room,
    ("docs/worlds-drawing-formats.md", "floor.yaml"): draw_ros_map,
    ("docs/worlds-drawing-formats.md", "floor.zip"): draw_ros_map,
    ("docs/worlds-drawing-formats.md", "arena.map"): draw_arena,
    ("docs/worlds-drawing-formats.md", "station.scenario"): draw_station,
    ("docs/worlds-drawing-formats.md", "jupedsim/examples/geometry/BUW.wkt"): draw_box,
    (
        "docs/worlds-drawing-formats.md",
        "jupedsim/examples/geometry/dxf/ISO-Bottleneck.dxf",
    ): draw_bottleneck,
}
"""Page, file -> makes what the page takes for the reader's own, or from elsewhere."""


def entry(table, block):
    """The key of the one entry of a table of blocks that is meant by a block, or None."""
    found = [
        key for key in table
        if key[0] == block.page and (key[1] in block.code if table is ELSEWHERE
                                     else block.code.startswith(key[1]))
    ]  # fmt: skip
    assert len(found) <= 1, f"{block}: {found}"
    return found[0] if found else None


def commands_of(page):
    """Every command of a page, but for lines that the page's own test does not take."""
    for block in blocks_of(page):
        if block.is_shell and entry(PRINTED, block) is None:
            for line in block.lines:
                with suppress(NotAsPrintedError):
                    yield from commands(line)


FILES = re.compile(
    r"--record|(?<!\blab)\.(toml|parquet|geojson|wkt|dxf|svg|yaml|zip|map|scenario)\b"
)
"""What names files in a command, but for `lab.toml`, which is the same on all pages."""


def printed_before(page, command):
    """Whether an earlier page prints the same command, one that names no files."""
    if FILES.search(command):
        return False
    return any(command in commands_of(one) for one in PAGES[: PAGES.index(page)])


def carry_out(block, line, monkeypatch):
    """Run what a line of a page says; what it printed on stdout."""
    printed = []
    for command in commands(line):
        if command in NOT_RUN:
            continue
        words = arguments(command)
        instead = otherwise(words)
        if (instead and instead.more is None) or printed_before(block.page, command):
            parse(words)
            continue
        words = altered(words, instead.more) if instead else words
        opens = words[0] in ("lab", "class") or words[:2] == ["live", "lab"]
        result = (visit if opens else run)(words, monkeypatch)
        assert result.exit_code == 0, f"{block}: {command}\n{result.stdout}{result.stderr}"
        printed.append(result.stdout)
    return "".join(printed)


def check_python(block, names, capsys):
    """Run Python; what a comment behind a print says is what it prints."""
    capsys.readouterr()
    exec(compile(block.code, str(block), "exec"), names)
    printed = capsys.readouterr().out.splitlines()
    said = [
        line.partition("  # ")[2] for line in block.code.splitlines()
        if re.match(r"\s*print\(", line)
    ]  # fmt: skip
    assert len(printed) == len(said), str(block)
    if any(said):
        assert printed == said, str(block)


def check_toml(block):
    """Load TOML as what it is: a laboratory, a part of it, a world, a sweep, a search, an entry, a
    scene with steps, a run."""
    made = tomllib.loads(block.code)
    if "project" in made:
        ((group, named),) = made["project"]["entry-points"].items()
        sources = [*(ROOT / "agents").rglob("*.py"), *(ROOT / "app").rglob("*.py")]
        assert any(f'"{group}"' in one.read_text(encoding="utf-8") for one in sources), group
        assert all(re.fullmatch(r"[\w.]+:\w+", value) for value in named.values())
    elif {"edges", "size", "obstacle"} & set(made):
        world_from_layout(made, "page")
    elif "steps" in made:
        assert SavedScene.from_toml(block.code, "page").steps
    elif "search" in made:
        OptimisationFile(**({"run": {"model": "vem", "ticks": 1}} | made))
    elif "replicates" in made:
        SweepFile(**({"run": {"model": "vem", "ticks": 1}} | made))
    elif "model" in made and set(made) <= set(KEYS):
        Flock(Spec.from_toml(block.code, "page"))
    else:
        whole = tomlkit.parse(file_from("docs/live.md", "lab.toml")) | made
        lab_from_toml(block.code if "cars" in made else tomlkit.dumps(whole), str(block))


def check_data(block):
    """Read the file that a page has a block saved as, by the reader of its kind."""
    file = Path(file_of(block))
    assert file.name, f"{block}: the page does not say what it is saved as"
    if block.language == "csv" and block.page.startswith("docs/tracks"):
        return  # the commands behind it read it, each with its options
    if block.language == "csv":
        from app.live.sources.recorded_source import RecordedSource

        assert list(RecordedSource(file).recording())
    else:
        read_geometry(file)


@pytest.mark.parametrize("page", [page for page in PAGES if blocks_of(page)])
def test_what_a_page_prints_works(page, checkout, monkeypatch, capsys):
    for block in blocks_of(page):
        if file_of(block):
            (checkout / file_of(block)).write_text(block.code, encoding="utf-8")
    for (at, name), make in READERS_OWN.items():
        if at == page:
            make(checkout / name)
    with warnings.catch_warnings():  # a page may set its own
        run_blocks(page, monkeypatch, capsys)


def run_blocks(page, monkeypatch, capsys):
    """Run the blocks of a page in their order, its Python as one session."""
    names, printed = {"__name__": "__main__"}, ""
    for block in blocks_of(page):
        if entry(ELSEWHERE, block):
            continue
        key = entry(PRINTED, block)
        if key:
            assert PRINTED[key] or block.code.strip() in printed, f"{block}: {printed}"
        elif block.is_shell:
            printed += "".join(carry_out(block, line, monkeypatch) for line in block.lines)
        elif block.language == "python":
            check_python(block, names, capsys)
        elif block.language == "toml":
            check_toml(block)
        elif block.language in ("json", "wkt", "csv"):
            check_data(block)
        else:
            pytest.fail(f"{block}: {block.language!r} is neither run nor named in not_run.py")


def test_every_reason_applies_to_something():
    found = [command for page in PAGES for command in commands_of(page)]
    assert set(NOT_RUN) <= set(found)
    called = [shlex.split(command)[1:] or ["lab"] for command in found]
    assert {one for one in map(otherwise, called) if one} == set(OTHERWISE)
    for table in (ELSEWHERE, PRINTED):
        assert {key for block in BLOCKS if (key := entry(table, block))} == set(table)
    for page, name in READERS_OWN:
        assert name in text_of(page)


def test_the_tests_that_reasons_name_are_there():
    reasons = [one.why for one in OTHERWISE]
    reasons += [*NOT_RUN.values(), *ELSEWHERE.values(), *PRINTED.values()]
    named = {name for why in reasons for name in re.findall(r"tests/[\w./]*\w", why)}
    assert len(named) >= 5
    assert [name for name in sorted(named) if not (ROOT / name).exists()] == []


@pytest.mark.parametrize("page", [page for page in PAGES if page not in CHECKOUT])
def test_a_page_prints_the_commands_of_an_installed_flockscope(page):
    assert not re.search(r"uv\s+run\s+flockscope", text_of(page)), "print `flockscope ...`"


@pytest.mark.parametrize("page", PAGES)
def test_a_command_in_a_sentence_is_a_name_or_can_be_called(page):
    for command in inline_commands(page):
        words = arguments(command)
        assert words[0] in (*COMMANDS, "--version"), command
        rest = words[2:] if words[0] in GROUPS else words[1:]
        if not all(word.startswith("--") for word in rest):  # else it is mentioned, not printed
            parse(words)


@pytest.mark.parametrize(
    "line",
    [
        "uv run flockscope lab",
        "flockscope paper liu2021-table1 [--runs 100]",
        "flockscope paper wu2023-fig5   # also wu2023-fig7",
        "flockscope run MODEL > out.txt",
        "make everything",
    ],
)
def test_what_a_shell_does_not_take_is_found(line):
    with pytest.raises(NotAsPrintedError):
        list(map(arguments, commands(line)))


def test_blocks_are_found_however_they_are_printed():
    text = "Text\n\n    a\n\n    b\n\nSaved as `x.toml`:\n\n```toml\nc = 1\n```\n\n~~~ sh\nd\n~~~\n"
    found = blocks_of("page", text)
    assert [(one.line, one.language, one.code, one.file) for one in found] == [
        (3, "", "a\n\nb\n", "x.toml"),
        (10, "toml", "c = 1\n", "x.toml"),
        (14, "sh", "d\n", ""),
    ]
    assert [file_of(one) for one in found] == ["", "x.toml", ""]


def test_enough_is_found_to_be_worth_it():
    languages = {block.language for block in BLOCKS}
    assert languages >= {"", "sh", "python", "toml", "json", "wkt", "csv", "c"}
    assert sum(len(list(commands_of(page))) for page in PAGES) > 120
    assert isinstance(json.loads(file_from("docs/worlds-from-drawings.md", "hall.geojson")), dict)
    assert all(isinstance(block, Block) for block in BLOCKS)


def test_what_is_run_otherwise_has_each_option_once():
    words = ["lab", "vem", "--port", "9000", "--no-open", "--set", "eta=0.5"]
    made = altered(words, "--port 0 --open")
    assert made == ["lab", "vem", "--set", "eta=0.5", "--port", "0", "--open"]
