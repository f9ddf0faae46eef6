"""Show a flock to Mesa: agents that are rows of its arrays, a space over them, ticks as time."""

from __future__ import annotations

import math
from random import Random
from typing import Any, Protocol

import numpy as np

from agents.mesa_import import mesa
from agents.observables.catalogue import OBSERVABLES
from agents.observables.neighbours import separation
from worlds.input_error import InputError, shorten
from worlds.notebook_html import table
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

    _row: int | None = None
    _gone_at = 0

    def __init__(self, model: Any, position=None, heading=None, informed=False, *, row=None):
        self._row = model.append(self, position, heading, informed) if row is None else row
        super().__init__(model)

    def __repr__(self) -> str:
        place = "gone" if self.is_gone else f"row {self._row}"
        return f"<{type(self).__name__} {self.unique_id}, {place}>"

    def _repr_html_(self) -> str:
        if self.is_gone:
            return table({"tick": self._gone_at}, f"Agent {self.unique_id}, gone")
        rows: dict[str, Any] = {
            name: tuple(map(float, getattr(self, name))) for name in ("position", "heading")
        }
        rows |= {"speed": self.speed, "informed": self.informed, "row": self.row}
        return table(rows, f"Agent {self.unique_id}")

    def __getattr__(self, name: str) -> Any:
        """The agent's number of a parameter, its own where agents differ."""
        flock = self.__dict__.get("model")
        if flock is not None and name in flock.parameter_names:
            parameters = flock.parameters_of(self.row)
            if name in type(parameters).model_fields:
                return getattr(parameters, name)
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")

    def __setattr__(self, name: str, value: Any) -> None:
        """A parameter that is assigned is the agent's own from then on. Raises InputError."""
        flock = self.__dict__.get("model")
        if flock is not None and not hasattr(type(self), name) and name in flock.parameter_names:
            flock.set_own(self.row, name, value)
        else:
            super().__setattr__(name, value)

    @property
    def is_gone(self) -> bool:
        """Whether the agent has left its flock; all that its handle then says is that."""
        return self._row is None

    @property
    def row(self) -> int:
        """Its row in the flock's arrays now. Raises InputError once it is gone, as all else
        does."""
        if self._row is None:
            raise InputError(
                f"agent {self.unique_id} is gone: it left the flock at tick {self._gone_at}"
            )
        return self._row

    @row.setter
    def row(self, value: int) -> None:
        self._row = value

    def leave(self) -> None:
        """Be gone: the flock calls this once it has no such agent any more."""
        self._row, self._gone_at = None, self.model.tick

    @property
    def position(self) -> np.ndarray:
        """Position (dim,), a writable view, length; what is assigned wraps where the world does."""
        return self.model.position[self.row]

    @position.setter
    def position(self, value: Any) -> None:
        row, world = self.row, self.model.world
        place = vector("position", value, world.dim)
        self.model.position[row] = np.where(world.wraps, place % np.asarray(world.size), place)

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
        row = self.row
        direction = vector("heading", value, self.model.world.dim)
        if not direction.any():
            raise InputError("heading is a zero vector: a heading needs a direction")
        self.model.heading[row] = direction / np.linalg.norm(direction)

    @property
    def speed(self) -> float:
        """Distance moved in the last tick, length/tick.

        It can be assigned unless the body has one speed, which then is a parameter of the flock.
        """
        return float(self.model.speed[self.row])

    @speed.setter
    def speed(self, value: float) -> None:
        row, flock = self.row, self.model
        one = flock.kind_model_of(row)
        model = flock.model if one is None else one.model
        if model.body.speed is not None:
            raise InputError(
                f"agents of {model.name} go at a speed that is a parameter: set "
                f"{' or '.join(sorted(model.parameters_read(model.body.speed)))} of "
                f"the agent or of the {'flock' if one is None else 'kind'}"
            )
        if not (isinstance(value, (int, float, np.number)) and 0.0 <= value < np.inf):
            raise InputError(
                f"speed = {shorten(value)} is not allowed: a finite number >= 0 is needed"
            )
        flock.speed[row] = value

    @property
    def kind(self) -> str:
        """The name of its kind; `caught` once it was caught and stands still."""
        return str(self.model.kind_names[self.row])

    @property
    def informed(self) -> bool:
        """Whether it is an information agent, which never turns by itself."""
        return bool(self.model.informed[self.row])

    @property
    def space(self):
        """The flock's continuous space."""
        _ = self.row
        return self.model.space

    @property
    def neighbours(self) -> list[Member]:
        """The agents that it listens to."""
        members = self.model.members
        return [members[row] for row in self.model.inspect(self.row).neighbours]

    def get_neighbors_in_radius(self, radius: float = 1) -> tuple[list, np.ndarray]:
        """The other agents within a radius, and how far they are, as Mesa's space has it."""
        agents, distances = self.space.get_agents_in_radius(self.position, radius)
        return self._others(agents, distances)

    def get_nearest_neighbors(self, k: int = 1) -> tuple[list, np.ndarray]:
        """The `k` nearest other agents, and how far they are, as Mesa's space has it."""
        agents, distances = self.space.get_k_nearest_agents(self.position, k + 1)
        return self._others(agents, distances)

    def _others(self, agents: list, distances: np.ndarray) -> tuple[list, np.ndarray]:
        """These agents, and how far they are, without itself."""
        other = np.array([agent is not self for agent in agents], bool)
        return [agent for agent in agents if agent is not self], distances[other]

    def step(self) -> None:
        """Decide and move, once per tick; see `Flock.step_member`."""
        self.model.step_member(self.row)

    def advance(self) -> None:
        """Nothing, as in Mesa: `step` decides and moves."""
        _ = self.row


def vector(name: str, value: Any, dim: int) -> np.ndarray:
    """Finite numbers (dim,). Raises InputError."""
    try:
        array = np.asarray(value, float)
    except (TypeError, ValueError):
        array = np.empty(0)
    if array.shape != (dim,) or not np.isfinite(array).all():
        raise InputError(
            f"{name} = {shorten(value)} is not allowed: {dim} finite numbers are needed"
        )
    return array


class FlockSpace(mesa.experimental.continuous_space.ContinuousSpace):
    """A `ContinuousSpace` whose positions are the flock's own array.

    Mesa's space keeps a second array and dictionaries; here `agent_positions` and `active_agents`
    are read from the flock, so that its queries (`get_agents_in_radius`, ...) see the truth. Mesa's
    space is a torus along all axes or none; where a world wraps along some, ours is, too.
    """

    def __init__(self, flock: Rows):
        self.flock = flock
        box = np.column_stack([np.zeros(flock.world.dim), flock.world.size])
        super().__init__(box, torus=bool(flock.world.images.all()), random=flock.random, n_agents=0)

    @property
    def is_mixed(self) -> bool:
        """Whether distances are to the nearest image along some axes and not along others."""
        images = self.flock.world.images
        return bool(images.any() and not images.all())

    def calculate_difference_vector(self, point: Any, agents: Any = None) -> np.ndarray:
        """From a point to all agents, or to some, (N, dim), length."""
        if not self.is_mixed:
            return super().calculate_difference_vector(point, agents)
        rows = slice(None) if agents is None else [agent.row for agent in agents]
        world = self.flock.world
        return separation(point, self.flock.position[rows], world.size, world.images)

    def calculate_distances(self, point: Any, agents: Any = None, **kwargs: Any) -> tuple:
        """Distances (N,) from a point to all agents, or to some, and these agents."""
        if not self.is_mixed:
            return super().calculate_distances(point, agents, **kwargs)
        if kwargs:
            raise InputError(
                f"{next(iter(kwargs))} is not taken where a world wraps along some axes"
            )
        distances = np.linalg.norm(self.calculate_difference_vector(point, agents), axis=-1)
        return distances, self.active_agents if agents is None else np.asarray(agents)

    def torus_correct(self, point: Any) -> np.ndarray:
        """A point, in the box along the axes that wrap; where none does, along all, as in Mesa."""
        wraps = self.flock.world.wraps
        inside = super().torus_correct(point)
        return np.where(wraps, inside, point) if wraps.any() else inside

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
        """Do nothing: Mesa's methods assign, the flock's rows stand."""

    @property
    def active_agents(self) -> list:
        """The flock's agents by row."""
        return self.flock.members

    @active_agents.setter
    def active_agents(self, value: list) -> None:
        """Do nothing: Mesa's methods assign, the flock's rows stand."""

    @property
    def _agent_to_index(self) -> dict:
        return {member: member.row for member in self.flock.members}

    @_agent_to_index.setter
    def _agent_to_index(self, value: dict) -> None:
        """Do nothing: Mesa's methods assign, the flock's rows stand."""

    @property
    def agents(self) -> mesa.agent.AgentSet:
        """The flock's agents."""
        return mesa.agent.AgentSet(self.flock.members, random=self.random)


# What other tools call something.

OTHER_NAMES = {
    "schedule": "agents", "turtles": "agents", "ask": "agents",
    "grid": "space", "patches": "world", "ticks": "tick", "random_seed": "seed",
    "positions": "position", "xcor": "position", "ycor": "position", "headings": "heading",
    "params": "parameters", "globals": "parameters", "width": "world.size", "height": "world.size",
    "plot": "show", "draw": "show", "monitor": "observe", "reporter": "observe",
    "report": "observe", "go": "run", "simulate": "run", "setup": "restart",
    "reset_ticks": "restart", "clear_all": "restart", "set_seed": "restart", "export_world": "save",
}  # fmt: skip
"""What Mesa, NetLogo and scripts call something -> what it is called here."""


def other_name(attribute: str) -> str:
    """What an attribute that other tools have is called here, with the colon before it.

    >>> other_name("grid"), other_name("polarisation"), other_name("colour")
    (": it is called 'space' here", ": use observe('polarisation')", '')
    """
    if attribute in OTHER_NAMES:
        return f": it is called {OTHER_NAMES[attribute]!r} here"
    observable = attribute.replace("_", "-")
    return f": use observe({observable!r})" if observable in OBSERVABLES else ""


# Its ticks as Mesa's time: `time`, `steps`, and events when they are due.


class TickClock(mesa.Model):
    """A `mesa.Model` whose time is the tick of a flock, however the flock came to it.

    Mesa counts only what passes through its own `step`; a flock also runs ticks in compiled code,
    goes on as its agents step one by one, and goes back to a saved state. So `time` and `steps`
    follow `tick`, and a run stops for each event. An event at time t happens once tick t is done.

    Mesa has no public name for its list of events and for the schedule that calls `step`: those
    that are used here are the same in Mesa 3.5 and 4.0.0a0, and `tests/mesa` says when not.
    """

    time: float
    _tick = 0
    _loops = 0
    """How many of Mesa's event loops are under way, one inside the other."""
    _took_step = False
    """Whether the step that Mesa would call next was taken out of its list."""
    _of_mesa: frozenset[str] = frozenset()
    """The attributes that Mesa gives a model as it is made."""
    seed: int
    next_id: int

    def _begin_model(self) -> None:
        """Be a new model of Mesa's."""
        others = {*vars(self)}
        super().__init__(rng=self.seed)
        self._of_mesa = frozenset(vars(self).keys() - others)

    def _put_off_model(self) -> None:
        """Be a new model of Mesa's as soon as anybody asks for anything of it.

        To make one takes as long as a good deal of a short run, which never asks.
        """
        for name in (*self._of_mesa, "_took_step"):
            self.__dict__.pop(name, None)
        self.step = self._first_step

    @property
    def _is_put_off(self) -> bool:
        return "_event_list" not in self.__dict__

    def _begin_put_off(self) -> None:
        tick, next_id = self._tick, self.next_id
        self.__dict__.pop("step", None)  # Mesa puts its own over the class's
        self._begin_model()
        self.tick, self.next_id = tick, next_id

    def _first_step(self) -> None:
        self._begin_put_off()
        self.step()

    def __getattr__(self, name: str) -> Any:
        """What is there as soon as it is asked for; of what is not, what else it may be called."""
        if name in self._of_mesa and self._is_put_off:
            self._begin_put_off()
            return getattr(self, name)
        what = f"{type(self).__name__!r} object has no attribute {name!r}"
        raise AttributeError(f"{what}{other_name(name)}")

    @property
    def tick(self) -> int:
        """Ticks done."""
        return self._tick

    @tick.setter
    def tick(self, value: int) -> None:
        self._tick = value
        if self._is_put_off:
            return
        self.steps = value
        if self.time != value:
            self.time = float(value)

    def _advance_time(self, until: float) -> None:
        """Mesa's loop over events, `step` among them, up to a time."""
        if not self._loops:
            self._schedule_step()
        self._loops += 1
        try:
            super()._advance_time(until)
        finally:
            self._loops -= 1
        if self.time < self._tick:  # a step may run many ticks; Mesa then sets the time it expected
            self.time = float(self._tick)
            self._fire(self.time)

    def _ticks_to_event(self, ticks: int) -> int:
        """How many of so many ticks, one at least, can run before an event; fires what is due."""
        if self._is_put_off:
            return ticks
        self._fire(math.nextafter(self._tick + 1, 0.0))
        due = self._next_event()
        return ticks if due >= self._tick + ticks else max(1, math.floor(due) - self._tick)

    @property
    def has_events(self) -> bool:
        """Whether Mesa's part of the flock is there, which may have events."""
        return not self._is_put_off

    def _fire_due(self) -> None:
        """Fire the events of this tick, unless a loop of Mesa's is about to."""
        if self._is_put_off:
            return
        if not self._loops:
            self._fire(self.time)
        elif self._took_step:
            self._schedule_step()

    def _next_event(self) -> float:
        """The time of the next event, infinite without one."""
        try:
            event = self._event_list.pop_event()
        except IndexError:
            return math.inf
        self._event_list.add_event(event)
        return float(event.time)

    def _fire(self, until: float) -> None:
        """Execute the events up to a time; the scheduled step is no event, and is taken out."""
        while True:
            try:
                event = self._event_list.pop_event()
            except IndexError:
                return
            if event is self._default_schedule._current_event:
                event.cancel()
                self._took_step = True
            elif event.time <= until:
                self.time = max(self.time, float(event.time))
                event.execute()
            else:
                self._event_list.add_event(event)
                return

    def _schedule_step(self) -> None:
        """Have Mesa call `step` at the next whole time, whatever moved the flock since."""
        self._took_step = False
        schedule, at = self._default_schedule, math.floor(self.time) + 1
        event = schedule._current_event
        if event is not None and not event.CANCELED:
            if event.time == at:
                return
            event.cancel()
        schedule._schedule_next(float(at))
