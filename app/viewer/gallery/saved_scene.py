"""A scene that is saved: a run, what is beside it, how it is looked at, and what to look for."""

from __future__ import annotations

import base64
import binascii
import math
import re
import shlex
import tomllib
import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import tomlkit

from agents.catalogue import model as find_model
from agents.individuals import Distribution, split_individuals
from agents.kinds import ALIASES, ALL, Kind, Relation, complete_kinds, kind_table
from agents.models.declare import checked
from agents.models.model import Model
from agents.motion.motion import demand_kinds
from agents.observables.of_agents import own_name
from agents.spec import DEFAULT, OPTIONS, CompleteSpec, Spec
from app.viewer.editing.layout_file import demand_few, demand_small
from app.viewer.gallery.scene_steps import SceneStep, read_steps
from app.viewer.run.run_preset import MOST_AGENTS, preset_spec
from app.viewer.scene.shown.control import Control, controls_of
from app.viewer.scene.shown.drawing_style import CAMERAS, DARTS, DrawingStyle
from worlds.checks import demand_sound
from worlds.input_error import InputError, shorten, unknown
from worlds.layout import layout_names, world_from_layout
from worlds.text_file import toml
from worlds.world import World

TEXTS = {"title": 80, "watch": 400, "try": 400}
"""The words of a scene, and how long each may be."""
KEYS = (*TEXTS, "speed", "camera", "plots", "run", "beside", "look", "steps")
MOST_SIDE = 1000.0
"""Side of a world from a browser, length."""
MOST_PLOTS = 3
LARGEST = 1_000_000
"""Bytes of a scene's file."""
LONGEST_NAME = 200
"""Letters of a plot's name."""
LOOKS = controls_of(DrawingStyle)
"""How each part of a look is chosen."""


@dataclass(frozen=True)
class SavedScene:
    """What opens together. As TOML it has these keys, `look` only where it is not the usual one."""

    title: str
    spec: CompleteSpec
    """The run, with its own parameters; those that it does not name are the model's."""
    beside: Spec | None = None
    """The model beside it, and what it has of its own."""
    watch: str = ""
    """What one should see, in a sentence."""
    tries: str = ""
    """One thing to try."""
    speed: float | None = None
    """Ticks per second; without it, as lively as its body goes."""
    camera: str = ""
    """A preset point of view; empty: the usual one."""
    plots: tuple[str, ...] = ()
    """What is plotted; empty: what the model usually shows."""
    look: Mapping[str, Any] = field(default_factory=dict)
    """What of the look is not as usual, by the name of its control."""
    steps: tuple[SceneStep, ...] = ()
    """What a reader is led through, one after the other; empty: the scene is no lesson of steps."""

    def to_toml(self) -> str:
        """The scene as a file, with all that makes its run the same to the bit."""
        return self.format_toml(tomllib.loads(self.spec.to_toml()))

    def command(self) -> str:
        """The same without what every program of this version adds by itself."""
        values = tomllib.loads(self.spec.to_toml())
        model = find_model(self.spec.model)
        usual = model.parameters().model_dump()
        changed = {k: v for k, v in values.get("parameters", {}).items() if usual.get(k) != v}
        plain = preset_spec(self.spec.model, seed=self.spec.seed).model_dump()
        short_values = {
            key: value
            for key, value in values.items()
            if key in ("model", "seed", "layout")
            or (key not in ("parameters", "versions", "start") and plain.get(key) != value)
        }
        return self.format_toml(short_values | ({"parameters": changed} if changed else {}))

    def format_toml(self, run: Mapping[str, Any]) -> str:
        """The TOML of the scene with these values of its run."""
        words = {"title": self.title, "watch": self.watch, "try": self.tries}
        fields: dict[str, Any] = {key: text for key, text in words.items() if text}
        if self.speed is not None:
            fields["speed"] = self.speed
        if self.camera:
            fields["camera"] = self.camera
        if self.plots:
            fields["plots"] = list(self.plots)
        fields["run"] = dict(run)
        if self.beside is not None:
            own = {name: one.to_value() for name, one in self.beside.individuals.items()}
            parameters = self.beside.parameters | own
            fields["beside"] = {"model": self.beside.model, "parameters": parameters}
        if self.look:
            fields["look"] = dict(self.look)
        if self.steps:
            fields["steps"] = [step.values() for step in self.steps]
        return tomlkit.dumps(fields)

    @classmethod
    def from_toml(cls, text: str, origin: str) -> SavedScene:
        """A scene from TOML, whoever wrote it. Raises InputError naming what is wrong.

        The world is one of the built-in ones or in the text itself, never another file.
        """
        return cls.from_values(toml(text, origin), origin)

    @classmethod
    def from_values(cls, values: Mapping[str, Any], origin: str) -> SavedScene:
        """A scene from the values of a TOML text. Raises InputError naming what is wrong."""
        for key in values:
            if key not in KEYS:
                raise unknown("key", key, KEYS, origin)
        if "run" not in values:
            raise InputError(f"run is missing: which model, in which world ({origin})")
        try:
            words = {key: read_scene_text(values, key) for key in TEXTS}
            spec = read_run(table(values, "run"), origin)
            scene = cls(
                title=words["title"] or find_model(spec.model).title,
                spec=spec,
                beside=read_compared(table(values, "beside"), origin),
                watch=words["watch"],
                tries=words["try"],
                speed=read_speed(values.get("speed")),
                camera=read_camera(values.get("camera", "")),
                plots=read_plots(values.get("plots", [])),
                look=read_look(table(values, "look"), spec),
                steps=read_steps(values.get("steps", []), spec, origin),
            )
        except InputError as refusal:
            message = str(refusal)
            raise InputError(message if origin in message else f"{message} ({origin})") from None
        if scene.steps and scene.beside is not None:
            raise InputError(
                f"steps and beside exclude each other: steps are of one flock ({origin})"
            )
        return scene


def read_scene(name: str, data: bytes) -> SavedScene:
    """The scene of a file, or of a spec. Raises InputError."""
    demand_scene_size(name, data)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{name} is not a text file") from None
    return scene_of(toml(text, name), name)


def demand_scene_size(name: str, data: bytes) -> None:
    """Raise InputError for a file that is too large for a scene."""
    if len(data) > LARGEST:
        raise InputError(f"{name} has {len(data)} bytes: a scene has {LARGEST} at most")


def scene_of(values: Mapping[str, Any], origin: str) -> SavedScene:
    """The scene of the values of a file, or of a spec. Raises InputError."""
    return SavedScene.from_values(values if "run" in values else {"run": values}, origin)


def read_scene_text(values: Mapping[str, Any], key: str) -> str:
    """One of the words of a scene, on one line. Raises InputError."""
    text = values.get(key, "")
    if not isinstance(text, str) or len(text) > TEXTS[key]:
        raise InputError(f"{key} = {shorten(text)} is no text of at most {TEXTS[key]} letters")
    return re.sub(r"\s+", " ", "".join(c for c in text if c.isprintable() or c.isspace())).strip()


def table(values: Mapping[str, Any], key: str) -> dict[str, Any]:
    """One of the tables of a scene, empty if it is not there. Raises InputError."""
    value = values.get(key, {})
    if not isinstance(value, dict):
        raise InputError(f"{key} = {shorten(value)} is not a table")
    return value


def read_run(values: dict[str, Any], origin: str) -> CompleteSpec:
    """The run of a scene, which the laboratory can carry. Raises InputError."""
    own = dict(values)
    layout, parameters = own.pop("layout", None), own.pop("parameters", {})
    spec = Spec.from_values({**own, "parameters": {}}, origin)
    if spec.start != "random":
        raise InputError("start = 'given' is not allowed: such a run begins from its saved state")
    model = find_model(spec.model)
    if isinstance(spec.size, tuple) and len(set(spec.size)) == 1:
        spec = spec.but(size=spec.size[0])
    if isinstance(spec.size, tuple):
        raise InputError(f"size = {list(spec.size)} is not allowed: here all sides are alike")
    if layout is not None:
        spec = spec.but(world=world_of(layout, str(own.get("world", "layout"))), size=None)
    elif spec.world is not None and spec.world not in layout_names():
        raise unknown("world", spec.world, layout_names())
    if not isinstance(parameters, dict):
        raise InputError(f"parameters = {shorten(parameters)} is not a table")
    shared, individuals = split_individuals(parameters)
    checked_parameters = checked(model.parameters, shared, origin)
    model.demand_individual(individuals)
    complete = preset_spec(**{**dict(spec), "parameters": parameters})
    kinds = complete_kinds(model.rule.kinds, spec.kinds, spec.to)
    demand_kinds(model, checked_parameters, kinds, complete, complete.dim)
    demand_bounded(complete)
    return complete


def demand_bounded(spec: CompleteSpec) -> None:
    """Raise InputError for what a panel would not offer either."""
    if spec.agents + spec.count_of_kinds > MOST_AGENTS:
        of_kinds = f" with {spec.count_of_kinds} of kinds" if spec.kinds else ""
        raise InputError(f"agents = {spec.agents}{of_kinds} is not allowed: at most {MOST_AGENTS}")
    if isinstance(spec.size, float) and spec.size > MOST_SIDE:
        raise InputError(f"size = {spec.size:g} is not allowed: at most {MOST_SIDE:g}")
    for name, option in OPTIONS.items():
        value = getattr(spec, name)
        if option.most and isinstance(value, int | float) and value > option.most:
            raise InputError(f"{name} = {value} is not allowed: at most {option.most:g}")


def world_of(layout: Any, name: str) -> World:
    """A world that a scene carries with it. Raises InputError."""
    if not isinstance(layout, dict):
        raise InputError(f"layout = {shorten(layout)} is not a table")
    demand_few(layout, "layout")
    world = world_from_layout(layout, f"{name}-scene" if name in layout_names() else name)
    demand_small(world, "layout")
    demand_sound(world)
    return world


def read_compared(values: dict[str, Any], origin: str) -> Spec | None:
    """The model beside, or None. Raises InputError."""
    if not values:
        return None
    for key in values:
        if key not in ("model", "parameters"):
            raise unknown("key", key, ("model", "parameters"), "beside")
    spec = Spec.from_values(values, origin)
    model = find_model(spec.model)
    checked(model.parameters, spec.parameters, "beside")
    model.demand_individual(spec.individuals)
    return spec


def read_speed(value: Any) -> float | None:
    """Ticks per second, or None. Raises InputError."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, int | float) or not value >= 0.1:
        raise InputError(
            f"speed = {shorten(value)} is not allowed: a number >= 0.1 ticks/s, or inf"
        )
    return float(value)


def read_camera(value: Any) -> str:
    """A preset point of view, or none. Raises InputError."""
    if value and value not in CAMERAS:
        raise unknown("camera", value, CAMERAS)
    return value or ""


def read_plots(value: Any) -> tuple[str, ...]:
    """What is plotted, as the charts call it. Raises InputError."""
    right = isinstance(value, list) and all(isinstance(item, str) for item in value)
    if not right or len(value) > MOST_PLOTS or any(len(item) > LONGEST_NAME for item in value):
        raise InputError(f"plots = {shorten(value)} is no list of at most {MOST_PLOTS} names")
    return tuple(value)


def read_look(values: dict[str, Any], spec: Spec) -> dict[str, Any]:
    """What of the look is not as usual. Raises InputError.

    Files of before have `birds = false` for what is `form = "darts"` now.
    """
    values = dict(values)
    if values.pop("birds", True) is False:
        values.setdefault("form", DARTS)
    for name, value in values.items():
        if name not in LOOKS:
            raise unknown("look", name, LOOKS)
        if name == "colour" and any(is_own_colour(value, find_model(one)) for one in spec.models):
            continue
        demand_offered(name, value, LOOKS[name])
    return values


def is_own_colour(value: Any, model: Model) -> bool:
    """Whether only agents of this model can be coloured by it: what they tell, or their own
    numbers, which stay chosen while all are alike."""
    return value in model.columns or value in map(own_name, model.individual)


def demand_offered(name: str, value: Any, control: Control) -> None:
    """Raise InputError for a value that a control of the look does not have."""
    if control.choices:
        if value not in control.choices:
            raise unknown(f"look {name}", value, control.choices)
    elif control.high:
        right = isinstance(value, int | float) and not isinstance(value, bool)
        if not right or not control.low <= value <= control.high or not math.isfinite(value):
            raise InputError(
                f"look {name} = {shorten(value)} is not in [{control.low:g}, {control.high:g}]"
            )
    elif not isinstance(value, bool):
        raise InputError(f"look {name} = {shorten(value)} is neither true nor false")


# A scene in an address: by its name, or whole, packed so that it fits.

PACKED = "z."
"""Stands before a scene that is there whole."""
LONGEST_ADDRESS = 6000
"""Letters of a packed scene: browsers and servers take addresses of 8 000."""
LARGEST_UNPACKED = 100_000
"""Bytes that it may unpack to."""


def pack_scene(scene: SavedScene) -> str:
    """A scene as a parameter of an address. Raises InputError for one that is too large.

    >>> from agents.spec import Spec
    >>> from app.viewer.run.run_preset import preset_spec
    >>> unpack_scene(pack_scene(SavedScene("mine", preset_spec("vem", agents=30)))).title
    'mine'
    """
    text = zlib.compress(scene.command().encode(), 9)
    packed_text = PACKED + base64.urlsafe_b64encode(text).decode().rstrip("=")
    if len(packed_text) > LONGEST_ADDRESS:
        raise InputError(
            f"the address would have {len(packed_text)} letters, at most {LONGEST_ADDRESS}: "
            "save the scene as a file instead"
        )
    return packed_text


def unpack_scene(text: str) -> SavedScene:
    """The scene of such a parameter, from whomever it comes. Raises InputError."""
    if not text.startswith(PACKED) or len(text) > LONGEST_ADDRESS:
        raise InputError("this address has no scene in it")
    letters = text.removeprefix(PACKED)
    try:
        data = base64.b64decode(letters + "=" * (-len(letters) % 4), altchars="-_", validate=True)
        unpacking = zlib.decompressobj()
        plain = unpacking.decompress(data, LARGEST_UNPACKED)
        if unpacking.unconsumed_tail or not unpacking.eof:
            raise InputError(
                f"the scene of this address is broken, or has over {LARGEST_UNPACKED} bytes"
            )
        words = plain.decode()
    except (binascii.Error, zlib.error, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("the scene of this address is broken") from None
    return SavedScene.from_toml(words, "the address")


# A scene in the words of the command line and of Python.

DRAWN = "its world was changed: save the scene as a file and run"
GIVEN = "agents were given numbers one by one: save the scene as a file and run"


def command_line(scene: SavedScene) -> str:
    """What opens the run from a shell, as far as words can say it.

    >>> command_line(SavedScene("mine", preset_spec("vem", agents=30, parameters={"eta": 0.5})))
    'flockscope lab vem --agents 30 --seed 1 --set eta=0.5'
    """
    spec = scene.spec
    if isinstance(spec.world, World):
        return f"flockscope lab scene.toml  # {DRAWN} this"
    if any(one.kind == "each" for one in spec.individuals.values()):
        return f"flockscope lab scene.toml  # {GIVEN} this"
    words = [spec.model] + ([] if scene.beside is None else ["--beside", scene.beside.model])
    for name, value in options(spec).items():
        words += [f"--{name.replace('_', '-')}", shell_value(value)]
    for side in (spec, scene.beside):
        for name, value in {} if side is None else changed(side):
            words += ["--set", f"{name}={shell_value(value)}"]
    for kind in spec.kinds:
        words += ["--kind", shell_kind(kind)]
    for name, other, relation in declared_relations(spec):
        words += ["--relation", f"{name}:{other}={shell_relation(relation)}"]
    if scene.speed is not None and scene.speed != float("inf"):
        words += ["--speed", shell_value(scene.speed)]
    return shlex.join(["flockscope", "lab", *words])


def python(scene: SavedScene) -> str:
    """A script that makes the run.

    >>> print(python(SavedScene("mine", preset_spec("vem", agents=30))))
    from flockscope import Flock
    <BLANKLINE>
    flock = Flock("vem", agents=30, seed=1)
    flock.run(100)
    """
    spec = scene.spec
    given = any(one.kind == "each" for one in spec.individuals.values())
    if isinstance(spec.world, World) or given:
        code = 'flock = Flock(Spec.read("spec.toml"))\nflock.run(100)'
        why = "agents were given numbers one by one" if given else "its world was changed"
        return f"# {why}: download its spec first\nfrom flockscope import Flock, Spec\n\n{code}"
    values = {**options(spec), **dict(changed(spec))}
    drawn = [*spec.individuals.values(), *(v for kind in spec.kinds for v in distributed(kind))]
    names = ["Flock", *sorted({one.kind for one in drawn})]
    arguments = "".join(f", {name}={python_value(value)}" for name, value in values.items())
    if spec.kinds:
        names.insert(1, "Spec")
        tables = ",\n    ".join(python_kind(kind) for kind in spec.kinds)
        to = {name: relation.to_value() for name, relation in spec.to.items()}
        made = f"kinds=kinds, to={python_table(to)}" if to else "kinds=kinds"
        code = f'spec = Spec("{spec.model}", {made})\nflock = Flock(spec{arguments})'
        code = f"kinds = [\n    {tables},\n]\n{code}"
    else:
        code = f'flock = Flock("{spec.model}"{arguments})'
    return f"from flockscope import {', '.join(names)}\n\n{code}\nflock.run(100)"


def options(spec: Spec) -> dict[str, Any]:
    """The options of a run that are not as its model has them; the seed always."""
    usual = preset_spec(spec.model)
    return {
        name: getattr(spec, name)
        for name in OPTIONS
        if getattr(spec, name) is not None
        and (name == "seed" or getattr(spec, name) != getattr(usual, name))
    }


def changed(spec: Spec) -> list[tuple[str, Any]]:
    """The parameters that are not at their defaults, or differ from agent to agent."""
    usual = find_model(spec.model or DEFAULT).parameters().model_dump()
    values = spec.all_parameters
    return [(name, value) for name, value in values.items() if usual.get(name) != value]


def distributed(kind: Kind) -> list[Distribution]:
    """What the agents of a kind differ by among each other."""
    return [one for one in kind.parameters.values() if isinstance(one, Distribution)]


def declared_relations(spec: Spec) -> list[tuple[str, str, Relation]]:
    """Whom kinds of agents are told to heed and how, kind by kind: all others one by one."""
    table = kind_table(spec.kinds, spec.to)
    told = [(table.names[0], spec.to), *((kind.name, kind.to) for kind in spec.kinds)]
    return [
        (name, other, table.of(name, other))
        for name, to in told
        for other in table.names
        if other in to
        or (other == table.names[0] and ALIASES.keys() & to)
        or (ALL in to and other != name)
    ]


def shell_kind(kind: Kind) -> str:
    """A kind on a command line, without its relations.

    >>> shell_kind(Kind("shark", 2, v0=0.05, start=[[0, 0], [1, 2.5]]))
    'shark=2,v0=0.05,start=0x0..1x2.5'
    """
    parts = [f"{kind.name}={kind.agents}"]
    parts += [f"model={kind.model}"] if kind.model else []
    parts += [f"{name}={shell_value(value)}" for name, value in kind.parameters.items()]
    if kind.colour:
        parts.append(f"colour={kind.colour}")
    if kind.start is not None:
        parts.append("start=" + "..".join("x".join(map(repr_short, one)) for one in kind.start))
    return ",".join(parts)


def repr_short(number: float) -> str:
    """A number so that it comes back to the bit, whole ones without a point."""
    return f"{number:g}" if float(f"{number:g}") == number else repr(number)


def shell_relation(relation: Relation) -> str:
    """A relation on a command line.

    >>> shell_relation(Relation("chase", 2.0, 5.0, catch=0.3)), shell_relation(Relation("ignore"))
    ('chase,weight=2,radius=5,catch=0.3,caught=taken', 'ignore')
    """
    values = relation.to_value()
    deed, weight = next(iter(values.items()))
    if weight is True:
        return deed
    more = {"weight": float(weight), **{key: one for key, one in values.items() if key != deed}}
    return ",".join([deed, *(f"{key}={shell_value(value)}" for key, value in more.items())])


def python_kind(kind: Kind) -> str:
    """A kind in a script, as a spec has it."""
    values = kind.to_value()
    if kind.parameters:
        values["parameters"] = kind.parameters
    return python_table(values)


def python_table(values: Mapping[str, Any]) -> str:
    """A table in a script, with double quotes as black has them."""
    parts = (
        f'"{key}": {python_table(one) if isinstance(one, Mapping) else python_value(one)}'
        for key, one in values.items()
    )
    return f"{{{', '.join(parts)}}}"


def shell_value(value: Any) -> str:
    """A value on a command line."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, Distribution):
        return ":".join([value.kind, *map(shell_value, value.numbers)])
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def python_value(value: Any) -> str:
    """A value in a script."""
    if isinstance(value, Distribution):
        return f"{value.kind}({', '.join(map(repr, value.numbers))})"
    return f'"{value}"' if isinstance(value, str) else repr(value)
