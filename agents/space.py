"""Mesa's continuous space over a flock's arrays, for its queries and its pictures."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from mesa.agent import AgentSet
from mesa.experimental.continuous_space import ContinuousSpace

if TYPE_CHECKING:
    from agents.flock import Flock


class FlockSpace(ContinuousSpace):
    """A `ContinuousSpace` whose positions are the flock's own array.

    Mesa's space keeps a second array and dictionaries; here `agent_positions` and `active_agents`
    are read from the flock, so that its queries (`get_agents_in_radius`, ...) see the truth.
    """

    def __init__(self, flock: Flock):
        self.flock = flock
        box = np.column_stack([np.zeros(flock.world.dim), flock.world.size])
        super().__init__(box, torus=bool(flock.world.images.all()), random=flock.random, n_agents=0)

    @property
    def agent_positions(self) -> np.ndarray:
        """The flock's positions, (N, dim)."""
        return self.flock.position

    @agent_positions.setter
    def agent_positions(self, value: np.ndarray) -> None:
        """Mesa's constructor assigns; the flock's array stands."""

    @property
    def _agent_positions(self) -> np.ndarray:
        return self.flock.position

    @_agent_positions.setter
    def _agent_positions(self, value: np.ndarray) -> None:
        """As above."""

    @property
    def active_agents(self) -> list:
        """The flock's agents by row."""
        return self.flock.members

    @active_agents.setter
    def active_agents(self, value: list) -> None:
        """As above."""

    @property
    def _agent_to_index(self) -> dict:
        return {member: member.row for member in self.flock.members}

    @_agent_to_index.setter
    def _agent_to_index(self, value: dict) -> None:
        """As above."""

    @property
    def agents(self) -> AgentSet:
        """The flock's agents."""
        return AgentSet(self.flock.members, random=self.random)
