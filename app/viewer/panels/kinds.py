"""Which kinds of agents there are, and whom each chases, flees from, heeds or ignores."""

from __future__ import annotations

import html
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

import numpy as np
import viser

from agents.catalogue import MODELS, PLAYED
from agents.individuals import Distribution, split_individuals
from agents.kind_models import fitting_models
from agents.kinds import ORDINARY, Kind, KindTable, Relation, chase, kind_table, replace_kind
from agents.models.declare import NumberParameter, checked, declared
from agents.models.model import Model
from app.front.controls import set_value
from app.viewer.panels.dials import Dials, plain_symbol, set_visible
from app.viewer.panels.followed_value import FollowedValue
from app.viewer.panels.parameters import ParametersPanel, Step, add_control
from app.viewer.panels.shell import block, key
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_state import SimulationState
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.frame import Frame
from worlds.input_error import InputError

TITLE = "Kinds of agents"
ONE = "All agents are of one kind. Add a predator, or a kind of your own."
OF_FIRST = "These kinds are in the first flock alone."
DEEDS = {"chases": "chase", "flees from": "flee", "heeds": "own", "ignores": "ignore"}
"""What a kind may do about another, as the page calls it."""
CAUGHT = {
    "leaves the flock": "taken",
    "stands still": "frozen",
    "begins elsewhere": "moved",
    "is only counted": "counted",
}
"""What becomes of who is caught, as the page calls it."""
FLOCK_MODEL = "as the flock"
"""The choice of no model of its own."""
BY_ITSELF = "by itself"
COLOURS = {BY_ITSELF: "", **{name: palette.css(colour) for name, colour in palette.OWN.items()}}
MOST_OF_A_KIND = 10_000
"""Agents of a kind that are added from the page."""
HEAVIEST = 20.0
"""The largest weight of a slider, where a kind has no larger one."""


# What the sliders of a relation span.


def relation_parameter(name: str, value: float, side: float) -> NumberParameter:
    """The weight, radius or catch distance of a relation, as a slider has it.

    `side`: the longest of the world, length.
    """
    told = {
        "weight": ("Weight", "w", "1", "How much it counts beside what the rule wishes"),
        "radius": ("Within", "R", "length", "The distance up to which they notice the others"),
        "catch": ("Catches within", "c", "length", "The distance at which one is caught; 0: never"),
    }
    words, symbol, unit, description = told[name]
    high = HEAVIEST if name == "weight" else side
    high = max(high, value)
    low = 1e-3 * side if name == "radius" else 0.0
    low = min(low, value)
    proposed = {"weight": 0.25 * high, "radius": 0.5 * high, "catch": 0.1 * high}[name]
    return NumberParameter(
        name=name,
        symbol=symbol,
        unit=unit,
        description=description,
        source="It acts at once",
        default=value,
        kind="number",
        low=low,
        high=high,
        step=None,
        choices=(),
        noise=False,
        words=words,
        proposed=(min(0.02 * side, value) if name == "radius" else low, max(proposed, value)),
    )


def own_parameters(model: Model) -> dict[str, NumberParameter]:
    """The parameters of which a kind may have numbers of its own, by what they are called."""
    return {
        f"{one.words} {plain_symbol(one.symbol)}": one
        for one in declared(model.parameters)
        if one.name in model.individual and isinstance(one, NumberParameter)
    }


def centre(value: Any) -> float:
    """A number, or the centre of what differs."""
    return float(value.centre if isinstance(value, Distribution) else value)


# A predator that suits any flock.

PREDATOR = "predator"
SPEEDS = ("Speed", "Cruise speed", "Desired speed", "Largest speed", "Speed at full throttle")
"""What parameters are called that say how fast a body goes."""
FASTER = 1.3
"""Times as fast as the flock is a predator."""
ONE_FOR, MOST_PREDATORS = 40, 5
"""One predator for so many agents, and so many at most."""
FAR, NEAR = 1.5, 0.25
"""How far it sees, in distances at which agents notice each other, and two distances from neighbour
to neighbour at least; and at which distance it catches, in the latter."""
WIDEST = 0.4
"""The largest share of the world's shortest side that it sees."""
EAGER = 2.0
"""How much it heeds the flock, where 1 is what all agree on."""


def predator(state: SimulationState, frame: Frame) -> Kind:
    """A kind that chases the ordinary agents of a flock and catches them, as suits its model."""
    model = MODELS[state.spec.model]
    names, number = state.kinds.names, 1
    while (name := PREDATOR if number == 1 else f"{PREDATOR}-{number}") in names:
        number += 1
    ordinary = state.spec.agents + state.spec.informed
    size = np.asarray(frame.size, float)
    spacing = float((np.prod(size) / max(ordinary, 1)) ** (1.0 / len(size)))
    radius = min(max(FAR * frame.reach, 2.0 * spacing), WIDEST * float(size.min()))
    catch = min(NEAR * spacing, NEAR * radius)
    if frame.cars is not None:  # which keep each other at a body's length
        catch = max(catch, 1.5 * frame.cars.length)
    own: dict[str, float] = {}
    fastest = 0.0
    for one in own_parameters(model).values():
        if one.words in SPEEDS and (speed := centre(state.values[one.name])) > 0.0:
            own[one.name] = rounded(min(FASTER * speed, one.high))
            fastest = max(fastest, speed)
    # Of a heading 1 is what all agree on; other wishes are velocities, or what changes them.
    weight = EAGER if model.rule.wish == "heading" else EAGER * (fastest or 1.0)
    hunts = chase(rounded(weight), rounded(radius), catch=rounded(catch))
    return Kind(
        name,
        int(np.clip(round(ordinary / ONE_FOR), 1, MOST_PREDATORS)),
        parameters=own,
        to={ORDINARY: hunts},
    )


def rounded(number: float) -> float:
    """A number in two figures.

    >>> rounded(0.03456), rounded(123.0)
    (0.035, 120.0)
    """
    return float(f"{number:.2g}")


# What there is, in words.


def relation_words(kinds: KindTable) -> list[str]:
    """Who does what about whom, a line each; who ignores another is left out."""
    words = {deed: text for text, deed in DEEDS.items()}
    lines = []
    for (name, other), relation in kinds.relations.items():
        if relation.deed == "ignore" or name == other:
            continue
        lines.append(f"{name} {words[relation.deed]} {other}{details(relation)}")
    return lines


def details(relation: Relation) -> str:
    """The numbers of a relation, in brackets; nothing where it has none."""
    if relation.deed not in ("chase", "flee"):
        return ""
    parts = [f"weight {relation.weight:g}"]
    if relation.radius is not None:
        parts.append(f"within {relation.radius:g}")
    if relation.catch:
        becomes = next(text for text, caught in CAUGHT.items() if caught == relation.caught)
        parts.append(f"catches within {relation.catch:g}: who is caught {becomes}")
    return f" ({', '.join(parts)})"


def describe_kinds(kinds: KindTable, frame: Frame | None) -> str:
    """The kinds with their colours and how many there are now, and their relations, HTML."""
    if not kinds.kinds:
        return f'<div class="fs-quiet">{ONE}</div>'
    entries = []
    for number, (name, colour) in enumerate(
        zip(kinds.names, palette.kind_colours(kinds), strict=True)
    ):
        count = ""
        if frame is not None and frame.kind is not None and frame.kinds.names == kinds.names:
            count = f" <b>{np.count_nonzero(frame.kind == number)}</b>"
        own = kinds.with_model.get(number)
        by = "" if own is None else f", by {html.escape(own.model)}"
        entries.append((f"{html.escape(name)}{count}{by}", palette.css(colour)))
    lines = "".join(f"<div>{html.escape(line)}</div>" for line in relation_words(kinds))
    return f'{key(entries, drawn=True)}<div class="fs-quiet">{lines}</div>'


class KindsPanel:
    """A folder below the parameters, closed at first: the kinds, and what one does about another.

    Another kind, or another number of one, begins the run anew; all else acts at once.
    """

    def __init__(self, gui: viser.GuiApi, simulation: Simulation, parameters: ParametersPanel):
        self.gui, self.simulation, self.parameters = gui, simulation, parameters
        self.lock = threading.Lock()
        """Held while sliders are made or followed: browsers choose others on viser's thread."""
        self.shown: tuple[Any, ...] = ()
        """Of what the sliders are."""
        self.run = -1
        self.of = ""
        """The kind whose relation is shown."""
        self.sliders: dict[str, Any] = {}
        self.followed: dict[str, FollowedValue] = {}
        self.own: dict[str, NumberParameter] = {}
        self.folder = gui.add_folder(TITLE, expand_by_default=simulation.played is not None)
        with self.folder:
            self.dials = Dials(gui)
            self.listed = gui.add_html("")
            self.predator = gui.add_button(
                "Add a predator",
                icon=viser.Icon.FISH,
                color="gray",
                hint="A few agents that are a bit faster, chase the flock and catch it. The run "
                "begins anew",
            )
            self.of_kind = gui.add_folder(None, visible=False)
            with self.of_kind:
                self.which = gui.add_dropdown("Kind", ("",), hint="Whose controls are below")
                self.number = gui.add_number(
                    "Agents of it",
                    1,
                    min=0,
                    max=MOST_OF_A_KIND,
                    step=1,
                    hint="Another number begins the run anew",
                )
                self.colour = gui.add_dropdown(
                    "Colour", tuple(COLOURS), hint="Its colour in the picture"
                )
                self.deed = gui.add_dropdown("It", tuple(DEEDS), hint="What it does about others")
                self.other = gui.add_dropdown("Whom", ("",), hint="About whom it does so")
                self.place = gui.add_folder(None)
                self.caught = gui.add_dropdown(
                    "Who is caught", tuple(CAUGHT), hint="What becomes of who is caught"
                )
                self.parameter = gui.add_dropdown(
                    "Parameter", ("",), hint="A number that this kind has as its own"
                )
                self.own_place = gui.add_folder(None)
                self.remove = gui.add_button(
                    "Remove this kind",
                    icon=viser.Icon.TRASH,
                    color="gray",
                    hint="The run begins anew without it",
                )
            self.form = gui.add_folder("Another kind", expand_by_default=False)
            with self.form:
                self.new_name = gui.add_text(
                    "Name of the kind", "shark", hint="Letters, digits, - and _"
                )
                self.new_number = gui.add_number(
                    "Agents", 2, min=1, max=MOST_OF_A_KIND, step=1, hint="How many of it"
                )
                self.new_model = gui.add_dropdown(
                    "Goes by",
                    (FLOCK_MODEL,),
                    hint="The model that moves it: the flock's, or another one whose ticks and "
                    "units are the same",
                )
                self.new_colour = gui.add_dropdown("Colour", tuple(COLOURS))
                self.new_deed = gui.add_dropdown("It", tuple(DEEDS))
                self.new_other = gui.add_dropdown("Whom", (ORDINARY,))
                self.new_steered = gui.add_checkbox(
                    "Steered by hand",
                    False,
                    hint="Click one of its agents, then Steer this agent; else it follows its rule",
                )
                self.add = gui.add_button(
                    "Add this kind",
                    icon=viser.Icon.PLUS,
                    color="gray",
                    hint="The run begins anew with it",
                )
        self.predator.on_click(self.add_predator)
        self.add.on_click(self.add_kind)
        self.remove.on_click(self.remove_kind)
        self.number.on_update(self.change_number)
        self.colour.on_update(self.change_colour)
        self.deed.on_update(self.change_deed)
        self.caught.on_update(self.change_caught)
        for control in (self.which, self.other, self.parameter):
            control.on_update(self.choose)

    # What browsers ask for.

    async def add_predator(self, event: viser.GuiEvent) -> None:
        """Add one that suits the flock."""
        frame = self.simulation.frame
        if event.client is not None and frame is not None:
            self.try_to(lambda: self.begin_with(predator(self.simulation.state, frame)))

    async def add_kind(self, event: viser.GuiEvent) -> None:
        """Add the kind of the form."""
        if event.client is not None:
            self.try_to(lambda: self.begin_with(self.new_kind()))

    async def remove_kind(self, event: viser.GuiEvent) -> None:
        """Begin anew without the chosen kind."""
        if event.client is not None and self.which.value in self.kinds.names[1:]:
            self.begin(self.kinds.without(self.which.value))

    async def change_number(self, event: viser.GuiEvent) -> None:
        """Begin anew with another number of the chosen kind."""
        kinds, name = self.kinds, self.which.value
        if event.client is not None and name in kinds.names[1:]:
            number = int(self.number.value)
            if number != kinds.kind(name).agents:
                self.begin(kinds.with_kind(replace_kind(kinds.kind(name), agents=number)))

    async def change_colour(self, event: viser.GuiEvent) -> None:
        """Draw the chosen kind in another colour."""
        if event.client is not None and self.which.value in self.kinds.names[1:]:
            chosen = self.colour.value
            self.simulation.paint_kind(self.which.value, COLOURS.get(chosen, chosen))

    async def change_deed(self, event: viser.GuiEvent) -> None:
        """Have the chosen kind do something else about the other one."""
        if event.client is not None:
            self.alter("deed", DEEDS[self.deed.value])

    async def change_caught(self, event: viser.GuiEvent) -> None:
        """Have something else become of who is caught."""
        if event.client is not None:
            self.alter("caught", CAUGHT[self.caught.value])

    async def choose(self, event: viser.GuiEvent) -> None:
        """Show another kind, what it does about another one, or another parameter."""
        if event.client is not None:
            with self.lock:
                self.follow(self.simulation.state)

    @property
    def axes(self) -> dict[str, Any]:
        """The sliders by the names of the axes that a study has over their numbers."""
        kind, other, parameter = self.which.value, self.other.value, self.parameter.value
        own = self.own[parameter].name if parameter in self.own else ""
        return {
            f"{kind}.{own}" if name == "own" else f"{kind}.{other}.{name}": slider
            for name, slider in self.sliders.items()
        }

    def try_to(self, act: Callable[[], None]) -> None:
        """Do something; tell what is refused."""
        try:
            act()
        except InputError as refusal:
            self.simulation.notices.put(str(refusal))

    @property
    def kinds(self) -> KindTable:
        """Those of the flock."""
        return self.simulation.state.kinds

    def new_kind(self) -> Kind:
        """The kind of the form, which sees as far as a predator would. Raises InputError."""
        deed, other = DEEDS[self.new_deed.value], self.new_other.value
        relation = Relation(deed)
        frame, state = self.simulation.frame, self.simulation.state
        if frame is not None and deed in ("chase", "flee"):
            usual = predator(state, frame).to[ORDINARY]
            catch = usual.catch if deed == "chase" else 0.0
            relation = Relation(deed, usual.weight, usual.radius, catch=catch)
        chosen = self.new_model.value
        return Kind(
            self.new_name.value.strip(),
            int(self.new_number.value),
            colour=COLOURS[self.new_colour.value],
            to={other: relation},
            model="" if chosen == FLOCK_MODEL else chosen,
            steered=self.new_steered.value,
        )

    def begin_with(self, kind: Kind) -> None:
        """Begin anew with one more kind, and choose it. Raises InputError."""
        kinds = self.kinds
        if kind.name in kinds.names:
            raise InputError(f"two kinds are called {kind.name}: give another name")
        self.begin(kind_table((*kinds.kinds, kind), kinds.to))

    def begin(self, kinds: KindTable) -> None:
        """Begin the run anew with these kinds, from the same seed: the others start where they
        did."""
        spec, beside = self.simulation.state.current_specs()
        self.simulation.setup(spec.with_values(kinds=kinds.kinds, to=kinds.to), beside)

    def alter(self, name: str, value: Any) -> Future:
        """Change one thing of what the chosen kind does about the other one; it can be undone."""
        kind, other = self.which.value, self.other.value
        relation = self.kinds.of(kind, other)
        before = getattr(relation, name)

        def put_back(value: Any) -> None:
            if {kind, other} <= set(self.kinds.names):
                self.simulation.relate(kind, other, name, value)
                if value == "chase":  # it catches no more since it does something else
                    self.simulation.relate(kind, other, "catch", relation.catch)

        step = f"{name} of {kind} to {other}"
        self.parameters.remember(Step(step, False, before, time.monotonic(), put_back))
        return self.simulation.relate(kind, other, name, value)

    def set_own(self, kind: str, name: str, value: Any) -> Future:
        """Give the chosen kind a number of its own; it can be undone."""
        before = self.kinds.kind(kind).parameters.get(name)

        def put_back(value: Any) -> None:
            if kind in self.kinds.names:
                self.simulation.set_kind(kind, name, value)

        step = f"{name} of {kind}"
        self.parameters.remember(Step(step, False, before, time.monotonic(), put_back))
        return self.simulation.set_kind(kind, name, value)

    # What the page shows.

    def refresh(self, state: SimulationState, frame: Frame | None) -> None:
        """Follow the flock: which kinds there are, and what they do."""
        if not state.values:
            return
        set_visible(self.folder, state.spec.model not in PLAYED)
        played = self.simulation.played
        told = describe_kinds(state.kinds, frame)
        if played is not None:
            told = f"<b>You are: {html.escape(played.name)}</b>{told}"
        if state.beside is not None and state.kinds.kinds:
            told += f'<div class="fs-quiet">{OF_FIRST}</div>'
        content = block(told)
        if content != self.listed.content:
            self.listed.content = content
        count = len(state.kinds.kinds)
        label = f"{TITLE}: {count + 1}" if count else TITLE
        if self.folder.label != label:
            self.folder.label = label
        with self.lock:
            self.follow(state)

    def follow(self, state: SimulationState) -> None:
        """The same of the controls, while nobody else changes them."""
        kinds = state.kinds
        if state.run != self.run:
            self.offer(state)
        set_visible(self.of_kind, bool(kinds.kinds))
        played = self.simulation.played
        for control in (self.predator, self.form, self.which):
            set_visible(control, played is None)
        if played is not None and played.name in kinds.names:
            self.show(self.which, played.name)
        if not kinds.kinds or self.which.value not in kinds.names:
            return
        name = self.which.value
        others = tuple(other for other in kinds.names if other != name)
        if tuple(self.other.options) != others:
            self.other.options = others
        if self.other.value not in others or name != self.of:
            self.of = name
            related = [other for other in others if kinds.of(name, other).deed != "ignore"]
            if self.other.value not in related:
                set_value(self.other, (related or list(others))[0])
        self.offer_parameters(state)
        relation = kinds.of(name, self.other.value)
        is_own = name != ORDINARY
        for control in (self.parameter, self.own_place):
            set_visible(control, is_own)
        for free in (self.number, self.colour, self.remove):
            set_visible(free, is_own and played is None)
        set_visible(self.deed, played is None)
        set_visible(self.place, relation.deed in ("chase", "flee"))
        catches = relation.deed == "chase" and relation.catch > 0.0
        set_visible(self.caught, catches and played is None)
        self.show(self.deed, next(text for text, deed in DEEDS.items() if deed == relation.deed))
        becomes = next(text for text, caught in CAUGHT.items() if caught == relation.caught)
        self.show(self.caught, becomes)
        if is_own:
            colour = kinds.kind(name).colour
            text = next((text for text, css in COLOURS.items() if css == colour), colour)
            if text not in self.colour.options:
                self.colour.options = (*COLOURS, text)
            self.show(self.colour, text)
        shown = state.run, name, self.other.value, relation.deed, self.parameter.value
        if shown != self.shown:
            self.shown = shown
            self.make_sliders(state, relation)
        for key_, followed in self.followed.items():
            followed.follow(self.value_of(state, key_))
        fixed = state.line is not None and (bool(state.line.recording) or state.line.looks_back)
        acting = (self.deed, self.caught, self.colour, *self.sliders.values())
        for control in acting:
            if control.disabled != fixed:
                control.disabled = fixed
        self.dials.refresh()

    @staticmethod
    def show(control: Any, value: Any) -> None:
        """Have a control show what the flock has."""
        if control.value != value:
            set_value(control, value)

    def offer(self, state: SimulationState) -> None:
        """Offer the kinds of another run; the newest is chosen where the chosen one is gone."""
        self.run = state.run
        names, before = state.kinds.names, tuple(self.which.options)
        if before != names:
            chosen = self.which.value
            self.which.options = names
            is_more = bool(set(names) - set(before))
            if is_more or chosen not in names:
                set_value(self.which, names[-1])
            self.new_other.options = names
            self.show(self.new_other, ORDINARY)
        models = FLOCK_MODEL, *self.models_for(state)
        if tuple(self.new_model.options) != models:
            self.new_model.options = models
            self.show(self.new_model, FLOCK_MODEL)
        if self.which.value in names[1:]:
            self.show(self.number, state.kinds.kind(self.which.value).agents)

    @staticmethod
    def models_for(state: SimulationState) -> tuple[str, ...]:
        """The models that a kind of this run may have of its own."""
        model = MODELS[state.spec.model]
        if model.name in PLAYED:
            return ()
        shared, _ = split_individuals(state.values)
        parameters = checked(model.parameters, shared)
        return fitting_models(model, parameters, state.spec, state.spec.dim)

    def offer_parameters(self, state: SimulationState) -> None:
        """Offer the parameters of the model that the chosen kind goes by."""
        own = next((one for one in state.kinds.kinds if one.name == self.which.value), None)
        model = MODELS[state.spec.model if own is None or not own.model else own.model]
        self.own = {} if model.name in PLAYED else own_parameters(model)
        if tuple(self.parameter.options) != (tuple(self.own) or ("",)):
            self.parameter.options = tuple(self.own) or ("",)
            speeds = [label for label, one in self.own.items() if one.words in SPEEDS]
            set_value(self.parameter, (speeds or list(self.own) or [""])[0])

    def value_of(self, state: SimulationState, name: str) -> float:
        """What a slider shows: of a relation, or a parameter that the kind has as its own."""
        kind, kinds = self.which.value, state.kinds
        if kind not in kinds.names or self.other.value not in kinds.names:
            return self.sliders[name].value
        if name in ("weight", "catch"):
            return float(getattr(kinds.of(kind, self.other.value), name))
        if name == "radius":
            radius, frame = kinds.of(kind, self.other.value).radius, self.simulation.frame
            return (1.0 if frame is None else frame.reach) if radius is None else float(radius)
        one = self.own[self.parameter.value]
        chosen = kinds.kind(kind)
        value = chosen.parameters.get(one.name)
        if value is None or (isinstance(value, Distribution) and value.is_by_hand):
            value = one.default if chosen.model else state.values[one.name]
        return centre(value)

    def make_sliders(self, state: SimulationState, relation: Relation) -> None:
        """Make the sliders of what is chosen in place of those before."""
        for slider in self.sliders.values():
            slider.remove()
        self.sliders, self.followed = {}, {}
        self.dials.clear()
        names = {"chase": ("weight", "radius", "catch"), "flee": ("weight", "radius")}
        frame = self.simulation.frame
        side = 1.0 if frame is None else float(max(frame.size))
        with self.place:
            for name in names.get(relation.deed, ()):
                value = self.value_of(state, name)
                self.add_slider(name, relation_parameter(name, value, side), value)
        if self.which.value != ORDINARY and self.parameter.value in self.own:
            with self.own_place:
                one = self.own[self.parameter.value]
                self.add_slider("own", one, self.value_of(state, "own"))

    def add_slider(self, name: str, parameter: NumberParameter, value: float) -> None:
        """A slider that acts at once, and follows the flock."""
        slider = add_control(self.gui, parameter, value)
        kind = self.which.value

        def send(value: Any, _event: viser.GuiEvent) -> Future:
            if name == "own":
                return self.set_own(kind, parameter.name, value)
            return self.alter(name, value)

        self.sliders[name] = slider
        self.dials.add(parameter, slider)
        self.followed[name] = FollowedValue(
            slider, send, lambda: self.value_of(self.simulation.state, name)
        )
