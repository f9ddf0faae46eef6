"""What one flock may take of a machine that many share, and how that is told."""

from __future__ import annotations

from dataclasses import dataclass

from agents.spec import CompleteSpec, Spec
from app.viewer.measuring.observable_format import format_thousands
from app.viewer.run.stored_flock import InitialState, InMemoryFlock
from worlds.input_error import InputError
from worlds.world import World


@dataclass(frozen=True)
class Allowance:
    """What a student of a class may have. All is enforced where it is used, and told in words.

    While nobody looks a flock goes on, but in few large steps, with few frames, and as fast as a
    small share of a core allows.
    """

    agents: int = 2_000
    """Agents of a run at most, with those of the flock beside it; and as many that are informed."""
    share: float = 0.15
    """Of a core for the flock's own thread; as much for the thread that draws it."""
    unseen_share: float = 0.003
    """Of a core for the flock while nobody looks."""
    pictures: float = 16.0
    """Pictures a second at most."""
    panels: float = 0.5
    """Seconds between two refreshments of the panels, and between two measurements."""
    unseen: float = 5.0
    """Seconds between two frames while nobody looks."""
    bandwidth: float = 200_000.0
    """Bytes a second that all browsers together may be sent of the flock, before they are packed:
    of 300 agents 16 pictures a second."""
    obstacles: int = 50
    """Obstacles of a world at most."""
    edits: float = 4.0
    """Changes of a world a second."""
    sweeps: bool = False
    """Whether there may be sweeps."""
    films: bool = False
    """Whether there may be films."""
    recordings: bool = False
    """Whether saved states and recordings may be opened: a process of its own reads each."""
    files: float = 0.1
    """Pictures, and files of a plot, that are made a second."""
    upload: int = 1_000_000
    """Bytes of a file at most."""

    def demand(self, spec: CompleteSpec, beside: Spec | None, stored: InitialState | None) -> None:
        """Raise InputError for a run that is too much, before it is built."""
        flocks = 1 if beside is None else 2
        self.demand_agents(flocks * spec.agents + spec.count_of_kinds)
        self.demand_agents(flocks * spec.informed)
        if stored is None:
            return
        if not isinstance(stored, InMemoryFlock):
            self.demand_recordings(stored.name)
        self.demand_agents(stored.most)

    def demand_recordings(self, name: str) -> None:
        """Raise InputError for a state or a recording where none is opened."""
        if not self.recordings:
            raise InputError(
                f"a class opens no saved states and recordings, as {name}: `flockscope lab` on "
                "your own machine does"
            )

    def demand_agents(self, count: int) -> None:
        """Raise InputError for too many agents."""
        if count > self.agents:
            raise InputError(
                f"a class allows {format_thousands(self.agents)} agents a student: "
                f"{format_thousands(count)} asked for"
            )

    def demand_world(self, world: World) -> None:
        """Raise InputError for a world with too many obstacles."""
        count = len(world.obstacles)
        if count > self.obstacles:
            raise InputError(
                f"a class allows {self.obstacles} obstacles a student: "
                f"{format_thousands(count)} asked for"
            )
