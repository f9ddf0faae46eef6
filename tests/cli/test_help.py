"""`--help` of every command shows what its options say, brackets and all."""

import re

import pytest

from app.cli.main import COMMANDS, load
from cli.calling import call


def commands():
    """Every command with the names that lead to it."""
    for name in COMMANDS:
        command = load(name)
        for part, one in getattr(command, "commands", {"": command}).items():
            yield [name, part] if part else [name], one


def words(text):
    """Text without frames, line ends and escapes."""
    return " ".join(re.sub(r"[│╭╮╰╯─]", " ", text).replace("\\[", "[").split())


@pytest.mark.parametrize(
    ("path", "command"), [pytest.param(*one, id=" ".join(one[0])) for one in commands()]
)
def test_nothing_of_a_help_is_swallowed(path, command, monkeypatch):
    monkeypatch.setattr("typer.rich_utils.MAX_WIDTH", 400)  # read from the environment only once
    shown = words(call(*path, "--help").stdout)
    for option in command.params:
        assert words(getattr(option, "help", None) or "") in shown, option.name
