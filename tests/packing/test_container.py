"""The Dockerfile fits the project. Nothing here builds it: there need be no engine for it."""

from __future__ import annotations

import json
import re
import shlex
import subprocess
import sys
import tomllib

import pytest
from pages.blocks import ROOT

from agents.engine import cache
from app.cli.main import load
from app.front.server import close_server, open_server

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
HEALTH_PORT = "8080"


def instructions() -> list[tuple[str, str]]:
    """What the Dockerfile says, word and rest, lines joined."""
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    text = re.sub(r"^#.*\n", "", text, flags=re.MULTILINE)
    lines = re.sub(r"[ \t]*\\\n[ \t]*", " ", text).splitlines()
    return [
        (word, rest) for line in lines if line.strip() for word, _, rest in [line.partition(" ")]
    ]


def said(word: str) -> list[str]:
    """What stands behind every such word."""
    return [rest for one, rest in instructions() if one == word]


def copied() -> list[str]:
    """What comes from the checkout."""
    own = [shlex.split(rest) for rest in said("COPY") if not rest.startswith("--from")]
    return [name for names in own for name in names[:-1]]


def test_its_python_is_the_projects():
    images = {rest.split()[0] for rest in said("FROM")}
    version = (ROOT / ".python-version").read_text().strip()
    assert images == {f"python:{version}-slim"}
    least, below = re.findall(r"3\.(\d+)", PROJECT["project"]["requires-python"])
    assert int(least) <= int(version.partition(".")[2]) < int(below)


def test_it_copies_what_a_wheel_is_made_of():
    one_name = (ROOT / "packing" / "one_name.py").read_text(encoding="utf-8")
    parts = re.findall(r"^(?:PARTS|DATA) = \((.*)\)$", one_name, re.MULTILINE)
    names = {name for part in parts for name in re.findall(r'"(\w+)"', part)}
    needed = {"pyproject.toml", "uv.lock", "packing", "flockscope", PROJECT["project"]["readme"]}
    assert set(copied()) == names | needed | set(PROJECT["project"]["license-files"])
    assert [name for name in copied() if not (ROOT / name).exists()] == []


def test_what_it_copies_and_nothing_else_is_given_to_the_engine():
    lines = (ROOT / ".dockerignore").read_text(encoding="utf-8").splitlines()
    rules = [line for line in lines if line and not line.startswith("#")]
    assert rules[0] == "*"
    kept = [rule.removeprefix("!") for rule in rules if rule.startswith("!")]
    assert sorted(kept) == sorted(copied())
    assert {rule for rule in rules[1:] if not rule.startswith("!")} == {
        "**/__pycache__",
        "**/*.pyc",
    }


def test_uv_knows_its_options_and_the_project_its_extras():
    (command,) = (shlex.split(rest) for rest in said("RUN") if rest.startswith("uv sync"))
    known = subprocess.run(
        ["uv", "sync", "--help"], capture_output=True, text=True, check=True
    ).stdout
    options = [word for word in command if word.startswith("--")]
    assert [one for one in options if not re.search(rf"{one}\b", known)] == []
    extras = [command[at + 1] for at, word in enumerate(command) if word == "--extra"]
    assert set(extras) <= set(PROJECT["project"]["optional-dependencies"])
    assert "--locked" in options


def test_it_begins_a_class_that_the_network_reaches():
    (entry,) = map(json.loads, said("ENTRYPOINT"))
    assert entry[0] in PROJECT["project"]["scripts"]
    context = load(entry[1]).make_context(entry[1], [*entry[2:], "order", "--allow-host", "lab7"])
    assert (context.params["host"], context.params["open_browser"]) == ("0.0.0.0", False)
    assert said("EXPOSE") == [str(context.params["port"])] == [HEALTH_PORT]
    assert f"127.0.0.1', {HEALTH_PORT}," in said("HEALTHCHECK")[0]


def test_it_runs_as_nobody_in_particular_and_keeps_one_folder():
    words = [word for word, _ in instructions()]
    last = len(words) - words[::-1].index("FROM")
    ended = [rest for word, rest in instructions()[last:] if word in ("USER", "WORKDIR", "VOLUME")]
    user, work, volume = ended
    assert user not in ("root", "0")
    assert work == volume
    made = next(rest for rest in said("RUN") if rest.startswith("useradd"))
    assert made.endswith(f"--owner {user} {volume}")
    assert "RUN" not in words[words.index("USER") :]
    variables = dict(word.partition("=")[::2] for rest in said("ENV") for word in rest.split())
    source = (ROOT / "agents" / "engine" / "cache.py").read_text(encoding="utf-8")
    assert '"FLOCKSCOPE_CACHE"' in source
    assert cache.__name__.endswith("engine.cache")
    assert variables["FLOCKSCOPE_CACHE"].startswith(f"{volume}/")
    assert variables["PATH"].startswith(f"{variables['UV_PROJECT_ENVIRONMENT']}/bin:")


def test_it_names_no_registry_and_no_machine():
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    assert "://" not in text
    assert not [image for image in said("FROM") if "/" in image.split()[0]]
    assert not re.findall(r"--(?:index|default-index|index-url|extra-index-url)\b", text)


@pytest.mark.parametrize("there", [True, False])
def test_its_health_is_whether_it_is_answered(there):
    command = json.loads(said("HEALTHCHECK")[0].partition("CMD ")[2])
    server = open_server(port=0)
    port = server.get_port()
    if not there:
        close_server(server)
    code = command[2].replace(HEALTH_PORT, str(port))
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, check=False)
    if there:
        close_server(server)
    assert (ran.returncode == 0) == there, ran.stderr
