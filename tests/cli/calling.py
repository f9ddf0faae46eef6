"""Calling the command line, in this process or as a program of its own."""

import subprocess
import sys
import time

from typer.testing import CliRunner

from app.cli.main import app

PROGRAM = [sys.executable, "-m", "flockscope"]


def call(*args):
    """Call a command in this process: exit_code, stdout, stderr."""
    result = CliRunner().invoke(app, [str(arg) for arg in args], prog_name="flockscope")
    if result.exception and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result


def refusal(*args):
    """The one line with which a call is refused."""
    result = call(*args)
    assert result.exit_code == 2
    assert result.stdout == ""
    line, *more = result.stderr.rstrip("\n").split("\n")
    assert more == []
    assert line.startswith("flockscope: ")
    return line


def start(*args, **more):
    """Start a command as a program of its own."""
    return subprocess.Popen(
        [*PROGRAM, *(str(arg) for arg in args)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **more,
    )


def wait_until(condition, process, seconds=240.0):
    """Wait until a condition holds while the process runs."""
    end = time.monotonic() + seconds
    while not condition():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < end, "it took too long"
        time.sleep(0.02)


def size(path):
    """Bytes in a file; 0 if there is none."""
    return path.stat().st_size if path.exists() else 0
