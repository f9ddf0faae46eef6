"""One agent of a flock, for Mesa: a view on one row of its arrays."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import mesa
import numpy as np

if TYPE_CHECKING:
    from agents.flock import Flock


class Member(mesa.Agent):
    """A `mesa.Agent` whose state is row `row` of its flock's arrays.

    `Member(flock, position=..., heading=...)` adds an agent; without a position or a heading these
    are random, from the flock's generator. The agents that a flock begins with are made by the
    flock.
    """

    def __init__(self, model: Flock, position=None, heading=None, informed=False, *, row=None):
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
