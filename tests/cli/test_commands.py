"""The command line as a whole: help, version, lists, the way into the laboratory."""

import json
import subprocess
import sys
from importlib.metadata import version

import pytest

from agents.catalogue import MODELS
from agents.models.declare import declared
from agents.observables.catalogue import OBSERVABLES
from app.cli import lab as lab_module
from app.cli import main as main_module
from app.viewer.gallery.lessons.lessons import lesson_names
from cli.calling import PROGRAM, call
from worlds.layout import layout_names


def test_version():
    result = call("--version")
    assert result.stdout == f"flockscope {version('flockscope')}\n"


def test_help_names_every_command_with_a_summary():
    result = call("--help")
    assert result.exit_code == 0
    for name, entry in main_module.COMMANDS.items():
        assert name in result.stdout
        assert entry.summary in " ".join(result.stdout.replace("│", " ").split())


def test_without_a_command_the_laboratory_opens(monkeypatch):
    opened = []

    def stand_in(host: str = "here") -> None:
        opened.append(host)

    monkeypatch.setattr(lab_module, "lab", stand_in)
    for args in ([], ["lab", "--host", "there"], ["--host", "elsewhere"]):
        monkeypatch.setattr(sys, "argv", ["flockscope", *args])
        with pytest.raises(SystemExit) as stop:
            main_module.main()
        assert stop.value.code == 0
    assert opened == ["here", "there", "elsewhere"]


def test_help_and_version_import_no_engine():
    code = (
        "import sys; sys.argv = ['flockscope', '--help']\n"
        "from app.cli.main import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "assert not {'numba', 'mesa', 'viser', 'matplotlib', 'pyarrow'} & set(sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True).returncode == 0


def test_a_run_imports_no_pictures_no_viewer():
    code = (
        "import sys; sys.argv = ['flockscope', 'run', 'vem', '--ticks', '1', '--quiet']\n"
        "from app.cli.main import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        "assert not {'viser', 'matplotlib', 'rich.progress', 'pyarrow.parquet'} & set(sys.modules)"
    )
    made = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert made.returncode == 0, made.stderr


def test_list_gives_everything_there_is():
    everything = json.loads(call("list", "--json").stdout)
    assert [row["name"] for row in everything["models"]] == list(MODELS)
    assert [row["name"] for row in everything["worlds"]] == layout_names()
    assert [row["name"] for row in everything["observables"]] == list(OBSERVABLES)
    names = {one.name for model in MODELS.values() for one in declared(model.parameters)}
    assert {row["name"] for row in everything["parameters"]} == names
    assert {row["name"] for row in everything["papers"]} >= {"liu2021-table1", "liu2021-fig5"}
    assert [row["name"] for row in everything["lessons"]] == list(lesson_names())


@pytest.mark.parametrize(
    "kind", ["models", "parameters", "worlds", "observables", "papers", "lessons"]
)
def test_list_of_one_kind(kind):
    rows = json.loads(call("list", kind, "--json").stdout)
    shown = call("list", kind)
    assert shown.exit_code == 0
    for row in rows:
        assert row["name"] in shown.stdout


def test_a_reader_that_stops_early_is_no_error():
    program = " ".join(f"'{part}'" for part in PROGRAM)
    made = subprocess.run(
        f"{program} list parameters --json | head -c 1", shell=True, capture_output=True, text=True
    )
    assert made.stdout == "["
    assert "Traceback" not in made.stderr
