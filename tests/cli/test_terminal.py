"""No text of a file reaches a terminal, or a pipe, as a command to a terminal."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pyarrow.parquet as pq
import pytest

import app.cli
from agents.flock import Flock
from agents.recordings.recorder import Recorder
from app.studies.runs.database import Outcome
from app.studies.runs.store import Store
from cli.calling import start
from worlds.input_error import CONTROLS

HOSTILE = "a\x1b[2J\x1b]0;owned\x07\x9b31m\u202egnp\x7f\u2028\u200f\ud800z"
SHOWN = r"a\x1b[2J\x1b]0;owned\x07\x9b31m\u202egnp\x7f\u2028\u200f\ud800z"
RAW = re.compile(f"[{CONTROLS}]")
PRINTS = f"""
import json, logging, sys, warnings
import typer
from app.cli import main
from app.cli.terminal.console import rewrite_line
text = {HOSTILE!r}

def everything(*_, **__):
    typer.echo(text)
    typer.echo(text, err=True)
    print(text)
    print(text, file=sys.stderr)
    sys.stderr.writelines([text])
    logging.warning(text)
    warnings.warn(text)
    rewrite_line(text)
    from rich.table import Table
    from app.cli.terminal.console import make_console
    table = Table(title=text)
    table.add_column(text, no_wrap=True)
    table.add_row(text)
    make_console(width=400).print(table)
    make_console(width=400, stderr=True).print(table)

main.app = everything
main.main()
"""


def run_program(*command):
    """What a program of its own prints into pipes."""
    from subprocess import run

    done = run(command, capture_output=True, timeout=120, check=False)
    return done.stdout.decode(), done.stderr.decode()


def test_pipes_carry_no_control_characters():
    out, err = run_program(sys.executable, "-c", PRINTS)
    assert "Traceback" not in err
    assert not RAW.search(out + err.replace("\r", ""))  # ours, of the line that is rewritten
    assert SHOWN in out  # of print; typer leaves colours and the like out of pipes
    assert err.count(SHOWN) >= 3


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals here")
def test_a_terminal_is_sent_no_more_than_colours():
    import os
    import pty
    from subprocess import Popen

    ours, theirs = pty.openpty()
    program = Popen([sys.executable, "-c", PRINTS], stdin=theirs, stdout=theirs, stderr=theirs)
    os.close(theirs)
    sent = b""
    while True:
        try:
            piece = os.read(ours, 65536)
        except OSError:  # Linux says so at the end
            break
        if not piece:
            break
        sent += piece
    os.close(ours)
    assert program.wait(60) == 0
    text = re.sub("\x1b\\[[0-9;]*m|\r", "", sent.decode())
    assert SHOWN in text
    assert not RAW.search(text)


def test_no_command_makes_a_console_of_its_own():
    makers = [
        path.name
        for path in Path(app.cli.__file__).parent.rglob("*.py")
        if re.search(r"import Console\b|rich\.print|rich import print", path.read_text("utf-8"))
    ]
    assert makers == ["console.py"]


def test_a_spec_with_a_hostile_name_is_refused_without_commands(tmp_path):
    path = tmp_path / "world.toml"
    path.write_text(f"title = {json.dumps(HOSTILE)}\n{json.dumps(HOSTILE)} = 1\n")
    program = start("world", "check", path)
    out, err = program.communicate(timeout=120)
    assert not RAW.search(out + err)
    assert program.returncode == 2


def store_of_a_stranger(folder):
    """A sweep with a hostile folder, axis, value, column and reason, and one with such a title."""
    axis, column = NAME + "axis", NAME + "column"
    with Store(folder / "results" / NAME, [column]) as store:
        [cell] = store.store_plan([("a", json.dumps({"axes": {axis: NAME}}))])
        store.tell(kind="sweep", axes=[axis], columns=[column], runs=2)
        store.add(cell, 1, Outcome("ok", {column: 0.5}))
        store.add(cell, 2, Outcome("failed", {}, NAME))
    with Store(folder / "results" / "titled", ["k"]) as store:
        store.tell(kind="sweep", title=NAME, runs=1)


def files_of_a_stranger(folder):
    """Files of every kind that is read, with hostile text where text may stand."""
    store_of_a_stranger(folder)
    said = json.dumps(NAME)
    (folder / "spec.toml").write_text(f"model = {said}\nworld = {said}\n[parameters]\n{said} = 1\n")
    (folder / "scene.toml").write_text(f"title = {said}\n[run]\nmodel = 'vem'\n")
    (folder / "paper.toml").write_text(f"title = {said}\nkind = {said}\n")
    properties = {"layer": NAME, "name": NAME}
    square = [[0, 0], [4, 0], [4, 4], [0, 4], [0, 0]]
    feature = {"type": "Feature", "properties": properties}
    feature["geometry"] = {"type": "Polygon", "coordinates": [square]}
    plan = {"type": "FeatureCollection", "features": [feature]}
    (folder / "plan.geojson").write_text(json.dumps(plan))
    shown = NAME.encode("utf-8", "replace").decode()
    (folder / "plan.csv").write_text(f"{shown},x\n1,{shown}\n", encoding="utf-8")
    flock = Flock("vem", agents=3, rng=1)
    with Recorder(folder / "run.parquet", flock) as recording:
        recording.write()
    table = pq.read_table(folder / "run.parquet")
    words = {key: NAME.encode("utf-8", "replace") for key in table.schema.metadata}
    pq.write_table(table.replace_schema_metadata(words), folder / "run.parquet")


NAME = HOSTILE.replace("\ud800", "") + "\n"
READS = (
    ("sweep", "list"), ("sweep", "status", f"results/{NAME}"), ("sweep", "show", f"results/{NAME}"),
    ("sweep", "export", f"results/{NAME}", "runs.csv"), ("sweep", "status", "results/titled"),
    ("sweep", "plot", f"results/{NAME}"), ("run", "spec.toml"), ("run", "scene.toml"),
    ("lab", "spec.toml"), ("sweep", "run", "spec.toml"), ("paper", "paper.toml"),
    ("optimise", "spec.toml"), ("world", "import", "plan.geojson"), ("run", "run.parquet"),
    ("world", "import", "plan.geojson", "--unit", "m"), ("picture", "run.parquet"),
    ("live", "check", "run.parquet"), ("class", "paper.toml"),
)  # fmt: skip


def test_no_command_prints_the_commands_of_a_strangers_file(tmp_path):
    files_of_a_stranger(tmp_path)
    for command in READS:
        made = start(*command, cwd=tmp_path)
        out, err = made.communicate(timeout=120)
        assert made.returncode in (0, 2, 3), (command, err)
        assert "Traceback" not in err, command
        assert not RAW.search(out + err.replace("\r", "")), command
        if made.returncode == 2:
            assert (out, err.count("\n")) == ("", 1), command


def test_a_cell_is_cut_after_it_was_escaped():
    """Rich measures what is shown: a line of the table is no wider than the table."""
    program = """
from rich.table import Table
from app.cli.terminal.console import guard_streams, make_console
guard_streams()
table = Table("name", "value")
table.add_row(chr(27) * 30, "1")
make_console(width=40).print(table)
"""
    out, err = run_program(sys.executable, "-c", program)
    assert err == ""
    assert max(map(len, out.splitlines())) <= 40
    assert r"\x1b" in out


@pytest.mark.parametrize(
    "title", ["a\nflockscope: all is well", "a\x1b[2Jb", "a\u2028b", "a\u202eb"]
)
def test_a_title_of_a_file_is_one_line(tmp_path, title):
    quoted = json.dumps(title)
    (tmp_path / "sweep.toml").write_text(f"title = {quoted}\n[run]\nmodel = 'vem'\nticks = 1\n")
    (tmp_path / "world.toml").write_text(f"title = {quoted}\nsize = [4.0, 4.0]\n")
    for command in (("sweep", "check", "sweep.toml"), ("world", "check", "world.toml")):
        made = start(*command, cwd=tmp_path)
        out, err = made.communicate(timeout=120)
        assert (made.returncode, out) == (2, "")
        assert err.count("\n") == 1
        assert not RAW.search(err)
        assert "one line of" in err
