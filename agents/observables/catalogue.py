"""The observables by name, each with its unit and range, as functions of a flock."""

from __future__ import annotations

from agents.observables import consistency, fluctuations, of_flocks, order, rotation
from agents.observables.observable import Observable, over_a_run
from agents.observables.per_group import size_histogram
from worlds.plug_ins import plug_ins

ORDER = [
    Observable(
        "polarisation",
        "Length of the mean heading",
        "1",
        "[0, 1]",
        lambda flock: order.polarisation(flock.heading),
    ),
    Observable(
        "consistency",
        "Degree of consistency with the information agent's heading, or with the mean heading",
        "1",
        "[0, 1]",
        lambda flock: consistency.consistency(flock.heading, flock.reference),
    ),
    Observable(
        "angular-momentum",
        "How much the flock mills about its centre",
        "1",
        "[0, 1]",
        lambda flock: rotation.angular_momentum(
            flock.position, flock.heading, flock.world.size, flock.world.images
        ),
    ),
    Observable(
        "correlation-length",
        "How far velocity fluctuations hang together",
        "length",
        "[0, inf]",
        of_flocks.correlation_length,
    ),
    over_a_run(
        "susceptibility",
        "Variance of the polarisation over a run, times N",
        "1",
        "[0, N / 4]",
        fluctuations.susceptibility,
    ),
    over_a_run(
        "binder",
        "Binder's cumulant of the polarisation over a run",
        "1",
        "[-inf, 2/3]",
        lambda series, _: fluctuations.binder(series),
    ),
]
GROUPS = [
    Observable(
        "groups",
        "Connected groups of the r-graph",
        "groups",
        "[0, N]",
        of_flocks.number_of_groups,
    ),
    Observable(
        "largest-group",
        "Agents in the largest group",
        "agents",
        "[0, N]",
        of_flocks.largest_group,
    ),
    Observable(
        "group-polarisation",
        "Length of the mean heading of the largest group",
        "1",
        "[0, 1]",
        of_flocks.group_polarisation,
    ),
    Observable(
        "group-angular-momentum",
        "How much the largest group mills about its own centre",
        "1",
        "[0, 1]",
        of_flocks.group_angular_momentum,
    ),
    Observable(
        "group-sizes",
        "Groups of each size",
        "groups",
        "size -> [0, N]",
        lambda flock: size_histogram(flock.group_labels()),
        is_table=True,
    ),
    Observable(
        "group-table",
        "Agents, polarisation and angular momentum of each group, 0 the largest",
        "1",
        "group -> [0, N], [0, 1], [0, 1]",
        of_flocks.group_table,
        is_table=True,
    ),
]
NEIGHBOURS = [
    Observable(
        "mean-neighbours",
        "Mean number of neighbours within r",
        "agents",
        "[0, N - 1]",
        of_flocks.mean_neighbours,
    ),
    Observable(
        "nearest-neighbour",
        "Least distance between agents",
        "length",
        "[0, inf]",
        of_flocks.nearest,
    ),
    Observable(
        "connectivity",
        "Algebraic connectivity of the r-graph",
        "1",
        "[0, N]",
        of_flocks.connectivity,
        needs_links=True,
    ),
    Observable(
        "layers",
        "Agents in each layer below the information agents",
        "agents",
        "layer -> [0, N]",
        of_flocks.layer_histogram,
        is_table=True,
        needs_links=True,
    ),
]
WORLD = [
    Observable(
        "obstacle-distance",
        "Least distance of an agent to an obstacle or a solid edge",
        "length",
        "[-inf, inf]",
        of_flocks.obstacle_distance,
    ),
    Observable(
        "inside-obstacles",
        "Agents inside an obstacle or beyond a solid edge",
        "agents",
        "[0, N]",
        of_flocks.inside,
    ),
    Observable(
        "crashes",
        "Agents that have crashed",
        "agents",
        "[0, N]",
        of_flocks.crashes,
    ),
    Observable(
        "goal-distance",
        "Distance of the flock's centre to the goal or to the end of the path",
        "length",
        "[0, inf]",
        of_flocks.goal_distance,
    ),
    Observable(
        "following",
        "Share of agents linked to an information agent",
        "1",
        "[0, 1]",
        of_flocks.following,
        needs_links=True,
    ),
]
FLIGHT = [
    Observable(
        "drag-saved",
        "Induced drag saved by the others' upwash, mean",
        "%",
        "[-inf, inf]",
        of_flocks.drag_saved,
    ),
    Observable(
        "energy-saved",
        "Power saved by the others' upwash, mean, if 35 % of it is induced",
        "%",
        "[-inf, inf]",
        of_flocks.energy_saved,
    ),
]
BUILT_IN = {one.name: one for one in [*ORDER, *GROUPS, *NEIGHBOURS, *WORLD, *FLIGHT]}


def brought(_: str, thing: object) -> tuple[str, Observable]:
    """The observable that an entry point brings. Raises TypeError if it is none."""
    if not isinstance(thing, Observable):
        raise TypeError(f"an Observable is needed, not {type(thing).__name__}")
    return thing.name, thing


OBSERVABLES = BUILT_IN | plug_ins("flockscope.observables", brought, BUILT_IN)
"""All observables: the built-in ones, then those of other packages, which replace none of these."""
