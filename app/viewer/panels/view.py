"""What the picture shows: colours, links, trails, sizes, and from where."""

from __future__ import annotations

from collections.abc import Callable

import viser

from app.viewer.panels.hotkeys import add_hotkeys
from app.viewer.scene import CAMERAS, COLOURINGS, MEASURED, RIDE, STEP_OFF, TRAILS, Look
from app.viewer.values import show


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
        self.trails = gui.add_dropdown(
            "Trail",
            TRAILS,
            initial_value=look.trails,
            hint="Where each agent has been; rising in time: its way through space and time, time "
            "upwards, in flat worlds (look at it from the side)",
        )
        self.length = gui.add_slider(
            "Trail length", 10, 2000, 10, look.trail_length, hint="How far back, ticks"
        )
        self.reach = gui.add_checkbox(
            "Reach",
            look.reach,
            hint="The interaction radius around the clicked agent, or the information agent",
        )
        self.zones = gui.add_checkbox(
            "Zones",
            look.zones,
            hint="The clicked agent's field of view and zones, if its rule has them; neighbours "
            "take the colour of their zone, those it does not see are grey",
        )
        self.wake = gui.add_checkbox(
            "Wake",
            look.wake,
            hint="The lines that birds' wing tips leave behind them: left cool, right warm",
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
        self.fence = gui.add_checkbox(
            "Fence",
            look.fence,
            hint="Of cars in an open area: half a metre inside its edge, where real cars are made "
            "to stop; simulated ones are not",
        )
        self.points = gui.add_checkbox(
            "Boundary points",
            look.points,
            hint="Points along the obstacles' outlines: all that some models perceive of them",
        )
        self.birds = gui.add_checkbox(
            "Birds",
            look.birds,
            hint="In space: birds that bank and beat their wings, up to 3 000; off: darts",
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
        self.ride = gui.add_button(
            "Ride along",
            icon=viser.Icon.FEATHER,
            color="gray",
            hint="A camera on the clicked agent, for this browser only; again, or Esc, to get off",
        )
        self.ride.on_click(self.ridden)
        add_hotkeys(
            gui,
            {
                "B": lambda client: self.point(client, RIDE),
                "escape": lambda client: self.point(client, STEP_OFF),
            },
        )

    async def pointed(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self.point(event.client, event.target.value)

    async def ridden(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self.point(event.client, RIDE)

    def offer(self, numbers: tuple[str, ...]) -> None:
        """Let agents be coloured by these numbers too."""
        choices = (*COLOURINGS, *(name for name in numbers if name not in COLOURINGS))
        if tuple(self.colour.options) != choices:
            chosen = self.colour.value
            self.colour.options = choices
            show(self.colour, chosen if chosen in choices else COLOURINGS[0])

    def next_colour(self) -> None:
        """Colour by the next quantity."""
        choices = tuple(self.colour.options)
        show(self.colour, choices[(choices.index(self.colour.value) + 1) % len(choices)])

    def look(self) -> Look:
        """The drawing as the controls have it."""
        chosen = self.colour.value
        return Look(
            colour=chosen if chosen in COLOURINGS else MEASURED,
            measured="" if chosen in COLOURINGS else chosen,
            links=self.links.value,
            trails=self.trails.value,
            trail_length=self.length.value,
            reach=self.reach.value,
            zones=self.zones.value,
            wake=self.wake.value,
            labels=self.labels.value,
            mission=self.mission.value,
            start=self.start.value,
            fence=self.fence.value,
            points=self.points.value,
            birds=self.birds.value,
            agent_size=self.size.value,
            shadows=self.shadows.value,
        )
