"""The picture of an experiment, written as PNG and SVG."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from app.figure import write_figure
from app.results_folder import PICTURES
from app.studies.experiment import Experiment
from app.studies.pictures.consensus_picture import draw_consensus
from app.studies.pictures.convergence.convergence_sweeps import draw_sweeps
from app.studies.pictures.convergence.evolution_picture import draw_evolution
from app.studies.pictures.convergence.models import draw_models
from app.studies.pictures.convergence.pairs import draw_pairs
from app.studies.pictures.crowding_picture import draw_crowding
from app.studies.pictures.diffusion_picture import draw_diffusion
from app.studies.pictures.driving_picture import draw_driving
from app.studies.pictures.endurance import draw_endurance
from app.studies.pictures.energy_picture import draw_energy
from app.studies.pictures.formation_picture import draw_formation
from app.studies.pictures.gallery import draw_gallery
from app.studies.pictures.gatherings.crashes_picture import draw_crashes
from app.studies.pictures.gatherings.gathering_picture import draw_gathering
from app.studies.pictures.gatherings.start_picture import draw_start
from app.studies.pictures.growth import draw_growth
from app.studies.pictures.holding_picture import draw_holding
from app.studies.pictures.lanes_picture import draw_lanes
from app.studies.pictures.layering_picture import draw_layering
from app.studies.pictures.missions.centres import draw_centres
from app.studies.pictures.missions.detours_picture import draw_detour, draw_expected
from app.studies.pictures.missions.distances import draw_distances
from app.studies.pictures.missions.duel import draw_duel
from app.studies.pictures.missions.mission_picture import draw_mission
from app.studies.pictures.missions.mission_snapshots import draw_snapshots
from app.studies.pictures.missions.nearest_picture import draw_nearest
from app.studies.pictures.missions.scene_turns import draw_turned
from app.studies.pictures.missions.success import draw_success
from app.studies.pictures.missions.tangents_picture import draw_tangents
from app.studies.pictures.missions.trajectories import draw_trajectories
from app.studies.pictures.optima_picture import draw_optima, draw_tradeoff
from app.studies.pictures.ordering_picture import draw_ordering
from app.studies.pictures.phases_picture import draw_phases
from app.studies.pictures.rows import draw_rows
from app.studies.pictures.schemes.block_scheme import draw_avoidance, draw_meeting
from app.studies.pictures.schemes.flowchart import draw_flowchart
from app.studies.pictures.schemes.potential_scheme import draw_potential
from app.studies.pictures.schemes.projection_scheme import draw_projections
from app.studies.pictures.schemes.region_scheme import draw_regions
from app.studies.pictures.schemes.steps import draw_motion, draw_steps
from app.studies.pictures.schemes.zone_scheme import (
    draw_cases,
    draw_neighbourhood,
    draw_view,
    draw_zones,
)
from app.studies.pictures.squash_picture import draw_squash
from app.studies.pictures.turns_picture import draw_turns
from app.studies.verdicts.verdict import Verdict, main_ones

OF_NUMBERS = {"models": draw_models, "sweeps": draw_sweeps, "pairs": draw_pairs}
"""Pictures of one measure."""
OF_MEASURES: dict[str, Callable[..., None]] = {
    "success": draw_success,
    "distances": draw_distances,
    "endurance": draw_endurance,
    "rows": draw_rows,
    "phases": draw_phases,
    "crashes": draw_crashes,
    "ordering": draw_ordering,
    "turned": draw_turned,
    "growth": draw_growth,
    "crowding": draw_crowding,
    "optima": draw_optima,
    "tradeoff": draw_tradeoff,
}
"""Pictures of several measures."""
OF_RUNS: dict[str, Callable[..., None]] = {
    "mission": draw_mission,
    "snapshots": draw_snapshots,
    "duel": draw_duel,
    "centres": draw_centres,
    "trajectories": draw_trajectories,
    "energy": draw_energy,
    "squash": draw_squash,
    "consensus": draw_consensus,
    "start": draw_start,
    "layering": draw_layering,
    "tangents": draw_tangents,
    "detour": draw_detour,
    "expected": draw_expected,
    "diffusion": draw_diffusion,
    "potential": draw_potential,
    "projections": draw_projections,
    "regions": draw_regions,
    "zones": draw_zones,
    "view": draw_view,
    "neighbourhood": draw_neighbourhood,
    "cases": draw_cases,
    "steps": draw_steps,
    "motion": draw_motion,
    "meeting": draw_meeting,
    "avoidance": draw_avoidance,
}
"""Pictures of the run of one seed."""
OF_BOTH: dict[str, Callable[..., None]] = {
    "evolution": draw_evolution,
    "nearest": draw_nearest,
    "gathering": draw_gathering,
    "formation": draw_formation,
    "driving": draw_driving,
    "lanes": draw_lanes,
    "turns": draw_turns,
    "holding": draw_holding,
    "gallery": draw_gallery,
    "flowchart": draw_flowchart,
}
"""Pictures of several measures and of the run of one seed."""
LOOK = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.grid.axis": "y",
    "axes.axisbelow": True,
    "grid.color": "#e3e6ea",
    "axes.edgecolor": "#7a828c",
    "xtick.color": "#3c434b",
    "ytick.color": "#3c434b",
    "axes.titlesize": 11,
    "lines.solid_capstyle": "butt",
    "figure.titlesize": 11,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "flockscope",
}


def draw(
    experiment: Experiment, made: list[Verdict], folder: Path, seed: int = 1
) -> dict[str, Path]:
    """Draw the picture into the folder; returns the files by kind.

    `seed` is that of the run which pictures of single runs show. Raises InputError.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure: Any = Figure(layout="constrained")
        FigureCanvasAgg(figure)
        if experiment.picture in OF_NUMBERS:
            OF_NUMBERS[experiment.picture](figure, main_ones(made))
        elif experiment.picture in OF_MEASURES:
            OF_MEASURES[experiment.picture](figure, made)
        elif experiment.picture in OF_BOTH:
            OF_BOTH[experiment.picture](figure, experiment, made, seed)
        else:
            OF_RUNS[experiment.picture](figure, experiment, seed)
        figure.suptitle(f"{experiment.title}\n{experiment.source}", x=0.01, ha="left", wrap=True)
        files = {kind: folder / f"{experiment.name}.{kind}" for kind in PICTURES}
        for path in files.values():
            write_figure(figure, path)
    return files
