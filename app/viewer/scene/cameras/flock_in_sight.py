"""What one browser draws of one flock of which no agent can be told apart."""

from __future__ import annotations

import numpy as np
from viser import ClientHandle

from app.viewer.scene.draw.drawn_frame import Picture
from app.viewer.scene.marks.agents import Agents, FlockMotion
from app.viewer.scene.shown import drawing_style

MARGIN = 0.12
"""How much more is drawn at each side than is in sight, as a share: a camera moves on at once."""
KEEPS = 1.1
"""Single agents are drawn until so many times as many are in sight as they begin to be drawn of."""


class FlockInSight:
    """What is drawn of a flock in one browser, below a node of its own."""

    typical: float | None = None
    """Their density where the picture has half its strength, per length squared; None: the picture
    is of lines of sight."""

    def __init__(self, client: ClientHandle, side: int, aside: np.ndarray) -> None:
        self.client, self.aside = client, aside
        self.root = f"/sight{side}"
        self.node = client.scene.add_frame(
            self.root, show_axes=False, position=tuple(aside.tolist())
        )
        self.agents: Agents | None = None
        self.as_singles = False
        self.count = 0
        """Agents in sight."""
        self.near = 0
        """How many of them are drawn one by one in front of the density of the others."""

    def are_few(self, count: int) -> bool:
        """Whether so many in sight are drawn one by one."""
        return count <= drawing_style.SINGLES_UP_TO * (KEEPS if self.as_singles else 1.0)

    def draw_rows(self, picture: Picture, rows: np.ndarray) -> None:
        """Draw the agents in some rows one by one, and no others."""
        if len(rows) and self.agents is None:
            self.agents = Agents(self.client.scene, self.root, FlockMotion())
        if self.agents is not None:
            for handle, name, value in self.agents.draw(picture.of_rows(rows)):
                setattr(handle, name, value)

    def end(self) -> None:
        """Draw nothing any more."""
        self.node.remove()  # With all that is below it.
