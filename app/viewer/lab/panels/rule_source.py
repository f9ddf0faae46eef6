"""Below the sliders: equation, source and code of the model's rule, to read only."""

from __future__ import annotations

import html
import inspect
import time
from pathlib import Path
from textwrap import dedent

import viser

from agents.catalogue import FILES, MODELS
from agents.models.declare import Rule
from agents.models.model_calls import declared_functions
from app.viewer.lab.panels.model_guide import describe_model
from app.viewer.panels.shell import block

MOST_CODE = 40_000
"""Characters of code that a page is sent."""


class RuleSource:
    """What the rule is; of a file that is watched also when it was read, and what is wrong."""

    def __init__(self, gui: viser.GuiApi):
        self.fault = gui.add_html("", visible=False)
        self.place: viser.GuiHtmlHandle | None = None
        self.shown: object = None
        self.read: dict[Path, str] = {}
        """When a file was taken since the page began."""

    def add(self, gui: viser.GuiApi) -> None:
        """Equation, source and code stand here; what is wrong where this was made."""
        self.place = gui.add_html("")

    def take(self, path: Path) -> None:
        """A file was read anew, and nothing is wrong with it."""
        self.read[path] = time.strftime("%H:%M:%S")
        self.fault.visible = False
        self.shown = None

    def refuse(self, why: str) -> None:
        """A file has a fault: the rule of before goes on, until it is mended."""
        said = f"<b>Not taken.</b> {html.escape(why)}<br>The flock goes on under the rule before."
        self.fault.content = block(f'<div class="fs-error">{said}</div>')
        self.fault.visible = True

    def refresh(self, model_name: str) -> None:
        """Show the rule of a model, if it is another."""
        rule = MODELS[model_name].rule
        if self.place is not None and self.shown is not rule:
            self.shown = rule
            self.place.content = block(self.describe(model_name, rule))

    def describe(self, model_name: str, rule: Rule) -> str:
        """Equation, source and code, HTML; folded until somebody asks."""
        path = FILES.get(model_name)
        where = "" if path is None else f"<p>{html.escape(path.name)}{self.since(path)}</p>"
        code = html.escape(rule_code(rule))
        return (
            f'<details class="fs-source"><summary>Equation, source and code</summary>{where}'
            f"{describe_model(model_name)}<pre tabindex=0>{code}</pre></details>"
        )

    def since(self, path: Path) -> str:
        """Whether a file is watched, and which of its versions runs."""
        if path in self.read:
            return f", as saved at {self.read[path]}"
        return ": save it, and the flock goes on under what it says"


def rule_code(rule: Rule) -> str:
    """The functions that a rule declares, as they are written; a line above says where.

    >>> rule_code(MODELS["vem"].rule).splitlines()[0].rpartition(" line")[0]
    '# term, agents/rules/vicsek.py,'
    """
    parts, home = [], Path(__file__).parents[4]
    for title, function in declared_functions(rule, "rule"):
        if rule.term is not None and title.endswith(", decide"):
            continue  # it adds up the terms, and answers
        try:
            lines, first = inspect.getsourcelines(function.py_func)
        except (OSError, TypeError):  # typed at a prompt: nobody has written a file
            continue
        file = Path(function.py_func.__code__.co_filename)
        name = file.relative_to(home) if file.is_relative_to(home) else Path(file.name)
        where = f"{title.split(', ')[1]}, {name.as_posix()}, line {first}"
        parts.append(f"# {where}\n{dedent(''.join(lines))}")
    code = "\n".join(dict.fromkeys(parts))
    return code if len(code) <= MOST_CODE else f"{code[:MOST_CODE]}\n# The rest is left out."
