"""Tells at once when agents are where they cannot be, and lets the exit code say so at the end."""

from __future__ import annotations

from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from agents import Flock
    from agents.state.agent_rows import StrayAgents

ASTRAY = 4
"""Exit code of a run in which an agent was inside an obstacle or beyond a solid edge."""


class StrayAgentCheck:
    """Looks now and then whether an agent of a flock is where it cannot be."""

    def __init__(self, flock: Flock):
        self.flock = flock
        self.found: StrayAgents | None = None
        """The first that was seen."""

    def look(self) -> None:
        """Look now; the first time that one is found, tell."""
        if self.found is None:
            self.found = self.flock.stray()
            if self.found is not None:
                typer.echo(f"flockscope: {self.found}", err=True)

    def leave(self) -> None:
        """Stop with ASTRAY if one was found."""
        if self.found is not None:
            raise typer.Exit(ASTRAY)
