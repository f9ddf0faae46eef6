"""The flock that a command line asks for: a spec file, options over it, `--set` over both."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.experiments.lines import place
from app.settings import assignment
from worlds.reading import read_text, toml
from worlds.refusal import Refusal, shortened, unknown

if TYPE_CHECKING:
    from agents import Flock
    from worlds.world import World

KEYS = ("model", "agents", "informed", "seed", "world", "size", "activation", "noise", "spacing")
"""Keys of a spec that an option can override."""
NAMES = ("model", "world", "activation", "noise")
"""Those whose values are names."""
TABLES = ("layout", "parameters", "versions")
"""Tables of a spec; `layout` is its world, where that is none of the built-in ones."""


@dataclass
class Request:
    """A run as it is asked for; every value with where it came from."""

    values: dict[str, Any] = field(default_factory=dict)
    parameters: dict[str, Any] = field(default_factory=dict)
    origins: dict[str, str] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)
    layout: dict[str, Any] | None = None
    """The world that a spec carries with it."""

    def read_spec(self, path: Path) -> None:
        """Take the values of a spec file, whole or in part. Raises Refusal naming file and line."""
        text = read_text(repr(str(path)), path)
        given = toml(text, str(path))
        for key in given:
            if key not in (*KEYS, "start", *TABLES):
                raise unknown("key", key, (*KEYS, *TABLES), place(path, text, key))
        if given.pop("start", "random") != "random":
            raise Refusal(
                "start = 'given': a run from given arrays goes on only from its saved state, with "
                f"--state ({place(path, text, 'start')})"
            )
        self.versions = table(given, "versions", path, text)
        parameters = table(given, "parameters", path, text)
        for name in parameters:
            self.origins[name] = place(path, text, name, "parameters")
        self.parameters.update(parameters)
        self.layout = given.pop("layout", None)
        self.origins["layout"] = f"layout in {path}"
        for key, value in given.items():
            self.values[key] = value
            self.origins[key] = place(path, text, key)

    def take_options(self, options: dict[str, Any]) -> None:
        """Take the options that are given (not None); they win over a spec."""
        for key, value in options.items():
            if value is not None:
                self.values[key] = value
                self.origins[key] = f"--{key}" if key != "model" else "MODEL"
        if options.get("world") is not None:
            self.layout = None

    def take_settings(self, settings: list[str]) -> None:
        """Take `--set NAME=VALUE`; they win over all. Raises Refusal."""
        for setting in settings:
            name, value = assignment(setting)
            self.parameters[name] = value
            self.origins[name] = f"--set {name}"

    def build(self, threads: int, interpret: bool = False) -> Flock:
        """The flock at its first tick. Raises Refusal naming what is wrong and where it stands."""
        from agents import Flock
        from agents.catalogue import model as find_model

        given = dict(self.values)
        for key in NAMES:
            if key in given and not isinstance(given[key], str):
                raise Refusal(
                    f"{key} = {shortened(given[key])} is not a name ({self.origins[key]})"
                )
        size = given.get("size")
        if isinstance(size, list | tuple) and "dim" not in given and len(size) > 1:
            given["dim"] = len(size)
        if "seed" in given:
            given["rng"] = given.pop("seed")
        try:
            model = find_model(given["model"])
            self.check_parameters(model.parameters)
            if self.layout is not None:
                given["world"] = self.own_world(given.pop("dim", None), given.pop("size", None))
            return Flock(threads=threads, interpret=interpret, **given, **self.parameters)
        except Refusal as refusal:
            raise self.located(refusal) from None

    def own_world(self, dim: int | None, size: Any) -> World:
        """The world that the spec carries with it. Raises Refusal naming the spec."""
        from worlds.checks import demand_sound
        from worlds.layout import world_from_layout

        if not isinstance(self.layout, dict):
            raise Refusal(
                f"layout = {shortened(self.layout)} is not a table ({self.origins['layout']})"
            )
        name = self.values.get("world", "layout")
        try:
            made = world_from_layout(self.layout, name, dim, size)
            demand_sound(made)
        except Refusal as refusal:
            raise Refusal(f"{refusal} ({self.origins['layout']})") from None
        return made

    def check_parameters(self, model: Any) -> None:
        """Refuse a parameter with its origin. Raises Refusal."""
        from agents.models.declare import checked

        for name, value in self.parameters.items():
            checked(model, {name: value}, self.origins[name])

    def located(self, refusal: Refusal) -> Refusal:
        """The refusal with the origin of the value that it names."""
        text = str(refusal)
        words = text.split()
        key = words[1] if words[0] == "unknown" else words[0]
        if key == "dim" and key not in self.origins:
            key = "world"
        origin = self.origins.get(key, "")
        return Refusal(f"{text} ({origin})") if origin and origin not in text else refusal


def table(given: dict[str, Any], key: str, path: Path, text: str) -> dict[str, Any]:
    """Take a table of values out of a spec. Raises Refusal if it is none."""
    values = given.pop(key, {})
    if not isinstance(values, dict) or any(isinstance(v, dict | list) for v in values.values()):
        raise Refusal(f"{key} is not a table of single values ({place(path, text, key)})")
    return values
