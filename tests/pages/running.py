"""Runs commands in this process, those that open a window until their page has been read."""

from __future__ import annotations

import os
import signal
import threading
import time
import urllib.request
import webbrowser

from cli.calling import call

from app.cli.main import load

LATEST = 900.0
"""After so long a command that waits for its browser is told to stop, s."""


def parse(words):
    """Parse a command and do nothing: usage errors are raised."""
    command = load(words[0])
    rest = words[1:]
    if hasattr(command, "commands"):
        command, rest = command.commands[words[1]], words[2:]
    command.make_context(" ".join(words), list(rest))


def run(words, monkeypatch):
    """Run a command that ends by itself: exit_code, stdout, stderr."""
    monkeypatch.setattr(webbrowser, "open", not_here)
    return call(*words)


def not_here(address):
    """Stands for a browser where none may be opened."""
    raise AssertionError(f"a browser was opened at {address}")


def visit(words, monkeypatch):
    """Run a command that serves a page; read the page in place of a browser, then press Ctrl-C.

    Returns exit_code, stdout and stderr; asserts that the page was there.
    """
    read = []

    def look(address):
        with urllib.request.urlopen(address, timeout=60.0) as answer:
            read.append((answer.status, answer.read()))
        signal.raise_signal(signal.SIGINT)
        return True

    monkeypatch.setattr(webbrowser, "open", look)
    monkeypatch.setattr(os, "_exit", lambda _code: None)  # this process has more to do
    before = set(threading.enumerate())
    main = threading.main_thread().ident
    give_up = threading.Timer(LATEST, signal.pthread_kill, (main, signal.SIGINT))
    give_up.start()
    try:
        result = call(*words)
    finally:
        give_up.cancel()
        give_up.join()
    ends = time.monotonic() + LATEST  # a thread may still compile, or be about to begin
    while set(threading.enumerate()) - before and time.monotonic() < ends:
        time.sleep(0.05)
    assert read, f"no page was opened: {result.stdout}{result.stderr}"
    [(status, page)] = read
    assert status == 200
    assert b"<html" in page
    return result
