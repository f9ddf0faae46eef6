"""What a person may choose about the drawing."""

from __future__ import annotations

from dataclasses import dataclass

from app.viewer.scene.shown.control import chosen

COLOURINGS = ("heading", "layer", "group", "speed", "energy saved", "plain")
"""What the colour of an agent may stand for."""

STATE = "state"
LIVE_COLOURINGS = (STATE, "heading", "speed", "plain")
"""What that of a car in a room with real ones may: also whether it is tracked, lost, ..."""

MEASURED = "measured"
"""Any number that each agent has: a signal of its model, or one of `OF_AGENTS`."""

TRAILS = OFF, LINE, RIBBON, RISING = ("off", "line", "ribbon", "rising in time")
"""What an agent may leave behind it; what rises in time does so in flat worlds, else it is flat."""

CAMERAS = ("top-down", "perspective", "side", "follow")
"""The preset points of view."""

RIDE, STEP_OFF = "ride along", "step off"
"""A camera on a bird, and back to where the camera was."""


@dataclass(frozen=True)
class Look:
    """How a frame is drawn, with how it is chosen. Nothing in it changes the flock."""

    colour: str = chosen("heading", "Colour by", "What an agent's colour means", COLOURINGS)
    """One of `COLOURINGS` or `LIVE_COLOURINGS`, or `MEASURED`."""
    measured: str = ""
    """By which number agents are coloured, where `colour` is `MEASURED`."""
    links: bool = chosen(False, "Links", "A line between agents that are neighbours")
    trails: str = chosen(
        OFF,
        "Trail",
        "Where each agent has been; rising in time: its way through space and time, time upwards, "
        "in flat worlds (look at it from the side)",
        TRAILS,
    )
    trail_length: int = chosen(
        60, "Trail length", "How far back, ticks", low=10, high=2000, step=10
    )
    reach: bool = chosen(
        False,
        "Reach",
        "The interaction radius around the clicked agent, or the information agent",
    )
    zones: bool = chosen(
        True,
        "Zones",
        "The clicked agent's field of view and zones, if its rule has them; neighbours take the "
        "colour of their zone, those it does not see are grey",
    )
    wake: bool = chosen(
        False,
        "Wake",
        "The lines that birds' wing tips leave behind them: left cool, right warm",
    )
    labels: bool = chosen(False, "Numbers", "Each agent's number")
    """In small flocks; where there are real cars their names are written always."""
    mission: bool = chosen(
        True,
        "Path & goal",
        "The information agents' waypoints, and the goal that all agents seek",
    )
    start: bool = chosen(True, "Start region", "Where the agents of a mission begin")
    fence: bool = chosen(
        True,
        "Fence",
        "Of cars in an open area: half a metre inside its edge, where real cars are made to stop; "
        "simulated ones are not",
    )
    points: bool = chosen(
        False,
        "Boundary points",
        "Points along the obstacles' outlines: all that some models perceive of them",
    )
    birds: bool = chosen(
        True,
        "Birds",
        "In space: birds that bank and beat their wings, up to 3 000; off: darts",
    )
    agent_size: float = chosen(1.0, "Agent size", low=0.3, high=3.0, step=0.1)
    """As a multiple of the size that suits their density."""
    shadows: bool = chosen(True, "Shadows", "Up to 2 000 agents")

    def __post_init__(self) -> None:
        known = dict.fromkeys((*COLOURINGS, *LIVE_COLOURINGS, MEASURED))
        if self.colour not in known:
            raise ValueError(f"colour = {self.colour!r} is not one of {', '.join(known)}")
        if self.trails not in TRAILS:
            raise ValueError(f"trails = {self.trails!r} is not one of {', '.join(TRAILS)}")
