"""What a person may choose about the drawing."""

from __future__ import annotations

from dataclasses import dataclass

COLOURINGS = ("heading", "layer", "group", "speed", "plain")
"""What the colour of an agent may stand for."""

CAMERAS = ("top-down", "perspective", "side", "follow")
"""The preset points of view."""


@dataclass(frozen=True)
class Look:
    """How a frame is drawn. Nothing in it changes the flock."""

    colour: str = "heading"
    """One of `COLOURINGS`."""
    links: bool = False
    """Draw a line between neighbours (needs `Frame.links`)."""
    trails: bool = False
    """Draw where each agent has been."""
    trail_length: int = 60
    """How far back a trail reaches, ticks."""
    reach: bool = False
    """Draw the interaction radius around the inspected agent, or else around the leader."""
    labels: bool = False
    """Write the identity beside each agent (small flocks)."""
    mission: bool = True
    """Draw the information agents' path and the goal."""
    start: bool = True
    """Draw the region in which the mission starts."""
    points: bool = False
    """Draw the boundary points of obstacles (needs `Frame.points`)."""
    agent_size: float = 1.0
    """Size of the agents as a multiple of the size that suits their density."""
    shadows: bool = True
    """Let agents cast shadows (up to 2 000 of them)."""

    def __post_init__(self) -> None:
        if self.colour not in COLOURINGS:
            raise ValueError(f"colour = {self.colour!r} is not one of {', '.join(COLOURINGS)}")
