"""Writes `agents/flock_words.py`: the words that `Flock` and `Spec` take, with their types.

    uv run python packing/flock_words.py

Editors complete these words, and type checkers find a wrong one or a wrong value, before anything
runs. They follow from what options, rules and bodies declare; run this when one of those changes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any, get_args

sys.path.insert(0, str(Path(__file__).parents[1]))

from agents.catalogue import BUILT_IN
from agents.models.declare import DeclaredParameter, declared
from agents.spec import OPTIONS, Spec

FILE = Path(__file__).parents[1] / "agents" / "flock_words.py"
HEAD = '''"""The words of `Flock` and `Spec` with their types, written by `packing/flock_words.py`.

A model of a file of your own has parameters that stand here not: give them as
`Flock(Spec("mine", parameters={"pull": 0.5}))`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypedDict

import numpy as np

from agents.individuals import Distribution
from worlds.world import World

Number = float | Distribution | Sequence[float] | np.ndarray
"""A number of all agents, or what gives each agent its own."""
'''
TYPES = {"size": "float | Sequence[float]", "world": "str | World", "dim": "Literal[2, 3]"}
"""Of options that take more than one kind of value."""


def option_type(name: str) -> str:
    """The type of an option."""
    choices = [one for one in get_args(Spec.model_fields[name].annotation) if isinstance(one, str)]
    if choices:
        return f"Literal[{', '.join(map(quoted, choices))}]"
    return TYPES.get(name, OPTIONS[name].kind.__name__)


def parameter_type(several: list[DeclaredParameter], annotations: set[Any]) -> str:
    """The type of a parameter, which several models may have."""
    choices = dict.fromkeys(choice for one in several for choice in one.choices)
    kinds = [f"Literal[{', '.join(map(quoted, choices))}]"] if choices else []
    if any(one.kind == "switch" for one in several):
        kinds.append("bool")
    if any(one.kind == "number" for one in several):
        kinds.append("int" if annotations == {int} else "Number")
    return " | ".join(kinds)


def quoted(text: str) -> str:
    """A text as Python has it, in double quotes."""
    return '"' + text + '"'


def text() -> str:
    """The file."""
    models = [one.parameters for one in BUILT_IN]
    names = dict.fromkeys(one.name for model in models for one in declared(model))
    lines = []
    for name in sorted(names, key=str.lower):
        having = [model for model in models if name in model.model_fields]
        several = [one for model in having for one in declared(model) if one.name == name]
        annotations = {model.model_fields[name].annotation for model in having}
        lines.append(f"    {name}: {parameter_type(several, annotations)}")
    options = [f"    {name}: {option_type(name)} | None" for name in OPTIONS]
    return "\n".join(
        [
            HEAD,
            "",
            "class ParameterWords(TypedDict, total=False):",
            '    """Parameters of rules and bodies, of all models."""',
            "",
            *lines,
            "",
            "",
            "class OptionWords(TypedDict, total=False):",
            '    """Options of a run; None is as the model, or its world, has it."""',
            "",
            *options,
            "",
            "",
            "class FlockWords(OptionWords, ParameterWords, total=False):",
            '    """All that `Flock` takes beside a model and how to run it."""',
            "",
            "",
            "class SpecWords(OptionWords, total=False):",
            '    """All that `Spec` takes beside a model."""',
            "",
            '    start: Literal["random", "given"]',
            "    parameters: Mapping[str, Any]",
            "    layout: Mapping[str, Any] | None",
            "    versions: Mapping[str, str]",
            "",
        ]
    )


if __name__ == "__main__":
    FILE.write_text(text())
    print(FILE.name, len(text().splitlines()), "lines")
