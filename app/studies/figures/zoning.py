"""Zones and field of view of an agent, its neighbourhood, and what follows from who is where."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from agents.inspection import NO_POINTS, as_me, as_near, field_of_view
from agents.inspection import shells as shells_of
from agents.models.model_calls import call
from agents.observables.neighbours import separation
from app.studies.charts.boxes import draw_key
from app.studies.charts.scheme_marks import (
    BLIND,
    FAINT,
    INK,
    ZONE_COLOURS,
    ZONE_FILLS,
    arrow,
    draw_dart,
    rotate_vector,
    set_square_view,
    sign,
    stroke,
    write_label,
)
from app.studies.experiment import Experiment, flock_of
from app.studies.measure import PERCENT, Measure, Number, Settings
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents import Flock

# Who is in which zone, who is seen, and what follows: the thesis, figures 3.1 to 3.4 and 4.3.

NOBODY, REPELLED, ALIGNED, ATTRACTED, BOTH = range(5)
"""What an agent goes by: nobody is seen, (3.9), (3.10), (3.11), (3.12)."""
BRANCHES = ("nobody", "repelled", "aligned", "attracted", "both")
SURE = 1e-6
"""Places so near to the edge of a zone (length) or of the view (cosine) are not asked about."""


class AgentNeighbours(NamedTuple):
    """The others as one agent has them."""

    apart: np.ndarray
    """Vectors to their nearest images, (M, dim), length."""
    heading: np.ndarray
    """Their headings, (M, dim)."""
    zone: np.ndarray
    """0, 1, 2: repulsion, orientation, attraction; -1: none, or out of view; (M,) int."""


class ZoningSettings(Settings):
    """How often the zones are looked at."""

    kind: ClassVar[str] = "zoning"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("wrong", "wrong", "Places that the rule has in another zone", "places", whole=True),
        Measure("seen", "seen", "Places within the zones that are noticed", "%", bounds=PERCENT),
        Measure("nobody", "nobody", "Agents that notice nobody", "%", bounds=PERCENT),
        Measure("repelled", "(3.9)", "Agents that are repelled", "%", bounds=PERCENT),
        Measure("aligned", "(3.10)", "Agents that align only", "%", bounds=PERCENT),
        Measure("attracted", "(3.11)", "Agents that are attracted only", "%", bounds=PERCENT),
        Measure("both", "(3.12)", "Agents that do both", "%", bounds=PERCENT),
        Measure("off", "off", "Largest angle of a wish from (3.9) to (3.12)", "deg"),
        Measure("turned", "turned", "Largest turn in a tick", "deg"),
    )

    looks: int = Field(400, ge=1)
    """Places around an agent that its rule is asked about, at random within 1.2 of its reach."""
    sight: float | None = Field(None, gt=0.0)
    """A distance of sight that the source names and the rule does not use: drawn, length."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Ask the rule about places around an agent, and about all agents as they are."""
        between()
        rng = np.random.default_rng(flock.seed)
        places = 1.2 * flock.reach * rng.uniform(-1.0, 1.0, (self.looks, flock.world.dim))
        sure = is_off_edges(flock, places)
        zone, expected = zones_by_rule(flock, 0, places), zones_by_hand(flock, 0, places)
        inside = np.linalg.norm(places, axis=1) <= flock.reach
        around = [neighbours_by_definition(flock, row) for row in range(len(flock.ids))]
        branch = np.array([branch_of(neighbourhood.zone) for neighbourhood in around])
        wishes = [rule_direction(flock, row) for row in range(len(flock.ids))]
        off = max(
            angle_between(wish, expected_wish(neighbourhood, flock.heading[row]))
            for row, (wish, neighbourhood) in enumerate(zip(wishes, around, strict=True))
        )
        before = flock.heading.copy()
        flock.run(1)
        shares: dict[str, Number | None] = {
            name: 100.0 * float((branch == k).mean()) for k, name in enumerate(BRANCHES)
        }
        return shares | {
            "wrong": int((zone != expected)[sure].sum()),
            "seen": 100.0 * float((expected[inside] >= 0).mean()),
            "off": off,
            "turned": max(map(angle_between, before, flock.heading)),
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """One; asking about a place counts as one more."""
        return 1.0 + self.looks


def zones_by_rule(flock: Flock, row: int, places: np.ndarray) -> np.ndarray:
    """The zone of places (M, dim) from an agent, (M,) int: the rule is asked of each by itself.

    What it weighs another agent with that stands there says whether it is noticed; the zone is by
    the distance. -1 where it is not.
    """
    radii = np.array([shell.radius for shell in shells_of(flock)])
    signals = flock.arrays.memory
    me = as_me(flock, row, signals[:, row].copy())
    other = np.array([row])
    zones = np.full(len(places), -1)
    weigh, parameters = flock.model.rule.weigh, flock.context.parameters
    if weigh is None:
        raise InputError(f"{flock.model.name} weighs no others: it has no zones to look at")
    for k, apart in enumerate(places):
        near = as_near(flock, row, other, apart[None], signals, NO_POINTS)
        weight = np.zeros(1)
        call(flock.model, flock.interpret, weigh, me, near, parameters, weight)
        if weight[0] > 0.0:
            zone = int(np.searchsorted(radii, np.linalg.norm(apart), side="right"))
            zones[k] = min(zone, len(radii) - 1)
    return zones


def zones_by_hand(flock: Flock, row: int, places: np.ndarray) -> np.ndarray:
    """The same by distance and angle alone: the definition of the zones and of the view."""
    shells, view = shells_of(flock), field_of_view(flock)
    d = np.linalg.norm(places, axis=1)
    cosine = np.clip(places @ flock.heading[row] / np.where(d > 0.0, d, 1.0), -1.0, 1.0)
    in_view = np.degrees(np.arccos(cosine)) <= 0.5 * view
    zones = np.full(len(places), -1)
    for k in reversed(range(len(shells))):
        zones[(d <= shells[k].radius) & (in_view | shells[k].all_round)] = k
        if not shells[k].all_round:  # who is too near to be seen there is not in the next either
            zones[(d <= shells[k].radius) & ~in_view] = -1
    return zones


def is_off_edges(flock: Flock, places: np.ndarray) -> np.ndarray:
    """Which of places (M, dim) from row 0 lie on no edge, (M,) bool."""
    d = np.linalg.norm(places, axis=1)
    gap = np.min([np.abs(d - shell.radius) for shell in shells_of(flock)], axis=0)
    cosine = places @ flock.heading[0] / d
    return (gap > SURE) & (np.abs(cosine - np.cos(np.radians(0.5 * field_of_view(flock)))) > SURE)


def neighbours_by_definition(flock: Flock, row: int) -> AgentNeighbours:
    """The others within reach of an agent, and their zones by definition."""
    others = np.array([k for k in np.flatnonzero(flock.active) if k != row], int)
    apart = separation(
        flock.position[row], flock.position[others], flock.world.size, flock.world.images
    )
    near = np.linalg.norm(apart, axis=1) <= flock.reach
    apart, others = apart[near], others[near]
    return AgentNeighbours(apart, flock.heading[others], zones_by_hand(flock, row, apart))


def branch_of(zone: np.ndarray) -> int:
    """Which of (3.9) to (3.12) an agent goes by that has others in these zones."""
    if (zone == 0).any():
        return REPELLED
    aligns, follows = (zone == 1).any(), (zone == 2).any()
    if aligns and follows:
        return BOTH
    return ALIGNED if aligns else ATTRACTED if follows else NOBODY


def expected_wish(around: AgentNeighbours, heading: np.ndarray) -> np.ndarray:
    """The direction of (3.6) to (3.12), (dim,); the heading where there is none."""
    to = around.apart / np.linalg.norm(around.apart, axis=1, keepdims=True)
    zone = around.zone
    if (zone == 0).any():
        wish = -to[zone == 0].sum(axis=0)
    else:
        wish = around.heading[zone == 1].sum(axis=0) + to[zone == 2].sum(axis=0)
    length = float(np.linalg.norm(wish))
    return wish / length if length > 1e-9 else heading


def rule_direction(flock: Flock, row: int) -> np.ndarray:
    """The direction that the rule itself wishes for, (dim,); the heading where it has no wish."""
    signals = flock.arrays.memory
    inspection = flock.inspect(row)
    me = as_me(flock, row, signals[:, row].copy())
    near = as_near(flock, row, inspection.neighbours, inspection.separation, signals, NO_POINTS)
    decide = flock.model.rule.decide
    if decide is None:
        raise InputError(f"{flock.model.name} decides in pairs: it cannot be asked by itself")
    surroundings, parameters = flock.engine.surroundings, flock.context.parameters
    wish = call(flock.model, flock.interpret, decide, me, near, surroundings, parameters)
    direction = np.array([wish.x, wish.y, wish.z][: flock.world.dim])
    length = float(np.linalg.norm(direction))
    return direction / length if length > 1e-9 else flock.heading[row].copy()


def angle_between(a: np.ndarray, b: np.ndarray) -> float:
    """Angle of two unit vectors (dim,), deg."""
    return float(np.degrees(2.0 * np.arctan2(np.linalg.norm(a - b), np.linalg.norm(a + b))))


WISH, TURN = "#c0392b", "#7b5ea7"
NAMES = ("zor, repulsion", "zoo, orientation", "zoa, attraction")
CELLS = 220
"""Places along each side that the rule is asked about."""
ROOM = 1.12
SEEDS = 200
"""Flocks among which occasions are looked for."""


def draw_zones(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the zones of an agent of the first row's flock of that seed, with the others there."""
    flock, row = choose_example(experiment, seed)
    figure.set_size_inches(8.6, 7.6)
    axes = figure.subplots()
    draw_ground(axes, flock, row)
    draw_rims(axes, flock, row)
    draw_others(axes, flock, row)
    mark_view(axes, flock, row, sight_distance(experiment))
    set_square_view(axes, np.zeros(2), ROOM * flock.reach)
    draw_key(figure, signs(), scheme_caption(experiment, seed, flock, row))


def sight_distance(experiment: Experiment) -> float | None:
    """The distance of sight that the source names, length."""
    settings = experiment.settings
    assert isinstance(settings, ZoningSettings)
    return settings.sight


def choose_example(experiment: Experiment, seed: int) -> tuple[Any, int]:
    """The first row's flock of that seed, and its agent with others in the most zones."""
    flock = flock_of(experiment.cases[0], seed)

    def worth(row: int) -> tuple[int, int]:
        zone = neighbours_by_definition(flock, row).zone
        return len(set(zone.tolist())), len(zone)

    return flock, max(range(len(flock.ids)), key=worth)


def scheme_caption(experiment: Experiment, seed: int, flock: Any, row: int) -> str:
    """What is drawn, in a line."""
    case = experiment.cases[0]
    return (
        f"ground: the zone in which the rule of {case.label} has another agent at that place; "
        f"agent {flock.ids[row]} of {case.agents}, seed {seed}"
    )


def signs() -> list[Any]:
    """What is what."""
    handles = [sign(colour, name, ">") for colour, name in zip(ZONE_COLOURS, NAMES, strict=True)]
    return [sign(INK, "the agent", ">"), *handles, sign(FAINT, "not noticed", ">", hollow=True)]


def draw_ground(axes: Any, flock: Any, row: int, alpha: float = 1.0) -> None:
    """Colour all places around an agent by the zone in which its rule has another one there."""
    from matplotlib.colors import ListedColormap

    half = ROOM * flock.reach
    at = (np.arange(CELLS) + 0.5) / CELLS * 2.0 * half - half
    x, y = np.meshgrid(at, at)
    zone = zones_by_rule(flock, row, np.column_stack([x.ravel(), y.ravel()])).reshape(x.shape)
    colour_index = np.where((zone < 0) & (x * x + y * y <= flock.reach**2), 3, zone)
    axes.imshow(
        np.ma.masked_less(colour_index, 0), vmin=0, vmax=3,
        cmap=ListedColormap([*ZONE_FILLS, BLIND]),
        extent=(-half, half, -half, half), origin="lower", interpolation="nearest", zorder=0,
        alpha=alpha,
    )  # fmt: skip


def draw_rims(axes: Any, flock: Any, row: int) -> None:
    """Draw the zones' outer radii with their names."""
    from matplotlib.patches import Circle

    shells = flock.inspect(row).shells
    symbols = [zone_symbol(flock, shell.radius, k) for k, shell in enumerate(shells)]
    back = -flock.heading[row][:2]
    for k, shell in enumerate(shells):
        axes.add_patch(
            Circle((0.0, 0.0), shell.radius, fill=False, edgecolor=ZONE_COLOURS[k], linewidth=1.3,
                   zorder=2)
        )  # fmt: skip
        at = shell.radius * rotate_vector(back, (-78.0, -38.0, -14.0)[k])
        write_label(axes, at, symbols[k], ZONE_COLOURS[k], size=9.5)


def zone_symbol(flock: Any, radius: float, k: int) -> str:
    """How the source calls the outer radius of zone k, with its value."""
    letter = "d" if hasattr(flock.parameters, "d_r") else "r"
    return f"${letter}_{'roa'[k]}$ = {radius:.3g}"


def draw_others(axes: Any, flock: Any, row: int) -> AgentNeighbours:
    """Draw an agent in the middle and the others in the colours of their zones."""
    around = neighbours_by_definition(flock, row)
    size = 0.075 * flock.reach
    for apart, heading, zone in zip(around.apart, around.heading, around.zone, strict=True):
        colour = ZONE_COLOURS[zone] if zone >= 0 else FAINT
        draw_dart(axes, apart, heading, colour, size, hollow=zone < 0)
    draw_dart(axes, np.zeros(2), flock.heading[row], INK, 1.35 * size)
    return around


def mark_view(axes: Any, flock: Any, row: int, sight: float | None) -> None:
    """Draw the edges of the field of view with its angle, and the source's distance of sight."""
    from matplotlib.patches import Arc

    view, heading = flock.inspect(row).view, flock.heading[row]
    for side in (-0.5, 0.5):
        edge = flock.reach * rotate_vector(heading, side * view)
        axes.plot([0.0, edge[0]], [0.0, edge[1]], color=INK, linewidth=1.0, zorder=3,
                  linestyle=(0, (5, 3)))  # fmt: skip
    way = float(np.degrees(np.arctan2(heading[1], heading[0])))
    near = 0.3 * flock.reach
    axes.add_patch(
        Arc((0.0, 0.0), 2.0 * near, 2.0 * near, theta1=way - 0.5 * view, theta2=way + 0.5 * view,
            color=INK, linewidth=1.2, zorder=4)
    )  # fmt: skip
    write_label(axes, near * rotate_vector(heading, 0.32 * view), f"$\\alpha$ = {view:g}°")
    back = 360.0 - view
    write_label(
        axes, 0.72 * flock.reach * rotate_vector(-heading, 0.25 * back), f"unseen: {back:g}°",
        INK, size=9.0,
    )  # fmt: skip
    if sight is not None:
        axes.add_patch(
            Arc((0.0, 0.0), 2.0 * sight, 2.0 * sight, theta1=way - 0.5 * view,
                theta2=way + 0.5 * view, color=WISH, linewidth=1.6, linestyle=(0, (3, 2)), zorder=4)
        )  # fmt: skip
        write_label(
            axes, sight * rotate_vector(heading, -0.3 * view), f"$d$ = {sight:g}", WISH, size=9.5
        )


def draw_view(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the field of view of an agent: all places that its rule notices another one at."""
    flock, row = choose_example(experiment, seed)
    figure.set_size_inches(7.6, 6.9)
    axes = figure.subplots()
    half = ROOM * flock.reach
    at = (np.arange(CELLS) + 0.5) / CELLS * 2.0 * half - half
    x, y = np.meshgrid(at, at)
    in_view = (
        zones_by_rule(flock, row, np.column_stack([x.ravel(), y.ravel()])).reshape(x.shape) >= 0
    )
    shade = np.zeros((*x.shape, 4))
    shade[in_view] = (0.74, 0.77, 0.81, 1.0)
    axes.imshow(shade, extent=(-half, half, -half, half), origin="lower", zorder=0)
    draw_others(axes, flock, row)
    mark_view(axes, flock, row, sight_distance(experiment))
    set_square_view(axes, np.zeros(2), half)
    case = experiment.cases[0]
    draw_key(
        figure, signs(),
        f"grey: where the rule of {case.label} notices another agent; red: the distance of sight "
        "d\nthat the source names and no equation of it uses; "
        f"agent {flock.ids[row]} of {case.agents}, seed {seed}",
    )  # fmt: skip


def draw_neighbourhood(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw who is whose neighbour, and the neighbourhood of one agent."""
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Circle

    case = experiment.cases[0]
    flock = flock_of(case, seed)
    figure.set_size_inches(8.2, 7.4)
    axes = figure.subplots()
    middle = np.array(flock.world.low) + 0.5 * np.array(flock.world.size)
    row = int(np.linalg.norm(flock.position - middle, axis=1).argmin())
    pairs = flock.links()
    mine = (pairs == row).any(axis=1)
    for rows, colour, width in ((~mine, "#c9d1da", 0.8), (mine, ZONE_COLOURS[2], 1.6)):
        axes.add_collection(
            LineCollection(list(flock.position[pairs[rows]]), colors=colour, linewidths=width)
        )
    own = flock.position[row]
    axes.add_patch(
        Circle(own, flock.reach, facecolor=ZONE_FILLS[2], edgecolor=ZONE_COLOURS[2], zorder=0.5)
    )
    near = set(pairs[mine].ravel().tolist()) - {row}
    size = 0.03 * float(flock.world.size[0])
    for k in range(len(flock.ids)):
        colour = INK if k == row else ZONE_COLOURS[2] if k in near else FAINT
        length = size * (1.5 if k == row else 1.0)
        is_hollow = k != row and k not in near
        draw_dart(axes, flock.position[k], flock.heading[k], colour, length, hollow=is_hollow)
    edge = own + flock.reach * rotate_vector(np.array([1.0, 0.0]), 50.0)
    axes.plot(*np.array([own, edge]).T, color=INK, linewidth=1.0, linestyle=(0, (4, 3)))
    write_label(axes, 0.5 * (own + edge), f"$r$ = {flock.reach:g}", size=9.5)
    write_label(axes, own, "$i$", shift=(-13, -11))
    set_square_view(axes, middle, 0.54 * float(flock.world.size[0]))
    draw_key(
        figure,
        [
            sign(INK, "agent i", ">"),
            sign(ZONE_COLOURS[2], f"its {len(near)} neighbours (3.4)", ">"),
            sign(FAINT, "others", ">", hollow=True),
            stroke("#c9d1da", "edges (3.5)", width=1.2),
        ],
        f"{case.label}, N = {case.agents}, seed {seed}; the thesis gives no value of r: here it is "
        "the radius of the zone of attraction",
    )


CASES = (
    (REPELLED, "a", "(3.9) someone in zor: away"),
    (ALIGNED, "b", "(3.10) in zoo only: align"),
    (ATTRACTED, "c", "(3.11) in zoa only: go there"),
    (BOTH, "d", "(3.12) in zoo and zoa: the mean"),
)
"""What an agent goes by, and what its panel says."""


def draw_cases(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw an occasion of each of (3.9) to (3.12), from the first flocks that have one."""
    figure.set_size_inches(12.0, 11.4)
    panels = figure.subplots(2, 2).ravel()
    for axes, (branch, letter, words) in zip(panels, CASES, strict=True):
        example = find_branch_example(experiment, seed, branch)
        axes.set_title(f"({letter}) {words}", loc="left")
        if example is None:
            set_square_view(axes, np.zeros(2), 1.0)
            write_label(axes, np.zeros(2), f"in none of {SEEDS} flocks")
            continue
        draw_case(axes, *example)
    draw_key(
        figure,
        [
            *signs(),
            stroke(WISH, "the wish of the rule"),
            stroke(TURN, "the heading a tick later"),
        ],
        f"agents of {experiment.cases[0].label} from the first flocks from seed {seed} on that "
        "have such an occasion; lines: who counts; thin arrows: headings that count",
    )


def find_branch_example(experiment: Experiment, seed: int, branch: int) -> tuple[Any, int] | None:
    """A flock and an agent of it that goes by a branch, with two or three that count."""
    for k in range(SEEDS):
        flock = flock_of(experiment.cases[0], seed + k)
        for row in range(len(flock.ids)):
            zone = neighbours_by_definition(flock, row).zone
            counts = int((zone == 0).sum() if branch == REPELLED else (zone > 0).sum())
            if branch_of(zone) == branch and 2 <= counts <= 4:
                return flock, row
    return None


def draw_case(axes: Any, flock: Any, row: int) -> None:
    """Draw an agent, who counts for it, its wish and its heading a tick later."""
    draw_ground(axes, flock, row)
    draw_rims(axes, flock, row)
    around = draw_others(axes, flock, row)
    repelled = (around.zone == 0).any()
    reach = flock.reach
    for apart, heading, zone in zip(around.apart, around.heading, around.zone, strict=True):
        if zone == 0 or (zone > 0 and not repelled):
            axes.plot([0.0, apart[0]], [0.0, apart[1]], color=ZONE_COLOURS[zone], linewidth=1.0)
            if zone == 1:
                arrow(axes, apart, 0.2 * reach * heading, ZONE_COLOURS[1], 1.2, 6.0)
    arrow(axes, np.zeros(2), 0.5 * reach * rule_direction(flock, row), WISH, 2.4)
    flock.run(1)
    arrow(axes, np.zeros(2), 0.38 * reach * flock.heading[row], TURN, 1.8, 8.5)
    set_square_view(axes, np.zeros(2), ROOM * reach)


PICTURES = {
    "zones": draw_zones,
    "view": draw_view,
    "neighbourhood": draw_neighbourhood,
    "cases": draw_cases,
}
