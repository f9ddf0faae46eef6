"""What a person may choose about the drawing."""

from __future__ import annotations

from dataclasses import dataclass

COLOURINGS = ("heading", "layer", "group", "speed", "energy saved", "plain")
"""What the colour of an agent may stand for."""

MEASURED = "measured"
"""Any number that each agent has: a signal of its model, or one of `OF_AGENTS`."""

STATE = "state"
LIVE_COLOURINGS = (STATE, "heading", "speed", "plain")
"""What that of a car in a room with real ones may: also whether it is tracked, lost, ..."""

TRAILS = OFF, LINE, RIBBON, RISING = ("off", "line", "ribbon", "rising in time")
"""What an agent may leave behind it; what rises in time does so in flat worlds, else it is flat."""

CAMERAS = ("top-down", "perspective", "side", "follow")
"""The preset points of view."""

RIDE, STEP_OFF = "ride along", "step off"
"""A camera on a bird, and back to where the camera was."""


@dataclass(frozen=True)
class Look:
    """How a frame is drawn. Nothing in it changes the flock."""

    colour: str = "heading"
    """One of `COLOURINGS` or `LIVE_COLOURINGS`, or `MEASURED`."""
    measured: str = ""
    """By which number agents are coloured, where `colour` is `MEASURED`."""
    links: bool = False
    """Draw a line between neighbours (needs `Frame.links`)."""
    trails: str = OFF
    """One of `TRAILS`: how to draw where each agent has been."""
    trail_length: int = 60
    """How far back a trail reaches, ticks."""
    reach: bool = False
    """Draw the interaction radius around the inspected agent, or else around the leader."""
    zones: bool = True
    """Draw the field of view and the zones of the inspected agent, where its rule has them."""
    wake: bool = False
    """Draw where the wing tips of birds have been."""
    labels: bool = False
    """Write the identity beside each agent (small flocks); where there are real cars their names
    are written always."""
    mission: bool = True
    """Draw the information agents' path and the goal."""
    start: bool = True
    """Draw the region in which the mission starts."""
    fence: bool = True
    """Draw the fence of a capture area of cars."""
    points: bool = False
    """Draw the boundary points of obstacles (needs `Frame.points`)."""
    birds: bool = True
    """Draw the agents of a flock in space as birds (up to 3 000 of them)."""
    agent_size: float = 1.0
    """Size of the agents as a multiple of the size that suits their density."""
    shadows: bool = True
    """Let agents cast shadows (up to 2 000 of them)."""

    def __post_init__(self) -> None:
        known = dict.fromkeys((*COLOURINGS, *LIVE_COLOURINGS, MEASURED))
        if self.colour not in known:
            raise ValueError(f"colour = {self.colour!r} is not one of {', '.join(known)}")
        if self.trails not in TRAILS:
            raise ValueError(f"trails = {self.trails!r} is not one of {', '.join(TRAILS)}")
