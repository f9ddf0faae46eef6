"""What the picture shows: colours, links, trails, sizes, and from where."""

from __future__ import annotations

from collections.abc import Callable

import viser

from app.viewer.scene import CAMERAS, COLOURINGS, Look


class ViewPanel:
    """Makes the `Look`; the cameras are each browser's own."""

    def __init__(
        self, gui: viser.GuiApi, look: Look, point: Callable[[viser.ClientHandle, str], None]
    ):
        self.point = point
        self.colour = gui.add_dropdown(
            "Colour by", COLOURINGS, initial_value=look.colour, hint="What an agent's colour means"
        )
        self.links = gui.add_checkbox(
            "Links", look.links, hint="A line between agents that are neighbours"
        )
        self.trails = gui.add_checkbox("Trails", look.trails, hint="Where each agent has been")
        self.length = gui.add_slider(
            "Trail length", 10, 200, 10, look.trail_length, hint="How far back, ticks"
        )
        self.reach = gui.add_checkbox(
            "Reach",
            look.reach,
            hint="The interaction radius around the clicked agent, or the information agent",
        )
        self.labels = gui.add_checkbox("Numbers", look.labels, hint="Each agent's number")
        self.mission = gui.add_checkbox(
            "Path & goal",
            look.mission,
            hint="The information agents' waypoints, and the goal that all agents seek",
        )
        self.start = gui.add_checkbox(
            "Start region", look.start, hint="Where the agents of a mission begin"
        )
        self.points = gui.add_checkbox(
            "Boundary points",
            look.points,
            hint="Points along the obstacles' outlines: all that some models perceive of them",
        )
        self.size = gui.add_slider("Agent size", 0.3, 3.0, 0.1, look.agent_size)
        self.shadows = gui.add_checkbox("Shadows", look.shadows, hint="Up to 2 000 agents")
        self.steer = gui.add_checkbox(
            "Steer",
            False,
            hint="Handles on the information agent: drag it about and turn it",
        )
        self.camera = gui.add_button_group(
            "Camera", CAMERAS, hint="For this browser only; follow goes after the clicked agent"
        )
        self.camera.on_click(self.pointed)

    async def pointed(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self.point(event.client, event.target.value)

    def look(self) -> Look:
        """The drawing as the controls have it."""
        return Look(
            colour=self.colour.value,
            links=self.links.value,
            trails=self.trails.value,
            trail_length=self.length.value,
            reach=self.reach.value,
            labels=self.labels.value,
            mission=self.mission.value,
            start=self.start.value,
            points=self.points.value,
            agent_size=self.size.value,
            shadows=self.shadows.value,
        )
