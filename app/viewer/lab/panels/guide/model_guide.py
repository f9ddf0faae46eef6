"""The guide: what this model is, what to try, which keys there are."""

from __future__ import annotations

import html

import viser

from agents.catalogue import MODELS
from agents.models.declare import declared
from app.viewer.lab.panels.guide.try_runner import TryRunner
from app.viewer.panels.hotkeys import KEYS, OWN_KEYS
from app.viewer.panels.notation import equation_svg
from app.viewer.panels.parameters import worded
from app.viewer.panels.style import CSS, block


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
                gui.add_html(page(about(model_name)))
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


def about(model_name: str) -> str:
    """What the model is: summary, equation, where the rule and the body are from."""
    model = MODELS[model_name]
    rule, body = model.rule, model.body
    lines = rule.equation.split(r"\qquad")
    drawn = "".join(
        f'<div style="padding:6px 0">{svg or f"<code>{html.escape(line)}</code>"}</div>'
        for svg, line in zip(equation_svg(rule.equation), lines, strict=False)
    )
    return (
        f"<p>{html.escape(model.summary)}</p>{drawn}"
        f'<p class="fs-quiet">Rule: {html.escape(rule.source)}.<br>'
        f"Body: {html.escape(f'{body.title} ({body.source})')}.</p>"
    )


def parameters(model_name: str) -> str:
    """A table of the model's parameters."""
    rows = "".join(
        "<tr><td><b>{}</b></td><td style='text-align:left'>{}</td></tr>".format(
            *map(html.escape, worded(one))
        )
        for one in declared(MODELS[model_name].parameters)
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
