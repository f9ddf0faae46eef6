"""`--help` of every command shows what its options say, brackets and all."""

import re

import pytest

from app.cli.main import COMMANDS, load
from cli.calling import call


def words(text):
    """Text without frames, line ends and escapes."""
    return " ".join(re.sub(r"[│╭╮╰╯─]", " ", text).replace("\\[", "[").split())


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_help_of_which_nothing_is_swallowed(name, monkeypatch):
    monkeypatch.setattr("typer.rich_utils.MAX_WIDTH", 400)  # read from the environment only once
    command = load(name)
    parts = getattr(command, "commands", {})
    for part, one in {"": command, **parts}.items():
        path = [name, part] if part else [name]
        result = call(*path, "--help")
        assert result.exit_code == 0
        shown = words(result.stdout)
        assert f"Usage: flockscope {' '.join(path)}" in shown
        for option in one.params:
            assert words(getattr(option, "help", None) or "") in shown, (part, option.name)
        if not part:
            assert [missing for missing in parts if f" {missing} " not in shown] == []
