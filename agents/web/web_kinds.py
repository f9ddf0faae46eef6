"""Agents that differ, in a page: their own numbers, their kinds, and who is caught.

What is drawn is that of `agents.individuals`, and who is caught that of
`agents.motion.hunting_motion`: the same from the same seed. The page's script
(`static/export/kinds.js`) keeps what numbers are drawn from, which sliders change, and does with
the caught what their relation says.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from agents.engine.heeding import CATCH, MOST_KINDS, RADIUS, WEIGHT
from agents.engine.noise import tick_key, uniform
from agents.flock import Flock
from agents.individuals import ATTEMPTS, DRAWN, MOST_DRAWS, Distribution
from agents.kinds import ORDINARY
from agents.models.declare import NumberParameter, declared
from agents.models.slider_range import round_up
from agents.observables.of_agents import own_name
from agents.observables.of_rows import is_active, nearest_image
from agents.web.web_modules import PageFunction, with_callees
from worlds.compilation import compiled, entry
from worlds.input_error import InputError

SAME, NORMAL, LOGNORMAL, UNIFORM, ONE_OF, EACH = range(6)
"""What a page draws an agent's own number from."""
FAMILIES = {
    "normal": NORMAL,
    "lognormal": LOGNORMAL,
    "uniform": UNIFORM,
    "one_of": ONE_OF,
    "each": EACH,
}
FARTHEST = 6.0
"""No agent is farther from the mean of a normal distribution, in standard deviations."""
HEAVIEST = 5.0
"""The largest weight of a slider, where a relation has no larger one."""


def demand_kinds_in_page(flock: Flock) -> None:
    """Raise InputError for kinds of agents that a page cannot fly."""
    for kind in flock.kinds.with_model.values():
        raise InputError(
            f"kind {kind.name} has a model of its own, {kind.model}: in a page that runs by itself "
            "all agents go by one"
        )
    steered = [kind.name for kind in flock.kinds.kinds if kind.steered]
    if steered:
        raise InputError(
            f"agents of kind {', '.join(steered)} are steered from outside: nobody does so in a "
            "page that runs by itself"
        )


# What a page computes of agents that differ.


class OwnDraw(NamedTuple):
    """What a page asks for when it has one parameter of agents drawn."""

    values: np.ndarray
    """What it is drawn from: mean and deviation, low and high, or the values of `one_of`."""
    takes: np.ndarray
    """1 where agents of a kind take it: uint8, those of kind k at k + 1."""
    column: int
    """Of `Arrays.own`."""
    family: int
    number: int
    """How many values there are."""
    low: float
    """Numbers outside of [low, high] are drawn again."""
    high: float
    key: int
    """Made of the parameter's name: see `agents.individuals.Distribution.draw`."""


@compiled
def polynomial(x, a, b, c, d, e, f, g, h):
    """a x^7 + ... + h."""
    return ((((((a * x + b) * x + c) * x + d) * x + e) * x + f) * x + g) * x + h


@compiled
def quantile(chance):
    """The quantile of the normal distribution, by Wichura's algorithm AS 241, as Python has it."""
    off = chance - 0.5
    if abs(off) <= 0.425:
        r = 0.180625 - off * off
        above = polynomial(
            r,
            2.50908_09287_30122_6727e3,
            3.34305_75583_58812_8105e4,
            6.72657_70927_00870_0853e4,
            4.59219_53931_54987_1457e4,
            1.37316_93765_50946_1125e4,
            1.97159_09503_06551_4427e3,
            1.33141_66789_17843_7745e2,
            3.38713_28727_96366_6080e0,
        )
        below = polynomial(
            r,
            5.22649_52788_52854_5610e3,
            2.87290_85735_72194_2674e4,
            3.93078_95800_09271_0610e4,
            2.12137_94301_58659_5867e4,
            5.39419_60214_24751_1077e3,
            6.87187_00749_20579_0830e2,
            4.23133_30701_60091_1252e1,
            1.0,
        )
        return off * above / below
    r = math.sqrt(-math.log(chance if off <= 0.0 else 1.0 - chance))
    if r <= 5.0:
        r -= 1.6
        above = polynomial(
            r,
            7.74545_01427_83414_07640e-4,
            2.27238_44989_26918_45833e-2,
            2.41780_72517_74506_11770e-1,
            1.27045_82524_52368_38258e0,
            3.64784_83247_63204_60504e0,
            5.76949_72214_60691_40550e0,
            4.63033_78461_56545_29590e0,
            1.42343_71107_49683_57734e0,
        )
        below = polynomial(
            r,
            1.05075_00716_44416_84324e-9,
            5.47593_80849_95344_94600e-4,
            1.51986_66563_61645_71966e-2,
            1.48103_97642_74800_74590e-1,
            6.89767_33498_51000_04550e-1,
            1.67638_48301_83803_84940e0,
            2.05319_16266_37758_82187e0,
            1.0,
        )
    else:
        r -= 5.0
        above = polynomial(
            r,
            2.01033_43992_92288_13265e-7,
            2.71155_55687_43487_57815e-5,
            1.24266_09473_88078_43860e-3,
            2.65321_89526_57612_30930e-2,
            2.96560_57182_85048_91230e-1,
            1.78482_65399_17291_33580e0,
            5.46378_49111_64114_36990e0,
            6.65790_46435_01103_77720e0,
        )
        below = polynomial(
            r,
            2.04426_31033_89939_78564e-15,
            1.42151_17583_16445_88870e-7,
            1.84631_83175_10054_68180e-5,
            7.86869_13114_56132_59100e-4,
            1.48753_61290_85061_48525e-2,
            1.36929_88092_27358_05310e-1,
            5.99832_20655_58879_37690e-1,
            1.0,
        )
    return -above / below if off < 0.0 else above / below


@compiled
def drawn_number(draw, chance):
    """The number that a chance in [0, 1) means, as the functions of `agents.individuals`."""
    first = draw.values[0]
    second = draw.values[1]
    if draw.family == UNIFORM:
        return first + (second - first) * chance
    if draw.family == ONE_OF:
        return draw.values[int(chance * draw.number)]
    away = quantile(chance + 2.0**-54)
    if draw.family == NORMAL:
        return first + second * away
    variance = math.log1p((second / first) * (second / first))
    return math.exp(math.log(first) - 0.5 * variance + math.sqrt(variance) * away)


@entry
def draw_own(flock, draw, seed):
    """Draw a parameter of all agents of the kinds that take it; -1.0 where next to nothing of it is
    within its bounds."""
    most = ATTEMPTS + MOST_DRAWS * flock.ids.shape[0]
    again = 0
    for i in range(flock.ids.shape[0]):
        kind = int(flock.kind[i]) + 1 if flock.kind.shape[0] > 0 else 1
        if draw.takes[kind] == 0:
            continue
        value = math.nan
        attempt = 0
        while not (draw.low <= value <= draw.high):
            key = tick_key(seed, DRAWN + (attempt << 32) + draw.key)
            value = drawn_number(draw, uniform(key, flock.ids[i], 0))
            again += 1 if attempt > 0 else 0
            attempt += 1
            if again > most:
                return -1.0
        flock.own[i, draw.column] = value
    return float(again)


class Hunt(NamedTuple):
    """What a page asks for when agents of a kind catch those of another."""

    step: np.ndarray
    """How far each went in the last tick, length (N, dim): before it is known, where each was."""
    claimed: np.ndarray
    """The row of who catches each agent, or -1; int64 (N,)."""
    distance: np.ndarray
    """How near it came, length (N,)."""
    hunter: int
    """The number of the kind that catches, and of the one that is caught."""
    prey: int
    reach: float
    """The distance of a catch, length."""


@entry
def note_steps(flock, hunt, space):
    """Write how far each has gone from where it was."""
    for i in range(flock.position.shape[0]):
        for axis in range(flock.position.shape[1]):
            gone = flock.position[i, axis] - hunt.step[i, axis]
            hunt.step[i, axis] = nearest_image(gone, space, axis)
    return 0.0


@compiled
def closest_approach(flock, hunt, space, i, j):
    """The least distance of two agents on their straight ways from before the tick to now."""
    now2 = gone2 = product = 0.0
    for axis in range(flock.position.shape[1]):
        now = nearest_image(flock.position[j, axis] - flock.position[i, axis], space, axis)
        gone = hunt.step[j, axis] - hunt.step[i, axis]
        gone2 += gone * gone
        product += now * gone
    back = min(1.0, max(0.0, product / (gone2 if gone2 > 0.0 else 1.0)))
    for axis in range(flock.position.shape[1]):
        now = nearest_image(flock.position[j, axis] - flock.position[i, axis], space, axis)
        off = now - back * (hunt.step[j, axis] - hunt.step[i, axis])
        now2 += off * off
    return math.sqrt(now2)


@compiled
def is_nearer(flock, distance, i, other_distance, j):
    """Whether agent i is the nearer one, or of the lower identity where both are as near."""
    is_as_near = distance == other_distance and flock.ids[i] < flock.ids[j]
    return distance < other_distance or is_as_near


@entry
def claim_prey(flock, hunt, space):
    """Let each hunter claim the nearest that it came near enough, and the nearer hunter have it;
    how many are caught."""
    n = flock.position.shape[0]
    for j in range(n):
        hunt.claimed[j] = -1
    for i in range(n):
        if flock.kind[i] != hunt.hunter or not is_active(flock, i):
            continue
        found, least = -1, math.inf
        for j in range(n):
            if j != i and flock.kind[j] == hunt.prey and is_active(flock, j):
                distance = closest_approach(flock, hunt, space, i, j)
                is_first = found < 0 or is_nearer(flock, distance, j, least, found)
                if distance <= hunt.reach and is_first:
                    found, least = j, distance
        if found >= 0:
            rival = hunt.claimed[found]
            if rival < 0 or is_nearer(flock, least, i, hunt.distance[found], rival):
                hunt.claimed[found], hunt.distance[found] = i, least
    count = 0.0
    for j in range(n):
        count += 1.0 if hunt.claimed[j] >= 0 else 0.0
    return count


def value_of(flock: Flock, name: str) -> Any:
    """A compiled function of the parameters: one of them, or a property that follows from them."""
    computed = getattr(type(flock.parameters), name, None)
    if isinstance(computed, property) and computed.fget is not None:
        return compiled(with_callees(computed.fget), takes_text=True)  # type: ignore[arg-type]
    names: dict[str, Any] = {"__name__": __name__}
    exec(f"def field(p):\n    return p.{name}", names)
    return compiled(names["field"])


def largest_of(value: Any, own_of_row: Any) -> Callable:
    """What computes the largest number that agents have, and notes that of each."""

    def largest(p, own, values):
        most = value(p) if own.shape[0] == 0 else -math.inf
        for i in range(own.shape[0]):
            values[i] = value(own_of_row(p, own, i))
            most = max(most, values[i])
        return most

    return largest


def widest_of(value: Any, own_of_row: Any) -> Callable:
    """What computes the largest number of those agents that lack a place."""

    def widest(p, own, lacks_place):
        most = 0.0
        for i in range(own.shape[0]):
            if lacks_place[i] != 0:
                most = max(most, value(own_of_row(p, own, i)))
        return most

    return widest


def speed_of(value: Any, own_of_row: Any, takes_chance: bool) -> Callable:
    """What computes the speed at which the agent of a row begins."""

    def by_chance(p, own, at, chance):
        return value(own_of_row(p, own, at), chance)

    def by_itself(p, own, at, chance):  # noqa: ARG001 - called alike
        return value(own_of_row(p, own, at))

    return by_chance if takes_chance else by_itself


P, OWN = "context.parameters", "flock.own"
VALUES = {"reach": "reaches", "together": "gathered"}
"""Where the numbers of each agent are noted: how far it notices others, and what is of one group
with it."""


def functions_of_rows(
    flock: Flock, arguments: dict[str, Any], of_parameters: dict[str, tuple[Callable, Any]]
) -> tuple[dict[str, PageFunction], dict[str, tuple[str, ...]]]:
    """What a page computes of agents of which each has numbers of its own: functions by what they
    give, and the paths of their arguments.

    `of_parameters`: plain functions that starts need, see `agents.web.web_draws.of_parameters`.
    """
    own_of_row = flock.loop.own_of_row
    rule = flock.model.rule
    makers: dict[str, tuple[Callable, tuple[str, ...]]] = {}
    for name, field in (("reach", rule.reach), ("together", rule.together or rule.reach)):
        makers[name] = largest_of(value_of(flock, field), own_of_row), (P, OWN, VALUES[name])
    for name, (function, paths) in of_parameters.items():
        value = compiled(with_callees(function), takes_text=True)  # type: ignore[arg-type]
        if name == "start_gap":
            makers[name] = widest_of(value, own_of_row), (P, OWN, "start.lacks_place")
        else:
            compute = speed_of(value, own_of_row, len(paths) > 1)
            makers[name] = compute, (P, OWN, "at", "chance")
    makers["draw_own"] = draw_own.py_func, ("flock", "draw", "seed")
    if flock.kinds.catchers:
        makers["note_steps"] = note_steps.py_func, ("flock", "hunt", "space")
        makers["claim_prey"] = claim_prey.py_func, ("flock", "hunt", "space")
    functions, calls = {}, {}
    for name, (function, paths) in makers.items():
        function.__name__ = function.__qualname__ = name  # by which its symbol is found
        calls[name] = paths
        taken = [value_at(arguments, path) for path in paths]
        functions[name] = PageFunction(entry(function), taken)
    return functions, calls


def value_at(arguments: dict[str, Any], path: str) -> Any:
    """An argument by its path."""
    first, *members = path.split(".")
    value = arguments[first]
    for member in members:
        value = getattr(value, member)
    return value


def own_arguments(flock: Flock) -> dict[str, Any]:
    """The arguments of what a page computes of agents that differ."""
    n, dim = flock.position.shape
    listed = [len(one.numbers) for one in all_draws(flock) if one.family == ONE_OF]
    hunt = Hunt(np.zeros((n, dim)), np.zeros(n, np.int64), np.zeros(n), 0, 0, 0.0)
    return ({"hunt": hunt} if flock.kinds.catchers else {}) | {
        "draw": OwnDraw(
            values=np.zeros(max([2, *listed])),
            takes=np.zeros(MOST_KINDS + 2, np.uint8),
            column=0,
            family=0,
            number=0,
            low=0.0,
            high=0.0,
            key=0,
        ),
        "reaches": flock.reaches,
        "gathered": np.zeros(n),
        "caught": float(len(flock.catches)),
        "at": 0,
    }


# What numbers are drawn from.


class PageDraw(NamedTuple):
    """What one parameter of the agents of a kind, or of all, is drawn from."""

    column: int
    kind: int
    """0: of all agents whose kind has no number of its own."""
    family: int
    numbers: tuple[float, ...]


def as_draw(column: int, kind: int, value: Any) -> PageDraw:
    """The draw of a distribution, or of one number."""
    if isinstance(value, Distribution):
        return PageDraw(column, kind, FAMILIES[value.kind], value.numbers)
    return PageDraw(column, kind, SAME, (float(value),))


def all_draws(flock: Flock) -> list[PageDraw]:
    """What all own numbers of a flock are drawn from; those of kinds behind the others."""
    names = flock.model.individual
    shared: dict[str, Any] = {name: getattr(flock.parameters, name) for name in names}
    shared |= dict(flock.individuals)
    draws = [as_draw(column, 0, shared[name]) for column, name in enumerate(names)]
    draws += [
        as_draw(names.index(name), number, value)
        for number, kind in enumerate(flock.kinds.kinds, 1)
        for name, value in kind.parameters.items()
    ]
    return draws


def is_listed_by_hand(flock: Flock) -> bool:
    """Whether some number is known of each agent alone, so that a page has no other start."""
    return any(one.is_by_hand for one in flock.individuals.values())


def page_values(flock: Flock) -> dict[str, Any]:
    """What the page's script has to know of agents that differ."""
    kinds, number = flock.kinds, {name: k for k, name in enumerate(flock.kinds.names)}
    return {
        "columns": [
            [zlib.crc32(name.encode()), *map(finite_or_none, one.bounds)]
            for name, one in own_parameters(flock).items()
        ],
        "own": {own_name(one): flock.model.individual.index(one) for one in flock.differing},
        "draws": [list(draw) for draw in all_draws(flock)],
        "kinds": [
            {"name": name, "agents": 0 if k == 0 else kinds.kinds[k - 1].agents}
            | ({"start": kinds.kinds[k - 1].start} if k and kinds.kinds[k - 1].start else {})
            for k, name in enumerate(kinds.names)
        ]
        if kinds.kinds
        else [],
        "far": [
            [number[kind], number[other]]
            for kind in kinds.names
            for other in kinds.names
            if kinds.kinds and kinds.of(kind, other).radius is None
        ],
        "memory": [as_javascript(value) for value in flock.model.initial_columns.tolist()],
        "caught": [len(flock.catches_of(name)) for name in kinds.names] if kinds.catchers else [],
        "catchers": [[hunter, prey, one.caught] for hunter, prey, one in kinds.catchers],
        "heeds": [
            [kinds.of(kind, other).deed == "own" for other in kinds.names] for kind in kinds.names
        ],
    }


def own_parameters(flock: Flock) -> dict[str, NumberParameter]:
    """The parameters that may differ from agent to agent, by name, in the order of the columns of
    `Arrays.own`."""
    known = {one.name: one for one in declared(type(flock.parameters))}
    found = {name: known[name] for name in flock.model.individual}
    return {name: one for name, one in found.items() if isinstance(one, NumberParameter)}


def as_javascript(value: float) -> str:
    """A number as JavaScript reads it of text: JSON has no infinite ones, and no nan."""
    return {"inf": "Infinity", "nan": "NaN"}.get(str(value), str(value))


def finite_or_none(value: float) -> float | None:
    """A bound as JSON has it: None where there is none."""
    return value if math.isfinite(value) else None


# Sliders.


def slider_values(
    parameter: NumberParameter, name: str, value: float, of: list[Any], **changes: Any
) -> dict[str, Any]:
    """A slider of agents that differ, as the page's script has it; `of`: what it changes."""
    low, high = parameter.proposed
    values: dict[str, Any] = {
        "name": name,
        "symbol": parameter.symbol,
        "unit": parameter.unit,
        "words": parameter.words,
        "description": parameter.description,
        "low": low,
        "high": high,
        "step": parameter.step,
        "value": value,
        "slots": [],
        "of": of,
    } | changes
    low, high = values["low"], values["high"]
    return values | {"low": min(low, value), "high": max(high, value)}


def spread_slider(
    parameter: NumberParameter, name: str, spread: float, of: list[Any], **changes: Any
) -> dict[str, Any]:
    """The slider of a spread: up to a quarter of what the parameter's own slider spans."""
    low, high = parameter.proposed
    return slider_values(
        parameter,
        f"{name}.spread",
        spread,
        of,
        words=f"Spread of {parameter.words[0].lower()}{parameter.words[1:]}",
        description="How far agents differ: the standard deviation, or half the width.",
        low=0.0,
        high=round_up(0.25 * (high - low)),
        step=None if parameter.step is None else 0.1 * parameter.step,
        **changes,
    )


def own_sliders(flock: Flock, shared: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The sliders of a flock whose agents differ: those of all agents (`shared`, each with the
    spread behind it where there is one), then of each kind its numbers and relations.

    They are called `NAME`, `NAME.spread`, `KIND.NAME`, `KIND.NAME.spread`, `KIND.OTHER.weight`,
    `KIND.OTHER.radius` and `KIND.OTHER.catch`.
    """
    parameters = own_parameters(flock)
    names, draws = tuple(parameters), all_draws(flock)
    number = {(draw.column, draw.kind): k for k, draw in enumerate(draws)}
    found = []
    for slider in shared:
        name = slider["name"]
        if name not in names:
            found.append(slider)
            continue
        k = number[names.index(name), 0]
        found.append(slider | {"of": ["mean", k]})
        distribution = flock.individuals.get(name)
        if distribution is not None and has_spread(distribution):
            found.append(spread_slider(parameters[name], name, distribution.spread, ["spread", k]))
    for kind_number, kind in enumerate(flock.kinds.kinds, 1):
        group = {"group": kind.name}
        for name, value in kind.parameters.items():
            k = number[names.index(name), kind_number]
            one, own_name = parameters[name], f"{kind.name}.{name}"
            centre = float(value.centre if isinstance(value, Distribution) else value)
            found.append(slider_values(one, own_name, centre, ["mean", k], **group))
            if isinstance(value, Distribution) and has_spread(value):
                of = ["spread", k]
                found.append(spread_slider(one, own_name, value.spread, of, **group))
        found += relation_sliders(flock, kind.name)
    return [*found, *relation_sliders(flock, ORDINARY)]


def has_spread(distribution: Distribution) -> bool:
    """Whether a spread of it can be set."""
    return distribution.kind in ("normal", "lognormal", "uniform")


RELATIONS = {
    "weight": (WEIGHT, ": weight", "w", "1", "How much it counts beside what the rule wishes."),
    "radius": (RADIUS, " within", "R", "length", "How far they notice the others."),
    "catch": (CATCH, "", "c", "length", "The distance at which one is caught."),
}
"""Of each number of a relation its column in `Context.relations`, and what its slider says."""


def relation_sliders(flock: Flock, of: str) -> list[dict[str, Any]]:
    """The sliders of what is said of the relations of a kind to others.

    Where those who are chased flee because nothing else is said, they follow the chase: each slider
    says which cells of `Context.relations` it writes, and their sign.
    """
    kinds = flock.kinds
    number = {name: k for k, name in enumerate(kinds.names)}
    found = []
    for kind, other in kinds.explicit:
        relation = kinds.of(kind, other)
        if kind != of or relation.deed not in ("chase", "flee"):
            continue
        i, j = number[kind], number[other]
        sign = 1.0 if relation.deed == "chase" else -1.0
        has_back = (
            relation.deed == "chase" and kind != other and (other, kind) not in kinds.explicit
        )
        does = f"{'Chases' if relation.deed == 'chase' else 'Flees from'} {other}"
        for name, (column, words, symbol, unit, description) in RELATIONS.items():
            value = getattr(relation, name)
            if value is None or (name == "catch" and not value):
                continue
            high = HEAVIEST if name == "weight" else round_up(3.0 * value)
            cells = [[i, j, sign if name == "weight" else 1.0]]
            if has_back and name != "catch":
                cells.append([j, i, -sign if name == "weight" else 1.0])
            found.append(
                {
                    "name": f"{kind}.{other}.{name}",
                    "symbol": symbol,
                    "unit": unit,
                    "words": f"Catches {other} within" if name == "catch" else f"{does}{words}",
                    "description": description,
                    "low": 1e-2 * value if name == "radius" else 0.0,
                    "high": max(high, value),
                    "step": None,
                    "value": value,
                    "slots": [],
                    "of": ["relation", column, cells],
                    "group": kind,
                }
            )
    return found


def farthest_parameters(flock: Flock) -> Any:
    """The parameters as they would be of an agent that had the largest number that sliders allow of
    each: nobody sees farther."""
    largest: dict[str, float] = {}
    for one in own_parameters(flock).values():
        values = [flock.all_parameters[one.name]]
        values += [
            kind.parameters[one.name] for kind in flock.kinds.kinds if one.name in kind.parameters
        ]
        far = [
            max(one.proposed[1], value.centre) + largest_excess(one, value)
            if isinstance(value, Distribution)
            else max(one.proposed[1], value)
            for value in values
        ]
        largest[one.name] = min(max(far), one.bounds[1])
    return flock.parameters.model_copy(update=largest)


def largest_excess(parameter: NumberParameter, value: Distribution) -> float:
    """By how much an agent's number may be larger than the centre of a distribution."""
    if not has_spread(value):
        return max(value.numbers) - value.centre
    spread = max(round_up(0.25 * (parameter.proposed[1] - parameter.proposed[0])), value.spread)
    return spread if value.kind == "uniform" else FARTHEST * spread
