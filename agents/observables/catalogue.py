"""The observables by name, each with its unit and range, as functions of a flock."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import lru_cache
from typing import Any

from agents.kinds import INFORMED, NAME
from agents.observables import consistency, lanes, of_flocks, of_rows, order
from agents.observables.groups import size_histogram
from agents.observables.observable import (
    COUNT,
    LENGTH,
    SHARE,
    MonitorCard,
    Observable,
    Range,
    Table,
    over_a_run,
)
from agents.observables.of_flocks import SAVED
from worlds.input_error import unknown
from worlds.plug_ins import plug_ins

# Which flocks an observable says something of: each takes a flock in its world.


def among_solids(flock) -> bool:
    """Whether there is anything to run into."""
    return flock.world.is_solid


def is_in_corridor(flock) -> bool:
    """Whether its world is flat, goes on for ever along x and ends along y."""
    world = flock.world
    return world.dim == 2 and bool(world.wraps[0] and not world.wraps[1])


def has_mission_end(flock) -> bool:
    """Whether its mission has an end: a goal, or that of a path."""
    mission = flock.world.mission
    return mission is not None and (mission.goal is not None or mission.path is not None)


def has_informed(flock) -> bool:
    """Whether there are information agents."""
    return bool(flock.informed.any())


def has_informed_on_path(flock) -> bool:
    """Whether there are information agents that have a path to follow."""
    mission = flock.world.mission
    return mission is not None and mission.path is not None and has_informed(flock)


def has_sources(flock) -> bool:
    """Whether agents enter its world while it runs."""
    mission = flock.world.mission
    return mission is not None and bool(mission.sources)


def has_differences(flock) -> bool:
    """Whether its agents have numbers of their own."""
    return bool(flock.differing)


def has_kinds(flock) -> bool:
    """Whether a flock begins with agents of several kinds."""
    return any(kind.agents for kind in flock.kinds.kinds)


def is_of_several(flock) -> bool:
    """Whether its agents are of several kinds, or have numbers of their own."""
    return has_kinds(flock) or has_differences(flock)


def has_hunters(flock) -> bool:
    """Whether agents of a kind catch others."""
    return bool(flock.kinds.catchers)


def has_exits(flock) -> bool:
    """Whether agents leave its world while it runs."""
    mission = flock.world.mission
    return mission is not None and bool(mission.exits)


def can_crash(flock) -> bool:
    """Whether agents that touch something crash."""
    return flock.can_crash


def saves(flock) -> bool:
    """Whether its bodies measure what they save by each other's upwash."""
    return SAVED in flock.model.columns


def is_tracked(flock) -> bool:
    """Whether its agents are individuals of tracks, of which not all are seen all the time."""
    return flock.seen is not None


def is_compared(flock) -> bool:
    """Whether each of its agents has its counterpart in another flock."""
    return flock.paired is not None


ORDER = [
    Observable(
        "polarisation",
        "Length of the mean heading",
        "1",
        SHARE,
        lambda flock: order.polarisation(flock.heading),
        quick=True,
        card=MonitorCard("polarisation"),
        compiled=of_rows.polarisation,
    ),
    Observable(
        "consistency",
        "Degree of consistency with the information agent's heading, or with the mean heading",
        "1",
        SHARE,
        lambda flock: consistency.consistency(flock.heading, flock.reference),
        quick=True,
        applies=has_informed,
        beside="polarisation",
        card=MonitorCard("consistency", ".4f", of=lambda model: model.rule.led),
        compiled=of_rows.consistency,
    ),
    Observable(
        "direction",
        "Angle between the mean heading and the x axis",
        "deg",
        Range(0.0, 180.0),
        lambda flock: order.direction(flock.heading),
        quick=True,
        compiled=of_rows.direction,
        in_page=is_of_several,
    ),
    Observable(
        "angular-momentum",
        "How much the flock mills about its centre",
        "1",
        SHARE,
        lambda flock: order.angular_momentum(
            flock.position, flock.heading, flock.world.size, flock.world.images
        ),
        quick=True,
        beside="polarisation",
        card=MonitorCard("angular momentum"),
        compiled=of_rows.angular_momentum,
    ),
    Observable(
        "lane-order",
        "How far those who pass each other along x walk in lanes",
        "1",
        SHARE,
        lambda flock: lanes.lane_order(
            flock.position, flock.heading, flock.world.size, flock.world.images
        ),
        quick=True,
        tells=is_in_corridor,
        compiled=of_rows.lane_order,
        in_page=is_in_corridor,
    ),
    Observable(
        "correlation-length",
        "How far velocity fluctuations hang together",
        "length",
        LENGTH,
        of_flocks.correlation_length,
    ),
    Observable(
        "velocity-spread",
        "Root mean square difference of the velocities from their mean",
        "length/time",
        LENGTH,
        lambda flock: order.velocity_spread(flock.heading * flock.speed[:, None]),
        quick=True,
        compiled=of_rows.velocity_spread,
    ),
    Observable(
        "fast-in-front",
        "Rank correlation of the agents' speeds with their places along the mean heading",
        "1",
        Range(-1.0, 1.0),
        lambda flock: order.fast_in_front(
            flock.position,
            flock.heading * flock.speed[:, None],
            flock.world.size,
            flock.world.images,
        ),
        quick=True,
        applies=has_differences,
        compiled=of_rows.fast_in_front,
    ),
    over_a_run(
        "susceptibility",
        "Variance of the polarisation over a run, times N",
        "1",
        Range(0.0, limit="N / 4"),
        order.susceptibility,
    ),
    over_a_run(
        "binder",
        "Binder's cumulant of the polarisation over a run",
        "1",
        Range(high=2.0 / 3.0, limit="2/3"),
        lambda series, _: order.binder(series),
    ),
]
NEIGHBOURS = [
    Observable(
        "mean-neighbours",
        "Mean number of neighbours within r",
        "agents",
        Range(0.0, limit="N - 1"),
        of_flocks.mean_neighbours,
        card=MonitorCard("neighbours", ".1f"),
        compiled=of_rows.mean_neighbours,
    ),
    Observable(
        "nearest-neighbour",
        "Least distance between agents",
        "length",
        LENGTH,
        of_flocks.nearest,
        tells=among_solids,
        compiled=of_rows.nearest_neighbour,
    ),
    Observable(
        "gyration-radius",
        "Root mean square distance of the agents from their centre",
        "length",
        LENGTH,
        lambda flock: order.gyration_radius(flock.position, flock.world.size, flock.world.images),
        quick=True,
        compiled=of_rows.gyration_radius,
    ),
    Observable(
        "connectivity",
        "Algebraic connectivity of the r-graph",
        "1",
        COUNT,
        of_flocks.connectivity,
        needs_links=True,
    ),
    Observable(
        "layers",
        "Agents in each layer below the information agents",
        "agents",
        Table("layer", (COUNT,)),
        of_flocks.layer_histogram,
        needs_links=True,
    ),
]
WORLD = [
    Observable(
        "obstacle-distance",
        "Least distance of an agent to an obstacle or a solid edge",
        "length",
        Range(),
        of_flocks.obstacle_distance,
        applies=among_solids,
        tells=among_solids,
    ),
    Observable(
        "inside-obstacles",
        "Agents inside an obstacle or beyond a solid edge",
        "agents",
        COUNT,
        of_flocks.inside,
        applies=among_solids,
        tells=among_solids,
    ),
    Observable(
        "goal-distance",
        "Distance of the flock's centre to the goal or to the end of the path",
        "length",
        LENGTH,
        of_flocks.goal_distance,
        quick=True,
        applies=has_mission_end,
        tells=has_mission_end,
        card=MonitorCard(
            lambda world: "to goal" if world.mission.goal is not None else "to path's end",
            part="way",
        ),
        compiled=of_rows.goal_distance,
    ),
    Observable(
        "following",
        "Share of agents linked to an information agent",
        "1",
        SHARE,
        of_flocks.following,
        needs_links=True,
        applies=has_informed,
        tells=has_informed_on_path,
        card=MonitorCard("following", ".0%", part="team"),
    ),
]
GROUPS = [
    Observable(
        "groups",
        "Connected groups of the r-graph",
        "groups",
        COUNT,
        of_flocks.number_of_groups,
        tells=can_crash,
        card=MonitorCard("groups"),
        compiled=of_rows.groups,
    ),
    Observable(
        "largest-group",
        "Agents in the largest group",
        "agents",
        COUNT,
        of_flocks.largest_group,
        card=MonitorCard("largest group"),
        compiled=of_rows.largest_group,
    ),
    Observable(
        "group-polarisation",
        "Length of the mean heading of the largest group",
        "1",
        SHARE,
        of_flocks.group_polarisation,
    ),
    Observable(
        "group-angular-momentum",
        "How much the largest group mills about its own centre",
        "1",
        SHARE,
        of_flocks.group_angular_momentum,
    ),
    Observable(
        "group-sizes",
        "Groups of each size",
        "groups",
        Table("size", (COUNT,)),
        lambda flock: size_histogram(flock.group_labels()),
    ),
    Observable(
        "group-table",
        "Agents, polarisation and angular momentum of each group, 0 the largest",
        "1",
        Table("group", (COUNT, SHARE, SHARE)),
        of_flocks.group_table,
    ),
]
GATES = [
    Observable(
        "entered",
        "Agents that have entered through sources",
        "agents",
        LENGTH,
        of_flocks.entered,
        quick=True,
        events=lambda flock: flock.entries.tick,
        applies=has_sources,
        tells=has_sources,
    ),
    Observable(
        "waiting-to-enter",
        "Agents that are due at a source and find no free place in it",
        "agents",
        LENGTH,
        of_flocks.waiting,
        quick=True,
        applies=has_sources,
        tells=has_sources,
    ),
    Observable(
        "exited",
        "Agents that have left through exits",
        "agents",
        LENGTH,
        of_flocks.exited,
        quick=True,
        events=lambda flock: flock.exits.tick,
        applies=has_exits,
        tells=has_exits,
    ),
    Observable(
        "flow",
        "Flow out of the exits, (N - 1) / (t_N - t_1) of the N agents that have left so far",
        "agents/time",
        LENGTH,
        of_flocks.flow,
        quick=True,
        applies=has_exits,
        tells=has_exits,
    ),
]
KINDS = [
    Observable(
        "catches",
        "Agents that were caught by those who chase them",
        "agents",
        LENGTH,
        of_flocks.catches,
        quick=True,
        events=lambda flock: flock.catches.tick,
        applies=has_hunters,
        tells=has_hunters,
        compiled=of_rows.catches,
    ),
    Observable(
        "kind-distance",
        "Distance to the nearest agent of another kind, mean of all agents",
        "length",
        LENGTH,
        of_flocks.kind_distance,
        applies=has_kinds,
        tells=has_kinds,
        compiled=of_rows.kind_distance,
    ),
    Observable(
        "kind-mixing",
        "Share of pairs within reach of each other that are of two kinds",
        "1",
        SHARE,
        of_flocks.kind_mixing,
        applies=has_kinds,
        compiled=of_rows.kind_mixing,
    ),
]
FLIGHT = [
    Observable(
        "crashes",
        "Agents that have crashed",
        "agents",
        COUNT,
        of_flocks.crashes,
        events=lambda flock: flock.crashes.tick,
        applies=can_crash,
        tells=can_crash,
        compiled=of_rows.crashes,
    ),
    Observable(
        "drag-saved",
        "Induced drag saved by the others' upwash, mean",
        "%",
        Range(),
        of_flocks.drag_saved,
        quick=True,
        applies=saves,
        card=MonitorCard("drag saved"),
    ),
    Observable(
        "energy-saved",
        "Power saved by the others' upwash, mean, if 35 % of it is induced",
        "%",
        Range(),
        of_flocks.energy_saved,
        quick=True,
        applies=saves,
        tells=saves,
        beside="drag-saved",
        card=MonitorCard("power saved"),
        saves_power=True,
    ),
]
TRACKS = [
    Observable(
        "number-seen",
        "Individuals of tracks that are seen",
        "agents",
        COUNT,
        lambda flock: float(len(flock.ids)),
        quick=True,
        applies=is_tracked,
        card=MonitorCard("seen now"),
    ),
    Observable(
        "divergence",
        "Mean distance of individuals from their counterparts in a model",
        "length",
        LENGTH,
        of_flocks.divergence,
        quick=True,
        applies=is_compared,
        card=MonitorCard("divergence"),
    ),
]
BUILT_IN = {
    observable.name: observable
    for observable in [*ORDER, *NEIGHBOURS, *WORLD, *GROUPS, *GATES, *KINDS, *FLIGHT, *TRACKS]
}


def observable_of_entry(_: str, entry: object) -> tuple[str, Observable]:
    """The observable that an entry point brings. Raises TypeError if it is none."""
    if not isinstance(entry, Observable):
        raise TypeError(f"an Observable is needed, not {type(entry).__name__}")
    return entry.name, entry


OBSERVABLES = BUILT_IN | plug_ins("flockscope.observables", observable_of_entry, BUILT_IN)
"""All observables: the built-in ones, then those of other packages, which replace none of these."""


# The same of the agents of a kind alone: `polarisation of shark`.

OF_KIND = " of "
BY_KIND = ("polarisation", "angular-momentum")
"""What is measured of each kind by itself."""


def name_of_kind(name: str, kind: str) -> str:
    """What an observable of the agents of a kind alone is called.

    >>> name_of_kind("polarisation", "shark")
    'polarisation of shark'
    """
    return f"{name}{OF_KIND}{kind}"


def title_of_kind(title: str, kind: str) -> str:
    """The title of an observable of the agents of a kind alone."""
    return f"{title}, of the agents of kind {kind}"


def kind_observables(flock: Any) -> list[str]:
    """What is measured of each kind of a flock, none where there are no kinds."""
    if not has_kinds(flock):
        return []
    return [name_of_kind(name, kind) for name in BY_KIND for kind in flock.kinds.names]


def is_observable(name: str) -> bool:
    """Whether there is an observable of a name, or one of a kind alone."""
    whole, sign, kind = name.partition(OF_KIND)
    return name in OBSERVABLES or (whole in BY_KIND and bool(sign and NAME.fullmatch(kind)))


@lru_cache(maxsize=256)
def find_observable(name: str) -> Observable:
    """An observable by its name, or that of the agents of a kind alone. Raises InputError.

    What is of a kind takes a snapshot, and raises InputError for a kind that is not in it.
    """
    if name in OBSERVABLES:
        return OBSERVABLES[name]
    if not is_observable(name):
        raise unknown("observable", name, OBSERVABLES)
    whole, _, kind = name.partition(OF_KIND)
    one = OBSERVABLES[whole]

    def measure(snapshot: Any) -> Any:
        return one.measure(snapshot.of_kind(kind))

    return replace(
        one,
        name=name,
        title=title_of_kind(one.title, kind),
        measure=measure,
        applies=lambda flock: has_kinds(flock) or (kind == INFORMED and has_informed(flock)),
        quick=False,
        card=None,
        beside="",
        compiled=None,
    )


ORDERED = ("polarisation", "consistency", "mean-neighbours")
"""What tells most of flocks that come to agree on a heading."""
MILLING = ("polarisation", "angular-momentum", "groups")
"""What tells most of flocks that may also go round and round, or fall apart."""
ENDS = ("crashes", "exited", "catches", "goal-distance")
"""What a flock that has one of them is to have a chart of."""
CHARTS = 3


def main_observables(model: Any) -> tuple[str, ...]:
    """The observables that tell how a model's flocks do, as it declares them, or by its kind.

    Raises InputError if it declares one that there is not.
    """
    for name in model.tells:
        if name not in OBSERVABLES:
            raise unknown("observable", name, OBSERVABLES, f"model {model.name}")
    return model.tells or (MILLING if model.rule.zones else ORDERED)


def telling_observables(flock: Any) -> list[str]:
    """What tells how a flock does: what its model declares, then what its world gives occasion for.

    An observable that says nothing of this flock is not among them.
    """
    own = [name for name in main_observables(flock.model) if OBSERVABLES[name].applies(flock)]
    return own + [
        name
        for name, observable in OBSERVABLES.items()
        if observable.tells(flock) and name not in own
    ]


def default_charts(model: Any, available: Collection[str]) -> tuple[tuple[str, ...], ...]:
    """What tells most of a model's flocks that have these observables: three charts, some empty.

    What it declares, two in one chart where they may share it; the last is of crashes, or of the
    way to a goal, where a flock has that.
    """
    charts: list[tuple[str, ...]] = []
    for name in main_observables(model):
        companion = OBSERVABLES[name].beside
        if name not in available:
            continue
        if charts and companion and charts[-1] == (companion,):
            charts[-1] = (companion, name)
        else:
            charts.append((name,))
    used_names = [name for chart in charts for name in chart]
    ends = [(name,) for name in ENDS if name in available and name not in used_names][:1]
    charts = charts[: CHARTS - len(ends)]
    no_names: tuple[str, ...] = ()
    return (*charts, *[no_names] * (CHARTS - len(charts) - len(ends)), *ends)
