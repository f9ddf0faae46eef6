"""The guide: what this model is, what to try, which keys there are."""

from __future__ import annotations

import html
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import viser

from agents.catalogue import MODELS
from agents.flock_world import complete_spec
from agents.models.declare import declared
from agents.models.model import Model
from agents.models.tries import LessonStep, format_short
from agents.spec import OPTIONS
from app.viewer.lab.panels.setup import SetupPanel, default_value
from app.viewer.panels.dials import equation_svg
from app.viewer.panels.parameters import ParametersPanel, parameter_label
from app.viewer.panels.shell import CSS, KEYS, OWN_KEYS, block
from app.viewer.run.run_preset import world_title
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_state import SimulationState
from worlds.number_text import counted

# What there is to try with the running model: a button for each does it, and takes it back.

DO, BACK = "Do it", "Take it back"


@dataclass
class TryRunner:
    """Does what a model proposes to try, to the one flock that all browsers see."""

    simulation: Simulation
    parameters: ParametersPanel
    setup: SetupPanel

    def __post_init__(self) -> None:
        self.before: dict[tuple[str, str], dict[str, Any]] = {}
        """What a try changed was, by the model's name and what the try is called."""

    def show(self, gui: viser.GuiApi, model_name: str) -> None:
        """Put what there is to try into the container that is open, with a button for each."""
        model = MODELS[model_name]
        state = self.simulation.state
        gui.add_html(
            block(
                '<div class="fs-page fs-short fs-quiet">'
                f"{html.escape(describe_source(model))}</div>"
            )
        )
        for number, step in enumerate(model.to_try, 1):
            gui.add_html(block(lesson(number, step, self.settings(model_name, step))))
            done = state.spec.model == model_name and is_done(state, step)
            button = gui.add_button(BACK if done else DO, color="gray" if done else "green")
            button.on_click(partial(self.toggle_step, model_name, step))
        gui.add_html(block('<div class="fs-gap"></div>'))

    @staticmethod
    def settings(model_name: str, step: LessonStep) -> str:
        """What is set, as sliders and Setup call it."""
        words = {p.name: parameter_label(p)[0] for p in declared(MODELS[model_name].parameters)}
        words |= {name: option.title for name, option in OPTIONS.items()}
        return ", ".join(
            f"{words[name]}: {format_short(value)}" for name, value in step.set.items()
        )

    async def toggle_step(self, model_name: str, step: LessonStep, event: viser.GuiEvent) -> None:
        """Do it, or take it back; of a model that runs no longer, say so."""
        button = event.target
        state = self.simulation.state
        if state.spec.model != model_name or not state.values:
            title = MODELS[model_name].title
            self.simulation.notices.put(f"{title} does not run: open the guide again")
            return
        doing = button.label == DO
        if doing:
            self.apply_step(model_name, step)
        else:
            self.take_back(model_name, step)
        button.label, button.color = (BACK, "gray") if doing else (DO, "green")

    def apply_step(self, model_name: str, step: LessonStep) -> None:
        """Change what the try says, keep what it was, and let the flock run."""
        state = self.simulation.state
        self.before[model_name, step.words] = {
            name: current_value(state, name) for name in step.set
        }
        self.change(step, step.set)

    def take_back(self, model_name: str, step: LessonStep) -> None:
        """Change it to what it was, or to what it is by default."""
        model = MODELS[model_name]
        usual = {
            name: default_value(name, model)
            if name in OPTIONS
            else model.parameters.model_fields[name].default
            for name in step.set
        }
        self.change(step, self.before.pop((model_name, step.words), usual))

    def change(self, step: LessonStep, values: Mapping[str, Any]) -> None:
        """Give parameters and options their values; begin the run again if the try does."""
        if step.anew:
            spec, beside = self.simulation.state.current_specs()
            options = {name: value for name, value in values.items() if name in OPTIONS}
            others = {name: value for name, value in values.items() if name not in OPTIONS}
            changed = spec.with_parameters(spec.all_parameters | others).but(**options)
            spec = complete_spec(changed, MODELS[spec.model])
            self.simulation.setup(spec, beside)
            self.setup.follow(spec, beside)
        else:
            for name, value in values.items():
                self.parameters.remember_value(name, False)
                self.parameters.set_parameter(name, value, False)
        self.simulation.go()


def describe_source(model: Model) -> str:
    """Where what one sees was found."""
    agents = counted(model.agents, "agent")
    return (
        f"Found with {agents} in the model's own world, “{world_title(model.world)}”; "
        "elsewhere it may turn out otherwise. Do it, close the guide, and watch."
    )


def current_value(state: SimulationState, name: str) -> Any:
    """An option or a parameter of the run as it is."""
    return getattr(state.spec, name) if name in OPTIONS else state.values.get(name)


def is_done(state: SimulationState, step: LessonStep) -> bool:
    """Whether all is as the try has it."""
    return all(current_value(state, name) == value for name, value in step.set.items())


def lesson(number: int, step: LessonStep, settings: str) -> str:
    """A try for people: what to do, what is set, what one sees."""
    again = " The run begins again." if step.anew else ""
    return (
        f'<div class="fs-try"><b>{number}. {html.escape(step.words)}</b>'
        f'<div class="fs-quiet">{html.escape(settings)}.{again}</div>'
        f"<div>{html.escape(step.see)}</div></div>"
    )


class Guide:
    """Opens the guide in the browser that asks for it, once at a time."""

    def __init__(self, server: viser.ViserServer, tries: TryRunner) -> None:
        self.tries = tries
        self.open: set[int] = set()
        """Browsers in which it is open."""
        server.on_client_disconnect(self.forget_client)

    async def forget_client(self, client: viser.ClientHandle) -> None:
        """A browser has gone, and its guide with it."""
        self.open.discard(client.client_id)

    def show(self, client: viser.ClientHandle, model_name: str) -> None:
        """Open it, unless it is open."""
        if client.client_id in self.open:
            return
        self.open.add(client.client_id)
        gui = client.gui
        modal = gui.add_modal(f"Guide · {MODELS[model_name].title}")
        with modal:
            gui.add_html(CSS)
            tabs = gui.add_tab_group()
            with tabs.add_tab("Model"):
                gui.add_html(page(describe_model(model_name)))
            if MODELS[model_name].to_try:
                with tabs.add_tab("Try this"):
                    self.tries.show(gui, model_name)
            with tabs.add_tab("Parameters"):
                gui.add_html(page(parameters(model_name)))
            with tabs.add_tab("Keys"):
                gui.add_html(page(keys()))
            done = gui.add_button("Close", icon=viser.Icon.X)

        async def close(_event: viser.GuiEvent) -> None:
            if client.client_id in self.open:
                self.open.discard(client.client_id)
                modal.close()

        done.on_click(close)


def page(content: str) -> str:
    """A tab of the guide; all are equally high, so that nothing jumps."""
    return block(f'<div class="fs-page">{content}</div>')


def describe_model(model_name: str) -> str:
    """What the model is: summary, equation, where the rule and the body are from."""
    model = MODELS[model_name]
    rule, body = model.rule, model.body
    lines = rule.equation.split(r"\qquad")
    rows_html = "".join(
        f'<div style="padding:6px 0">{svg or f"<code>{html.escape(line)}</code>"}</div>'
        for svg, line in zip(equation_svg(rule.equation), lines, strict=False)
    )
    return (
        f"<p>{html.escape(model.summary)}</p>{rows_html}"
        f'<p class="fs-quiet">Rule: {html.escape(rule.source)}.<br>'
        f"Body: {html.escape(f'{body.title} ({body.source})')}.</p>"
    )


def parameters(model_name: str) -> str:
    """A table of the model's parameters."""
    rows = "".join(
        "<tr><td><b>{}</b></td><td style='text-align:left'>{}</td></tr>".format(
            *map(html.escape, parameter_label(parameter))
        )
        for parameter in declared(MODELS[model_name].parameters)
    )
    return f'<table class="fs-table">{rows}</table>'


def keys() -> str:
    """A table of the hotkeys."""
    rows = "".join(
        f"<tr><td><kbd>{key.replace('page', 'page ')}</kbd></td>"
        f'<td style="text-align:left">{words}</td></tr>'
        for key, words in (KEYS | OWN_KEYS).items()
    )
    return f'<table class="fs-table">{rows}</table>'
