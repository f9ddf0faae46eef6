"""What a person may choose about the drawing."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from agents.models.model import Model
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.colouring import COLOURINGS, KIND, MEASURED, OWN, Legend
from app.viewer.scene.shown.control import chosen_field
from app.viewer.scene.shown.frame import Frame

TRAILS = OFF, LINE, RIBBON, RISING = ("off", "line", "ribbon", "rising in time")
"""What an agent may leave behind it; what rises in time does so in flat worlds, else it is flat."""

CAMERAS = ("top-down", "perspective", "side", "follow")
"""The preset points of view."""

RIDE, STEP_OFF = "ride along", "step off"
"""A camera on a bird, and back to where the camera was."""

AS_MODEL, DARTS, BIRDS, FISH = FORMS = ("as the model", "darts", "birds", "fish")
"""What agents may be drawn as: what the source of their model is about, or one of these."""
ANIMALS_UP_TO = 3_000
"""More agents than this are darts, whatever they are."""
SHADOWS_UP_TO = 2_000
"""More agents than this cast no shadows."""
DENSITY_BEYOND = 150_000
"""More agents than this are drawn as a picture of their density: a browser moves so many points
well, and of more points no flock can be seen."""
SINGLES_UP_TO = 20_000
"""Of such a flock as many agents in sight of a camera are drawn one by one: they take as much of a
line as a picture of density does."""
DENSITY_PERIOD = 0.1
"""Shortest time between two pictures of density, s."""
NUMBERED_UP_TO = 120
"""Numbers are written beside at most this many agents; of more, beside the clicked one's
neighbours."""

GROUPS = AGENTS, WORLD, CAMERA = ("Agents", "World", "Camera")
"""What the controls of the drawing are about."""


def has_needed(colouring: str, frame: Frame, _look: object = None) -> bool:
    """Whether a flock has what a colouring stands for."""
    return COLOURINGS[colouring].needs(frame)


def drawn_form(frame: Frame, look: DrawingStyle) -> str:
    """What a flock is drawn as, unless as cars: birds in space alone, darts if they are many."""
    form = frame.form if look.form == AS_MODEL else look.form
    is_possible = may_be_animals(frame) and (form != BIRDS or frame.dim == 3)
    return form if is_possible else DARTS


def as_birds(frame: Frame, look: DrawingStyle) -> bool:
    """Whether a flock is drawn as birds."""
    return drawn_form(frame, look) == BIRDS


def may_be_animals(frame: Frame, _look: object = None) -> bool:
    """Whether a flock can be drawn as anything but darts or cars."""
    is_of_cars = frame.cars is not None and frame.dim == 2
    return len(frame.ids) <= ANIMALS_UP_TO and not is_of_cars


def shows_density(frame: Frame) -> bool:
    """Whether a flock is drawn as a picture of its density, and single agents only from near."""
    is_of_cars = frame.cars is not None and frame.dim == 2
    return len(frame.ids) > DENSITY_BEYOND and not is_of_cars


def leaves_trails(frame: Frame, look: DrawingStyle) -> bool:
    """Whether anything is drawn of where agents have been."""
    return look.trails != OFF or (look.wake and as_birds(frame, look))


def can_be_numbered(frame: Frame, _look: object = None) -> bool:
    """Whether numbers can be written beside agents; names of real cars are written always."""
    few = len(frame.ids) <= NUMBERED_UP_TO or frame.inspected is not None
    return few and frame.live is None


def has_way(frame: Frame, _look: object = None) -> bool:
    """Whether there are waypoints, a goal, sources or exits."""
    mission = frame.world.mission
    if mission is None:
        return False
    return mission.path is not None or mission.goal is not None or mission.has_gates


def is_fenced(frame: Frame, _look: object = None) -> bool:
    """Whether there are cars in an open area."""
    return frame.cars is not None and set(frame.world.edges) == {"open"}


@dataclass(frozen=True)
class DrawingStyle:
    """How a frame is drawn, with how it is chosen, and where. Nothing in it changes the flock."""

    colour: str = chosen_field(
        "heading",
        "Colour by",
        "What an agent's colour means",
        tuple(name for name in COLOURINGS if name != MEASURED),
        group=AGENTS,
        only={name: partial(has_needed, name) for name in COLOURINGS},
    )
    """One of `COLOURINGS`."""
    measured: str = ""
    """By which number agents are coloured, where `colour` is `MEASURED`."""
    links: bool = chosen_field(
        False, "Links", "A line between agents that are neighbours", group=AGENTS
    )
    trails: str = chosen_field(
        OFF,
        "Trail",
        "Where each agent has been; rising in time: its way through space and time, time upwards, "
        "in flat worlds",
        TRAILS,
        group=AGENTS,
    )
    wake: bool = chosen_field(
        False,
        "Wake",
        "The lines that birds' wing tips leave behind them: left cool, right warm",
        group=AGENTS,
        applies=as_birds,
    )
    trail_length: int = chosen_field(
        60,
        "Trail length",
        "How far back, ticks",
        low=10,
        high=5000,
        step=10,
        group=AGENTS,
        applies=leaves_trails,
    )
    reach: bool = chosen_field(
        False,
        "Reach",
        "The interaction radius around the clicked agent, or the information agent",
        group=AGENTS,
    )
    zones: bool = chosen_field(
        True,
        "Zones",
        "The clicked agent's field of view and zones; neighbours take the colour of their zone, "
        "those it does not see are grey",
        group=AGENTS,
        applies=lambda frame, _: np.isfinite(frame.kept),
    )
    labels: bool = chosen_field(
        False, "Numbers", "Each agent's number", group=AGENTS, applies=can_be_numbered
    )
    """In small flocks; where there are real cars their names are written always."""
    form: str = chosen_field(
        AS_MODEL,
        "Drawn as",
        "As the model: what its source is about. In the plane birds are darts",
        FORMS,
        group=AGENTS,
        applies=may_be_animals,
    )
    agent_size: float = chosen_field(1.0, "Agent size", low=0.3, high=3.0, step=0.1, group=AGENTS)
    """As a multiple of the size that suits their density."""
    shadows: bool = chosen_field(
        True,
        "Shadows",
        group=AGENTS,
        applies=lambda frame, _: len(frame.ids) <= SHADOWS_UP_TO,
    )
    mission: bool = chosen_field(
        True,
        "Path & goal",
        "The information agents' waypoints, and the goal that all agents seek",
        group=WORLD,
        applies=has_way,
    )
    start: bool = chosen_field(
        True,
        "Start region",
        "Where the agents of a mission begin",
        group=WORLD,
        applies=lambda frame, _: frame.room is not None,
    )
    fence: bool = chosen_field(
        True,
        "Fence",
        "Half a metre inside the edge of the area, where real cars are made to stop; simulated "
        "ones are not",
        group=WORLD,
        applies=is_fenced,
    )
    points: bool = chosen_field(
        False,
        "Boundary points",
        "Points along the obstacles' outlines: all that these agents perceive of them",
        group=WORLD,
        applies=lambda frame, _: frame.sees_points and frame.world.is_solid,
    )

    def __post_init__(self) -> None:
        if self.colour not in COLOURINGS:
            raise ValueError(f"colour = {self.colour!r} is not one of {', '.join(COLOURINGS)}")
        if self.trails not in TRAILS:
            raise ValueError(f"trails = {self.trails!r} is not one of {', '.join(TRAILS)}")
        if self.form not in FORMS:
            raise ValueError(f"form = {self.form!r} is not one of {', '.join(FORMS)}")


def agent_colours(frame: Frame, look: DrawingStyle) -> np.ndarray:
    """Colours (N, 3), sRGB in [0, 1]; information agents and predators
    wear their own, and so do the caught and the crashed."""
    colours = COLOURINGS[look.colour].colours(frame)
    colours[np.asarray(frame.informed, dtype=bool)] = palette.LEADER
    if frame.cars is not None:
        colours[frame.cars.predator] = palette.LEADER
    colours[frame.is_caught] = palette.CAUGHT
    colours[frame.is_down] = palette.CRASHED
    return colours


def legend(look: DrawingStyle, frame: Frame) -> Legend:
    """What the colours mean, but for headings, which a wheel explains."""
    colouring = COLOURINGS[look.colour]
    entries = colouring.legend(frame, look.measured)
    if frame.informed.any() and not colouring.has_leader:
        entries = [*entries, ("information agent", palette.css(palette.LEADER))]
    if frame.cars is not None and frame.cars.predator.any():
        entries = [*entries, ("predator", palette.css(palette.LEADER))]
    if frame.is_caught.any():
        entries = [*entries, ("caught", palette.css(palette.CAUGHT))]
    return [*entries, ("crashed", palette.css(palette.CRASHED))] if frame.is_down.any() else entries


# How a flock is drawn as long as nobody chooses otherwise.

FEW = 12
"""So many cars at most are told apart by their colours."""
TURNS = 40.0
"""How far back what rises with time goes behind cars, s: they go round their room some times, and
their ways are the helices of Jacobs and Koessler's figures."""


@dataclass(frozen=True)
class DrawingDefaults:
    """A look, and what it is with trails that rise."""

    look: DrawingStyle
    rising: int
    """Trail length where trails rise with time, ticks."""


def default_style(
    model: Model, agents: int | None, tick: float, has_kinds: bool = False
) -> DrawingDefaults:
    """How a flock of a model is drawn whose ticks last so long, in its unit of time."""
    common = DrawingStyle(colour=KIND) if has_kinds else DrawingStyle()
    if model.body.vehicle is None:
        return DrawingDefaults(common, common.trail_length)
    few = agents is not None and agents <= FEW and not has_kinds
    return DrawingDefaults(DrawingStyle(colour=OWN) if few else common, trail_turns(tick))


def trail_turns(tick: float) -> int:
    """`TURNS` in ticks that last so long, s."""
    return round(TURNS / tick)
