"""The run that a command line asks for: a file of any kind, options over it, `--set` over both."""

from __future__ import annotations

import inspect
import os
import re
import tomllib
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from agents.catalogue import MODELS
from agents.catalogue import model as find_model
from agents.kinds import (
    DEEDS,
    NO_KINDS,
    STEERING_FIELDS,
    Kind,
    KindTable,
    Relation,
    kind_table,
)
from agents.models.declare import Parameters
from agents.policies import known_policy
from agents.spec import KEYS, OPTIONS, Option, Spec, several
from app.cli.terminal.usage import FLYING
from app.settings import assignment, numbers
from app.studies.key_lines import place
from worlds.input_error import InputError, nearest, shorten, unknown
from worlds.text_file import read_text, toml
from worlds.world import World

GivenOptions = dict[str, Any]
"""Options of a run, by name; None for those that are not given."""
NAMED = re.compile(r"unknown (?:parameter|key) '([^']*)'|unknown (\w+)|(\w+)")
"""What a refusal is about."""


def with_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The command with every option of a run; it is given them as `options`."""

    @wraps(command)
    def called(**arguments: Any) -> Any:
        options = {name: arguments.pop(name) for name in OPTIONS}
        options |= {name: arguments.pop(name) or None for name in OF_KINDS}
        if options["size"] is not None:
            sides = numbers("--size", options["size"])
            options["size"] = sides[0] if len(sides) == 1 else tuple(sides)
        return command(options=options, **arguments)

    signature = inspect.signature(command, eval_str=True)
    declared: list[inspect.Parameter] = []
    for argument in signature.parameters.values():
        is_all = argument.name == "options"
        mine = [*map(parameter, OPTIONS, OPTIONS.values()), *map(kinds_parameter, OF_KINDS)]
        mine = mine if is_all else [argument]
        declared += [own.replace(kind=inspect.Parameter.KEYWORD_ONLY) for own in mine]
    called.__signature__ = signature.replace(parameters=declared)  # type: ignore[attr-defined]
    return called


def parameter(name: str, option: Option) -> inspect.Parameter:
    """An option of a run as Typer has it; what it may be is checked with the run."""
    kind = str if name == "size" else option.kind
    choices = f"{', '.join(option.words)}. " if option.words else ""
    default = Spec.model_fields[name].default
    default = OPEN.get(name, "the model's own") if default is None else default
    option_type = typer.Option(help=f"{choices}{option.help}. \\[default: {default}]")
    return inspect.Parameter(
        name,
        inspect.Parameter.KEYWORD_ONLY,
        default=None,
        annotation=Annotated[kind | None, option_type],
    )


OF_KINDS = {
    "kind": "A kind of agents beside the others, NAME=NUMBER, then its parameters and what it does "
    "about others: shark=2,s=4,chase=flock,radius=5,catch=0.3; model=NAME gives it a model of its "
    "own, policy=NAME flies it. May be repeated",
    "relation": "What the agents of a kind do about those of another, KIND:OTHER=DEED with its "
    "numbers: flock:shark=flee,weight=2,radius=3. May be repeated",
}
"""Options that make kinds of agents."""


def kinds_parameter(name: str) -> inspect.Parameter:
    """An option that makes kinds, as Typer has it."""
    return inspect.Parameter(
        name,
        inspect.Parameter.KEYWORD_ONLY,
        default=None,
        annotation=Annotated[list[str] | None, typer.Option(help=f"{OF_KINDS[name]}.")],
    )


BETWEEN = re.compile(r",(?![^(]*\))")
"""A comma that is not within brackets."""


def parts_of(text: str, option: str) -> tuple[str, str, dict[str, Any]]:
    """What stands before and behind the first = or :, and the assignments after it. Or
    InputError."""
    head, *rest = BETWEEN.split(text)
    name, sign, first = (
        head.replace(":", "=", 1).partition("=") if option == "--kind" else (head.partition("="))
    )
    if not sign or not name.strip():
        raise InputError(f"{text} is not allowed: NAME=... is needed ({option})")
    return name.strip(), first.strip(), dict(map(assignment, rest))


DETAILS = ("weight", "radius", "power", "first", "catch", "caught")


def read_kind(text: str) -> Kind:
    """The kind of `--kind`. Raises InputError."""
    name, number, values = parts_of(text, "--kind")
    if number.startswith("agents="):
        number = number.removeprefix("agents=")
    try:
        count = int(number)
    except ValueError:
        raise InputError(
            f"{text} is not allowed: NAME=NUMBER of agents comes first (--kind)"
        ) from None
    deeds = {deed: str(values.pop(deed)) for deed in DEEDS if deed in values}
    details = {key: values.pop(key) for key in DETAILS if key in values}
    colour, start = values.pop("colour", ""), values.pop("start", None)
    model = values.pop("model", "")
    flown = {key: values.pop(key) for key in STEERING_FIELDS if key in values}
    if details and not deeds:
        raise InputError(
            f"{next(iter(details))} of kind {name} belongs to none of {', '.join(DEEDS)} (--kind)"
        )
    to: dict[str, Relation] = {}
    for deed, others in deeds.items():
        mine = details if deed in ("flee", "chase") else {}
        if deed == "flee":
            mine = {key: value for key, value in mine.items() if key not in ("catch", "caught")}
        to |= {other: Relation(deed, **mine) for other in others.split("+")}
    if start is not None:
        corners = [list(map(float, corner.split("x"))) for corner in str(start).split("..")]
        start = corners
    return Kind(
        name, count, parameters=values, colour=str(colour), start=start, to=to, model=model, **flown
    )


def read_relation(text: str) -> tuple[str, str, Relation]:
    """The relation of `--relation`: of which kind to which. Raises InputError."""
    names, deed, values = parts_of(text, "--relation")
    kind, sign, other = names.partition(":")
    if not sign or not kind or not other:
        raise InputError(f"{text} is not allowed: KIND:OTHER=DEED is needed (--relation)")
    for key in values:
        if key not in DETAILS:
            raise unknown("key", key, DETAILS, "--relation")
    return kind, other, Relation(deed, **values)


def with_kinds(spec: Spec, kinds: list[str], relations: list[str]) -> Spec:
    """The run with the kinds and relations of the command line over its own. Or InputError."""
    table = read_kinds(kinds, relations, kind_table(spec.kinds, spec.to))
    return spec.but(kinds=table.kinds, to=table.to)


def read_kinds(kinds: list[str], relations: list[str], before: KindTable = NO_KINDS) -> KindTable:
    """The kinds and relations of the command line over others. Raises InputError."""
    more = [read_kind(text) for text in kinds]
    names = {kind.name for kind in more}
    there = tuple(one for one in before.kinds if one.name not in names)
    table = kind_table((*there, *more), before.to)
    for text in relations:
        table = table.with_relation(*read_relation(text))
    return table


OPEN = {"seed": "drawn; in the laboratory 1", "size": "the world's own", "dim": "the world's own"}
"""What options come to that are not given and that no model has."""


class Origins(dict[str, str]):
    """Where each value of a run comes from: an option, or a line of a file."""

    @contextmanager
    def naming_origins(self) -> Iterator[None]:
        """Refusals raised within say where the value is from that they are about."""
        try:
            yield
        except InputError as refusal:
            text = str(refusal)
            match = NAMED.match(text)
            key = match[match.lastindex or 0] if match else ""
            if key == "dim" and key not in self:
                key = "world"
            origin = self.get(key, "")
            if not origin or origin in text:
                raise
            raise InputError(f"{text} ({origin})") from None


def requested_run(
    model: str | None, options: GivenOptions, settings: list[str], file: Path | None = None
) -> tuple[Spec, Origins]:
    """The run, and where its values are from. Raises InputError naming what is wrong and where."""
    values, origins = ({}, Origins()) if file is None else read(file)
    changed, set_options = read_settings(settings)
    kinds, relations = (options.get(name) or [] for name in OF_KINDS)
    of_run = {key: value for key, value in options.items() if key not in OF_KINDS}
    for key, value in {"model": model, **of_run}.items():
        if value is not None:
            values[key], origins[key] = value, option_name(key)
    origins.update(set_options)
    if "model" not in values:
        raise InputError(
            "which MODEL? `flockscope list models` names them; or give a FILE of a run"
        )
    layout = values.pop("layout", None)
    with origins.naming_origins():
        if layout is not None and options.get("world") is None:
            values["world"] = read_world(layout, values, origins["layout"])
        parameters = {**values.pop("parameters", {}), **changed}
        spec = with_kinds(Spec(**values, parameters=parameters), kinds, relations)
        demand_parameters(changed, [find_model(spec.model).parameters])
    return spec, origins


def demand_policies(kinds: Sequence[Kind]) -> None:
    """Raise InputError for a policy of kinds that no file has brought, and for one that `--rule`
    has brought and that flies none of them."""
    names = [kind.policy for kind in kinds if kind.policy]
    for name in names:
        known_policy(name)
    for name in FLYING:
        if name not in names:
            raise InputError(
                f"policy {name} flies nobody: give a kind that it flies, --kind "
                f"NAME=NUMBER,policy={name}"
            )


def option_name(key: str) -> str:
    """How a command line names an option of a run."""
    return "MODEL" if key == "model" else "--" + key.replace("_", "-")


def read_settings(settings: list[str]) -> tuple[dict[str, Any], Origins]:
    """The parameters of `--set NAME=VALUE`, and where they are from. Raises InputError."""
    parameters = dict(map(assignment, settings))
    return parameters, Origins({name: f"--set {name}" for name in parameters})


def demand_parameters(changed: dict[str, Any], models: list[type[Parameters]]) -> None:
    """Raise InputError for what `--set` gives and an option would: that option is named."""
    parameter_names = dict.fromkeys(name for model in models for name in model.model_fields)
    for name, value in changed.items():
        guess = "" if name in parameter_names else nearest(name, [*parameter_names, *OPTIONS])
        if guess in OPTIONS:
            raise InputError(
                f"unknown parameter {name!r}: did you mean {option_name(guess)} {value}? "
                f"(known: {', '.join(parameter_names)}) (--set {name})"
            )


def read(path: Path) -> tuple[dict[str, Any], Origins]:
    """The values of a spec file, whole or in part, or those of the run of a scene.

    Raises InputError naming file and line.
    """
    text = read_text(repr(str(path)), path)
    values = toml(text, str(path))
    table = ""
    if RUN in values:
        values, table = scene_run(path, text), RUN
    origins = Origins({key: place(path, text, key, table) for key in values})
    for key in values:
        if key not in KEYS:
            raise unknown("key", key, KEYS, origins[key])
    if values.pop("start", "random") != "random":
        raise InputError(
            "start = 'given': a run from given arrays goes on only from its saved state, with "
            f"--state ({origins['start']})"
        )
    for key in ("versions", "parameters"):
        value = values.get(key, {})
        inner = dict | list if key == "versions" else ()
        if not isinstance(value, dict) or any(isinstance(v, inner) for v in value.values()):
            raise InputError(f"{key} is not a table of single values ({origins[key]})")
    for name in values.get("parameters", {}):
        origins[name] = place(path, text, name, f"{table}.parameters".lstrip("."))
    origins["layout"] = f"layout in {path}"
    return values, origins


def read_world(layout: Any, values: dict[str, Any], origin: str) -> World:
    """The world that a spec carries with it. Raises InputError naming the spec."""
    from worlds.checks import demand_sound
    from worlds.layout import world_from_layout

    if not isinstance(layout, dict):
        raise InputError(f"layout = {shorten(layout)} is not a table ({origin})")
    size, dim = values.pop("size", None), values.pop("dim", None)
    if dim is None and several(size):
        dim = len(size)
    try:
        world = world_from_layout(layout, values.get("world", "layout"), dim, size)
        demand_sound(world)
    except InputError as refusal:
        raise InputError(f"{refusal} ({origin})") from None
    return world


# A file where the name of a model may stand: what it is, told by its content.


STATE, TOML = "state", "toml"
RUN = "run"
"""The table of a scene that has its run; a spec has none."""


class FileArgument(NamedTuple):
    """A file that says which run it is."""

    path: Path
    kind: str
    """STATE: a saved state or a recording; TOML: a scene or a spec."""


def is_file(name: str | None) -> bool:
    """Whether it names a file, there or not, and not a model."""
    if name is None or name in MODELS:
        return False
    return bool(Path(name).suffix) or os.sep in name or Path(name).exists()


def file_argument(name: str) -> FileArgument:
    """What a file is, as `flockscope lab` opens it too. Raises InputError for what it cannot be."""
    from app.viewer.gallery.file_opener import demand_kind, head_of
    from app.viewer.run.stored_flock import PARQUET

    head = head_of(name)
    demand_kind(name, head)
    return FileArgument(Path(name), STATE if head.startswith(PARQUET) else TOML)


def scene_run(path: Path, text: str) -> dict[str, Any]:
    """The values of the run of a scene, nothing of it left open. Raises InputError."""
    from app.viewer.gallery.saved_scene import read_scene

    return tomllib.loads(read_scene(str(path), text.encode()).spec.to_toml())


def demand_alone(name: str, others: dict[str, Any]) -> None:
    """Raise InputError if anything else says which run it is, beside what says it already."""
    for option, value in others.items():
        if value is not None and value != []:
            raise InputError(f"{option} {value} cannot be given with {name}, which says it already")


def compared_model(path: Path) -> str:
    """The model that a scene shows beside its own; empty if there is none, or it is a spec."""
    beside = tomllib.loads(path.read_text("utf-8-sig")).get("beside", {})
    return str(beside.get("model", "")) if isinstance(beside, dict) else ""
