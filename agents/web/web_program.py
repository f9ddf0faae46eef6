"""A flock as a program for a web page: its compiled loop as WebAssembly, and the memory it runs on.

The page's own script calls the loop as the engines of `agents.engine.runner` do, and writes the
values of its sliders into the slots of the loop's arguments, which the manifest names by path.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any, NoReturn

import numpy as np

from agents.engine.pairs.pair_runner import PairEngine
from agents.engine.pass_engine import PassEngine
from agents.engine.runner import LoopEngine, SynchronousEngine
from agents.flock import Flock
from agents.individuals import normal, split_individuals
from agents.kinds import replace_kind
from agents.models.declare import NumberParameter, declared
from agents.models.model import NUMBER
from agents.observables.catalogue import (
    OBSERVABLES,
    OF_KIND,
    kind_observables,
    telling_observables,
    title_of_kind,
)
from agents.observables.observable import Observable, Range
from agents.observables.of_rows import NOT_ASKED, empty_cells, groups, layers
from agents.spec import CompleteSpec
from agents.state.start import TRIES, free_positions
from agents.web.web_draws import (
    DRAWS,
    can_begin_anew,
    draws,
    of_parameters,
    start_reach,
    start_task,
    start_words,
    wind_task,
)
from agents.web.web_kinds import (
    demand_kinds_in_page,
    farthest_parameters,
    functions_of_rows,
    is_listed_by_hand,
    own_arguments,
    own_sliders,
    page_values,
)
from agents.web.web_modules import PageFunction, module_of, with_callees
from worlds.compilation import entry
from worlds.input_error import InputError
from worlds.queries.survey import survey_world
from worlds.web_assembly import FIRST_FREE, MemoryImage
from worlds.web_binary import imported_functions

DURATION, DELAY = "context.lasts", "messages.delay"
UNNAMED = ("grid", "slots", "notes")
"""Arguments that a page's script neither writes nor measures of: it is not told where they are."""
OWN = ("parameters", "unbounded")
"""Where the loop has its parameters in the context: of the second, the radius that does not count
where the nearest are neighbours is infinite."""

KNOWN = {
    "sched_yield", "fmod", "expm1", "log1p", "log2", "log10", "cbrt", "sinh", "cosh", "tanh",
    "asinh", "acosh", "atanh",
}  # fmt: skip
"""Functions that a page has for the loop beside those of `agents.web.web_math`: JavaScript's `Math`
has most, with other last bits in other browsers. It has `round` too, which is another one."""


@dataclass(frozen=True)
class WebProgram:
    """What a page needs to run a flock."""

    module: bytes
    """WebAssembly that exports `advance`, and `reach` where that is more than one parameter."""
    memory: bytes
    """What stands at `manifest["base"]` before the first tick."""
    manifest: dict[str, Any]
    """What the page's script has to know, as JSON has it."""


class CallStopped(Exception):
    """The arguments of a call, which is not made."""

    def __init__(self, function: Any, arguments: tuple[Any, ...]):
        super().__init__("the call is not made")
        self.function, self.arguments = function, arguments


def web_program(
    flock: Flock,
    update: Callable[[float], None] = lambda _: None,
    is_fixed: bool = False,
    wanted: Collection[str] = (),
) -> WebProgram:
    """The program of a flock, which goes on from where it stands; the flock stays as it is.

    `update` hears the share that is done. With `is_fixed` sliders are all that a page can change:
    it has no other start, and nobody steers. `wanted`: observables that it measures besides, where
    they have a loop; also of a kind alone. Raises InputError for what a page cannot do yet.
    """
    demand_possible(flock)
    zone_sums = zones(flock)
    survey_for_sliders(flock)
    call = first_call(flock)
    arguments = page_arguments(flock, call)
    if start_reach(flock) > arguments[SEEN].reach:
        arguments[WIDER] = survey_world(flock.world, start_reach(flock))
    image = memory_image(arguments)
    is_anew = can_begin_anew(flock) and not is_fixed and not is_listed_by_hand(flock)
    becomes = {relation.caught for _, _, relation in flock.kinds.catchers}
    grows = growth(flock) if is_anew or "taken" in becomes else {}
    functions = {"advance": PageFunction(call.function, call.arguments)}
    calls: dict[str, tuple[str, ...]] = {}
    reach = flock.model.rule.reach
    is_computed = reach not in type(flock.parameters).model_fields
    if is_computed and not differs(flock):
        functions["reach"] = of_slider(flock, getattr(type(flock.parameters), reach).fget, reach)
    for name in draws(flock, is_anew or "moved" in becomes):
        function, paths = DRAWS[name]
        calls[name] = tuple(WIDER if WIDER in arguments and one == SEEN else one for one in paths)
        functions[name] = PageFunction(function, [arguments[path] for path in calls[name]])
    needed = of_parameters(flock) if is_anew or "moved" in becomes else {}
    if differs(flock):
        of_rows, paths_of_rows = functions_of_rows(flock, arguments, needed)
        functions |= of_rows
        calls |= paths_of_rows
    else:
        for name, (function, paths) in needed.items():
            calls[name] = paths
            functions[name] = of_slider(flock, function, name, *(0.5 for _ in paths[1:]))
    measures = web_measures(flock, wanted)
    labels = web_labels(flock)
    measured = dict(arguments)
    if not flock.kinds.kinds:
        measured["flock"] = measured["flock"]._replace(kind=NOT_ASKED)
    measured_names = dict.fromkeys(one["name"].partition(OF_KIND)[0] for one in measures)
    for compute in (*(OBSERVABLES[name].compiled for name in measured_names), *labels.values()):
        names = inspect.signature(compute.py_func).parameters
        functions[export_name(compute)] = PageFunction(compute, [measured[name] for name in names])
    module = module_of(functions, update)
    unknown = sorted(set(imported_functions(module)) - KNOWN)
    if unknown:
        raise InputError(
            f"model {flock.model.name!r} calls {', '.join(unknown)}: "
            "a browser has no function that gives the same"
        )
    manifest = {
        "model": flock.model.name,
        "title": flock.model.rule.title,
        "dim": flock.world.dim,
        "agents": len(flock.ids),
        "size": [float(side) for side in flock.world.size],
        "low": [float(edge) for edge in flock.world.low],
        "edges": list(flock.world.edges),
        "images": [bool(axis) for axis in flock.world.images],
        "car": car_sides(flock),
        "time_unit": flock.model.body.unit,
        "seed": str(flock.seed),
        "tick": flock.tick,
        "runner": runner_kind(flock),
        "base": FIRST_FREE,
        "block": image.block,
        "answer": image.answer,
        "arguments": {
            path: [one.slot, one.kind, one.address, list(one.shape)]
            for path, one in image.arguments.items()
            if path.partition(".")[0] not in UNNAMED or path in grows
        },
        "grows": grows,
        "calls": calls,
        "attempts": TRIES + 1,
        "start": start_words(flock) if is_anew else None,
        "parameters": slider_parameters(flock, image),
        "zones": zone_sums,
        "steered": 0 if is_fixed else steered_agents(flock),
        "measures": measures,
        "labels": {name: loop_call(flock, compute) for name, compute in labels.items()},
        "reach": None if is_computed or differs(flock) else reach,
    }
    if differs(flock):
        manifest["differ"] = page_values(flock)
    return WebProgram(module, bytes(image.content), manifest)


def page_arguments(flock: Flock, call: CallStopped) -> dict[str, Any]:
    """The arguments of all functions of a page, by their names: those of the loop's call first."""
    names = inspect.signature(call.function.py_func).parameters
    return (
        dict(zip(names, call.arguments, strict=True))
        | {
            "cells": empty_cells(len(flock.ids)),
            "converges": bool(flock.model.rule.converges),
            "start": start_task(flock),
            "chance": 0.0,
            "keys": np.zeros(len(flock.ids)),
            "air": wind_task(flock),
            "together": flock.together,
        }
        | (own_arguments(flock) if differs(flock) else {})
    )


def differs(flock: Flock) -> bool:
    """Whether agents have numbers of their own: by themselves or by their kind."""
    return bool(flock.individuals or flock.kinds.kinds)


def memory_image(arguments: Mapping[str, Any]) -> MemoryImage:
    """The memory that these arguments stand in."""
    image = MemoryImage()
    for name, value in arguments.items():
        image.add(name, value)
    image.finish()
    return image


SEEN, WIDER = "surroundings", "wider"
"""Arguments: what agents notice of the world, and a wider survey where starts need one."""
FEWER, MORE = 512, 1024
"""Numbers of agents by which a page is told what grows with them."""


def growth(flock: Flock) -> dict[str, list[list[int]]]:
    """The arguments that grow with the number of agents: of each, for every axis, how many items an
    agent adds and how many there are besides; of a whole number the same."""
    few, many = (count + flock.options.count_of_kinds for count in (FEWER, MORE))
    fewer, more = (
        memory_image(page_arguments(other, first_call(other)))
        for other in (with_agents(flock, few), with_agents(flock, many))
    )
    found = {}
    for path, one in fewer.arguments.items():
        sizes = one.shape, more.arguments[path].shape
        if not one.shape:
            (kind, a), (_, b) = fewer.slots[one.slot], more.slots[one.slot]
            sizes = ((int(a),), (int(b),)) if kind == "l" else ((), ())
        if sizes[0] != sizes[1]:
            each = [(b - a) // (many - few) for a, b in zip(*sizes, strict=True)]
            found[path] = [[k, a - few * k] for k, a in zip(each, sizes[0], strict=True)]
    return found


def with_agents(flock: Flock, count: int) -> Flock:
    """A flock as this one of so many agents, which all stand in one place."""
    # Where the flock is by now, not all agents can begin: some may lie where they crashed.
    place = free_positions(flock.world, np.ones(1, int), flock.seed)
    start = {
        "position": np.repeat(place, count, axis=0),
        "heading": np.repeat(flock.heading[:1], count, axis=0),
        "informed": np.zeros(count, bool),
    }
    return Flock(without_lists(flock), start=start)


def without_lists(flock: Flock) -> CompleteSpec:
    """The run of a flock, whose agents differ where they did, but not by lists of so many."""
    if not differs(flock):
        return flock.spec
    alike = {name: normal(getattr(flock.parameters, name), 0.0) for name in flock.individuals}
    kinds = tuple(
        replace_kind(one, parameters=split_individuals(one.parameters)[0])
        for one in flock.kinds.kinds
    )
    return flock.spec.with_parameters(flock.all_parameters | alike, kinds=kinds)


def web_measures(flock: Flock, wanted: Collection[str] = ()) -> list[dict[str, Any]]:
    """What a page can measure of a flock, what tells most of it first: of each its words, the
    function that it calls, and by what names or paths that finds its arguments. See `web_program`.

    Behind them what is measured of each kind alone, with the number of that kind.
    """
    telling = telling_observables(flock)
    wanted_names = {name.partition(OF_KIND)[0] for name in wanted}
    found = {
        name: observable
        for name, observable in OBSERVABLES.items()
        if observable.compiled is not None
        and observable.applies(flock)
        and (observable.in_page(flock) or name in wanted_names)
    }
    names = sorted(found, key=lambda one: telling.index(one) if one in telling else len(telling))
    if "catches" in names:  # a page has two charts at first: it is in the second one
        names.remove("catches")
        names.insert(1, "catches")
    measures = [describe_measure(flock, found[name]) for name in names]
    for name in dict.fromkeys([*kind_observables(flock), *wanted]):
        whole, _, kind = name.partition(OF_KIND)
        if whole in found and kind in flock.kinds.names:
            title = title_of_kind(found[whole].title, kind)
            own = {"name": name, "title": title, "kind": flock.kinds.number(kind)}
            measures.append(describe_measure(flock, found[whole]) | own)
    return measures


def describe_measure(flock: Flock, observable: Observable) -> dict[str, Any]:
    """What a page has to know of an observable that it measures."""
    return {
        "name": observable.name,
        "title": observable.title,
        "unit": observable.unit,
        "share": isinstance(observable.range, Range) and observable.range.is_share,
        "quick": observable.quick,
    } | loop_call(flock, observable.compiled)


def car_sides(flock: Flock) -> dict[str, float] | None:
    """Length and width of each agent where the flock is one of cars on a plane, else None."""
    vehicle = flock.model.body.vehicle
    if vehicle is None or flock.world.dim == 3:
        return None
    return {
        name: float(getattr(flock.parameters, name, getattr(vehicle, name)))
        for name in ("length", "width")
    }


def web_labels(flock: Flock) -> dict[str, Any]:
    """The loops that leave a label of each agent in `cells.parent`, by what a label is.

    Layers go by who is within reach: where the nearest are neighbours they would be others.
    """
    has_layers = bool(flock.informed.any()) and not flock.nearest and not differs(flock)
    return {"group": groups} | ({"layer": layers} if has_layers else {})


def loop_call(flock: Flock, compute: Any) -> dict[str, Any]:
    """How a page calls a loop: its name, and those or the paths of its arguments."""
    together = flock.model.rule.together or flock.model.rule.reach
    is_parameter = together in type(flock.parameters).model_fields
    paths = {"together": f"context.parameters.{together}" if is_parameter else "context.reach"}
    if differs(flock):
        paths = {}
    names = inspect.signature(compute.py_func).parameters
    return {"export": export_name(compute), "arguments": [paths.get(name, name) for name in names]}


def export_name(compute: Any) -> str:
    """What a page calls a loop."""
    return f"measure_{compute.py_func.__name__}"


def demand_possible(flock: Flock) -> None:
    """Raise InputError for what a page cannot do yet."""
    checks = type(flock.parameters).__pydantic_decorators__
    if checks.model_validators or checks.field_validators:
        raise InputError(
            f"model {flock.model.name!r} has checks of its own of its parameters: "
            "a page cannot make them when a slider is moved"
        )
    if flock.world.has_gates:
        raise InputError(
            f"agents come and go in {flock.world.name}: a page that runs by itself has the same "
            "agents throughout"
        )
    demand_kinds_in_page(flock)
    if not len(flock.ids):
        raise InputError("a page needs at least one agent")
    if flock.ranks != 1:
        raise InputError("a page runs in one process: make it of a flock without ranks")


def first_call(flock: Flock) -> CallStopped:
    """The call of the compiled loop with which the flock's next tick would begin."""

    def stop(function: Any, *arguments: Any) -> NoReturn:
        raise CallStopped(function, arguments)

    engine = flock.engine
    assert isinstance(engine, LoopEngine)
    called, engine.called = engine.called, stop
    try:
        flock.advance(1)
    except CallStopped as call:
        return call
    finally:
        engine.called = called
    raise AssertionError("a tick calls the compiled loop")


def steered_agents(flock: Flock) -> int:
    """How many agents keep the heading that a person gives them: information agents, where no path
    tells them theirs."""
    mission = flock.world.mission
    return int(flock.informed.sum()) if mission is None or mission.path is None else 0


def runner_kind(flock: Flock) -> str:
    """How the page has to call the loop: `pairs`, `synchronous` or `turns`."""
    if isinstance(flock.engine, PairEngine):
        return "pairs"
    return "synchronous" if isinstance(flock.engine, SynchronousEngine) else "turns"


def sliders(flock: Flock) -> list[NumberParameter]:
    """The parameters that a page has sliders for: not how many nearest agents are neighbours, where
    all within reach are."""
    return [
        parameter
        for parameter in declared(type(flock.parameters))
        if isinstance(parameter, NumberParameter) and (flock.nearest or parameter.name != NUMBER)
    ]


def survey_for_sliders(flock: Flock) -> None:
    """Have the surroundings surveyed as far as any slider lets agents see: a page cannot do so."""
    for parameter in sliders(flock):
        if parameter.name in flock.individuals:
            continue
        before = getattr(flock.parameters, parameter.name)
        most: dict[str, Any] = {parameter.name: parameter.proposed[1]}
        try:
            flock.set(**most)
        except InputError:
            continue  # it would be refused by the page, too
        _ = flock.engine
        flock.set(**{parameter.name: before})
    if differs(flock):
        sight = flock.model.body.sight or flock.model.rule.reach
        farthest = float(getattr(farthest_parameters(flock), sight))
        engine = flock.engine
        assert not isinstance(engine, PassEngine)
        if farthest > engine.surroundings.reach:
            engine.surroundings = survey_world(flock.world, farthest)


def slider_parameters(flock: Flock, image: MemoryImage) -> list[dict[str, Any]]:
    """What a page has to know of each slider: its words, and the slots that it writes.

    One that changes more than numbers, as which code runs, has no slots: its value is shown alone.
    """
    described = []
    for parameter in sliders(flock):
        value = getattr(flock.parameters, parameter.name)
        low, high = parameter.proposed
        described.append(
            {
                "name": parameter.name,
                "symbol": parameter.symbol,
                "unit": parameter.unit,
                "words": parameter.words,
                "description": parameter.description,
                "low": min(low, value),
                "high": max(high, value),
                "step": parameter.step,
                "value": value,
                "slots": parameter_slots(flock, image, parameter),
            }
        )
    if differs(flock):
        described = own_sliders(flock, described)
    return [*described, *delay_slider(flock, image)]


def delay_slider(flock: Flock, image: MemoryImage) -> list[dict[str, Any]]:
    """A slider of the delay of messages, up to that of the flock, which has room for no older ones;
    none where nothing is late, or messages get lost or take longer by chance."""
    options = flock.options
    if not options.delay or options.jitter or options.lost:
        return []
    return [
        {
            "name": "delay",
            "symbol": "T",
            "unit": flock.model.body.unit,
            "words": "Delay of messages",
            "description": "How old is what an agent knows of the others.",
            "low": 0.0,
            "high": options.delay,
            "step": flock.dt,
            "value": options.delay,
            "slots": [image.arguments[DELAY].slot],
            "ticks": flock.dt,
        }
    ]


def parameter_slots(flock: Flock, image: MemoryImage, parameter: NumberParameter) -> list[int]:
    """The slots that hold a parameter, and the time step where the parameter is that."""
    name = parameter.name
    value, loop, context = getattr(flock.parameters, name), flock.loop, flock.context
    low, high = parameter.proposed
    paths = [
        f"context.{own}.{name}" for own in OWN if getattr(getattr(context, own), name) == value
    ]
    if differs(flock) and name in flock.model.individual:
        return [image.arguments[path].slot for path in paths]
    other: dict[str, Any] = {name: high if value != high else low}
    try:
        flock.set(**other)
    except InputError:
        return []
    changed, loop_changed = flock.context, flock.loop is not loop
    flock.set(**{name: value})
    if loop_changed or changed.nearest != context.nearest:
        return []
    if changed.lasts != context.lasts:
        if (
            changed.lasts != other[name] or flock.options.is_late
        ):  # how old messages are follows from it
            return []
        paths.append(DURATION)
    return [image.arguments[path].slot for path in paths]


def zones(flock: Flock) -> list[list[tuple[str, float]]]:
    """The outer radii of the rule's zones, from the inside out: each a sum of parameters, with how
    many times each is taken."""
    sums = []
    for zone in flock.model.rule.zones:
        base = zone.radius(flock.parameters)
        terms = [
            (parameter.name, times)
            for parameter in sliders(flock)
            if (times := slope(flock, parameter.name, zone.radius, base))
        ]
        total = sum(times * getattr(flock.parameters, name) for name, times in terms)
        if abs(total - base) > 1e-9 * (1.0 + abs(base)):
            raise InputError(
                f"the zone of {zone.name} of model {flock.model.name!r} is no sum of parameters: "
                "a page cannot keep its order"
            )
        sums.append(terms)
    return sums


def slope(flock: Flock, name: str, radius: Any, base: float) -> float:
    """By how much a radius grows with a parameter."""
    value = getattr(flock.parameters, name)
    return round(radius(flock.parameters.model_copy(update={name: value + 1.0})) - base, 9)


def of_slider(flock: Flock, function: Any, name: str, *more: float) -> PageFunction:
    """A plain function of the parameters, and of more numbers, as a page calls it."""
    compute = with_callees(function)
    compute.__name__ = compute.__qualname__ = name
    return PageFunction(entry(compute), (flock.context.parameters, *more), takes_text=True)
