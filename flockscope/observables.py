"""Observables as functions of arrays: for flocks, and for tracks of real animals and cars.

docs/observables.md says what each is; rows that hold no number are left out with a
`OmittedRowsWarning`.

>>> import numpy as np
>>> from flockscope.observables import polarisation
>>> polarisation(np.array([[1.0, 0.0], [-1.0, 0.0]]))
0.0
"""

from flockscope import _in_the_way  # noqa: F401 - it looks before the rest is imported

# isort: split
import sys

from agents.observables.anisotropy import (
    Anisotropy,
    isotropic_gamma,
    neighbour_anisotropy,
    range_of_structure,
)
from agents.observables.array_checks import OmittedRowsWarning
from agents.observables.consistency import consistency, convergence_time
from agents.observables.correlation import Correlation, correlation, correlation_length
from agents.observables.energy import furthest, hamiltonian
from agents.observables.following import (
    keep_following,
    least_clearances,
    nearest_pairs,
    settling_tick,
    spread_bound,
)
from agents.observables.formation import (
    Spacing,
    best_spacing,
    saved_shares,
    upwash_share,
    vee,
    vee_saved,
)
from agents.observables.groups import (
    algebraic_connectivity,
    angular_momenta,
    centres,
    group_labels,
    group_sizes,
    group_table,
    polarisations,
    size_histogram,
)
from agents.observables.lanes import lane_order
from agents.observables.leadership import Leadership, PairDelays, leadership, pair_delays
from agents.observables.neighbour_map import NeighbourMap, neighbour_map
from agents.observables.neighbours import (
    groups_within,
    layer_histogram,
    layers,
    links,
    mean_neighbours,
    nearest_neighbour,
    separation,
)
from agents.observables.observable import Observable, Range, Table
from agents.observables.of_agents import OfAgents
from agents.observables.order import (
    angular_momentum,
    binder,
    centre,
    gyration_radius,
    polarisation,
    susceptibility,
    velocity_spread,
)
from flockscope._old_names import old_names as _old_names

__all__ = [
    "Anisotropy",
    "Correlation",
    "Leadership",
    "NeighbourMap",
    "Observable",
    "OfAgents",
    "OmittedRowsWarning",
    "PairDelays",
    "Range",
    "Spacing",
    "Table",
    "algebraic_connectivity",
    "angular_momenta",
    "angular_momentum",
    "best_spacing",
    "binder",
    "centre",
    "centres",
    "consistency",
    "convergence_time",
    "correlation",
    "correlation_length",
    "furthest",
    "group_labels",
    "group_sizes",
    "group_table",
    "groups_within",
    "gyration_radius",
    "hamiltonian",
    "isotropic_gamma",
    "keep_following",
    "lane_order",
    "layer_histogram",
    "layers",
    "leadership",
    "least_clearances",
    "links",
    "mean_neighbours",
    "nearest_neighbour",
    "nearest_pairs",
    "neighbour_anisotropy",
    "neighbour_map",
    "pair_delays",
    "polarisation",
    "polarisations",
    "range_of_structure",
    "saved_shares",
    "separation",
    "settling_tick",
    "size_histogram",
    "spread_bound",
    "susceptibility",
    "upwash_share",
    "vee",
    "vee_saved",
    "velocity_spread",
]

__getattr__ = _old_names(sys.modules[__name__], {"LeftOut": "OmittedRowsWarning"})
