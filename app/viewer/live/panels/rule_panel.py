"""The rule that drives the cars, and a control for every parameter that may be changed."""

from __future__ import annotations

import html
from concurrent.futures import Future
from typing import Any

import viser

from agents.models.declare import DeclaredParameter, declared
from agents.models.model import Model
from app.front.controls import set_value
from app.live.operating.flock_driver import NOT_SIMULATED
from app.viewer.live.panels.state_panel import describe_client
from app.viewer.live.session import Session
from app.viewer.live.session_requests import SessionState
from app.viewer.panels.dials import Dials
from app.viewer.panels.followed_value import FollowedValue
from app.viewer.panels.parameters import add_control, sides
from app.viewer.panels.shell import block

CHOOSING = (
    "What drives the cars: another one can be chosen while they are not armed, and the room is "
    "then opened again."
)


class RulePanel:
    """Sliders, switches and choices that act on the running loop; the rule only while not armed."""

    def __init__(self, gui: viser.GuiApi, session: Session, rules: tuple[str, ...]):
        self.gui = gui
        self.session = session
        self.rule = gui.add_dropdown(
            "Rule",
            rules,
            initial_value=session.state.rule,
            hint=CHOOSING,
        )
        self.rule.on_update(self.choose_rule)
        self.about = gui.add_html("", visible=False)
        self.dials = Dials(gui)
        self.folder = gui.add_folder(None)
        self.controls: dict[str, Any] = {}
        self.shown: tuple[int, str] = (-1, "")
        """The opening and the model whose controls there are."""
        self.followed: dict[str, FollowedValue] = {}
        """What keeps each control at the loop's value."""

    async def choose_rule(self, event: viser.GuiEvent) -> None:
        if event.client is not None and self.rule.value != self.session.state.rule:
            self.session.choose(rule=self.rule.value, cause=describe_client(event))

    def refresh(self, state: SessionState, armed: bool) -> None:
        """Follow the session: other controls for another rule, values as the loop has them."""
        self.rule.disabled = armed
        if state.phase != "opening" and not armed and self.rule.value != state.rule:
            set_value(self.rule, state.rule)
        is_now = state.phase != "replay"  # what the rule of the room is set to is not what was then
        if self.folder.visible != is_now:
            self.folder.visible = is_now
        if state.model is None:
            return
        if self.shown != (state.run, state.model.name):
            self.shown = state.run, state.model.name
            self.rebuild(state, state.model)
        for name, followed in self.followed.items():
            if name in state.values:
                followed.follow(state.values[name])
        self.dials.refresh()

    def rebuild(self, state: SessionState, model: Model) -> None:
        """Controls for what of a model's parameters may be changed in a real room."""
        for child in tuple(self.folder._children.values()):
            child.remove()
        self.dials.clear()
        own = [
            parameter
            for parameter in declared(model.parameters)
            if parameter.name not in NOT_SIMULATED and parameter.name in state.values
        ]
        summary = model.rule.summary
        self.rule.hint = f"{summary} {CHOOSING}"
        self.about.visible = True
        first = html.escape(f"{summary.partition('. ')[0].rstrip('.')}.")
        self.about.content = block(f'<div class="fs-quiet">{first}</div>')
        titles = "Rule", f"Body: {model.body.title}"
        self.controls, self.followed = {}, {}
        with self.folder:
            for title, part in zip(titles, sides(model, own), strict=True):
                if part:
                    self.gui.add_html(block(f'<h2 class="fs-head">{html.escape(title)}</h2>'))
                for parameter in part:
                    self.controls[parameter.name] = self.control(
                        parameter, state.values[parameter.name]
                    )

    def control(self, parameter: DeclaredParameter, value: Any) -> Any:
        """The control of one parameter; it goes back to what the loop has if that refuses."""
        handle = add_control(self.gui, parameter, value)
        self.dials.add(parameter, handle)

        def send(value: Any, event: viser.GuiEvent) -> Future:
            return self.session.set_parameter(parameter.name, value, describe_client(event))

        def now() -> Any:
            return self.session.state.values.get(parameter.name, value)

        self.followed[parameter.name] = FollowedValue(handle, send, now)
        return handle
