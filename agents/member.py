"""A flock as Mesa sees it: agents that are rows of its arrays, and a space over them."""

from __future__ import annotations

from random import Random
from typing import Any, Protocol

import mesa
import numpy as np
from mesa.agent import AgentSet
from mesa.experimental.continuous_space import ContinuousSpace

from worlds.world import World


class Rows(Protocol):
    """What a member needs of its flock."""

    world: World
    random: Random

    @property
    def position(self) -> np.ndarray: ...
    @property
    def members(self) -> list[Member]: ...


class Member(mesa.Agent):
    """A `mesa.Agent` whose state is row `row` of its flock's arrays.

    `Member(flock, position=..., heading=...)` adds an agent; without a position or a heading these
    are random, from the flock's generator. The agents that a flock begins with are made by the
    flock.
    """

    def __init__(self, model: Any, position=None, heading=None, informed=False, *, row=None):
        self.row = model.append(self, position, heading, informed) if row is None else row
        super().__init__(model)
        self.unique_id = int(model.ids[self.row])

    @property
    def position(self) -> np.ndarray:
        """Position (dim,), a writable view, length."""
        return self.model.position[self.row]

    @position.setter
    def position(self, value: Any) -> None:
        self.model.position[self.row] = value

    @property
    def pos(self) -> np.ndarray:
        """The position, under the name that Mesa's spaces and pictures use."""
        return self.position

    @pos.setter
    def pos(self, value: Any) -> None:
        if value is not None:
            self.position = value

    @property
    def heading(self) -> np.ndarray:
        """Heading (dim,), a unit vector; what is assigned is brought to length 1."""
        return self.model.heading[self.row]

    @heading.setter
    def heading(self, value: Any) -> None:
        vector = np.asarray(value, float)
        self.model.heading[self.row] = vector / np.linalg.norm(vector)

    @property
    def speed(self) -> float:
        """Distance moved in the last tick, length/tick."""
        return float(self.model.speed[self.row])

    @property
    def informed(self) -> bool:
        """Whether it is an information agent, which never turns by itself."""
        return bool(self.model.informed[self.row])

    @property
    def space(self):
        """The flock's continuous space."""
        return self.model.space

    @property
    def neighbours(self) -> list[Member]:
        """The agents that it listens to."""
        members = self.model.members
        return [members[row] for row in self.model.inspect(self.row).neighbours]

    def step(self) -> None:
        """Decide and move, once per tick; see `Flock.step_member`."""
        self.model.step_member(self.row)

    def remove(self) -> None:
        """Leave the flock."""
        self.model.drop(self)
        super().remove()


class FlockSpace(ContinuousSpace):
    """A `ContinuousSpace` whose positions are the flock's own array.

    Mesa's space keeps a second array and dictionaries; here `agent_positions` and `active_agents`
    are read from the flock, so that its queries (`get_agents_in_radius`, ...) see the truth.
    """

    def __init__(self, flock: Rows):
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
