"""The kinds of experiments."""

from app.experiments.kinds.beginning import BeginningSettings
from app.experiments.kinds.branching import BranchingSettings
from app.experiments.kinds.consensus import ConsensusSettings
from app.experiments.kinds.convergence import ConvergenceSettings
from app.experiments.kinds.crowding import CrowdingSettings
from app.experiments.kinds.detours import DetourSettings
from app.experiments.kinds.diffusion import DiffusionSettings
from app.experiments.kinds.dodging import DodgingSettings
from app.experiments.kinds.driving import DrivingSettings
from app.experiments.kinds.energy import EnergySettings
from app.experiments.kinds.evolution import EvolutionSettings
from app.experiments.kinds.formation import FormationSettings
from app.experiments.kinds.gathering import GatheringSettings
from app.experiments.kinds.holding import HoldingSettings
from app.experiments.kinds.kind_settings import Settings
from app.experiments.kinds.lanes import LaneSettings
from app.experiments.kinds.layering import LayeringSettings
from app.experiments.kinds.mission import MissionSettings
from app.experiments.kinds.optima import OptimaSettings, TradeoffSettings
from app.experiments.kinds.ordering import OrderingSettings
from app.experiments.kinds.phases import PhaseSettings
from app.experiments.kinds.potential import PotentialSettings
from app.experiments.kinds.projections import ProjectionSettings
from app.experiments.kinds.regions import RegionSettings
from app.experiments.kinds.squash import SquashSettings
from app.experiments.kinds.swarming import SwarmingSettings
from app.experiments.kinds.tangents import TangentSettings
from app.experiments.kinds.turns import TurnSettings
from app.experiments.kinds.zoning import ZoningSettings

KINDS: dict[str, type[Settings]] = {
    one.kind: one
    for one in (
        *(
            ConvergenceSettings,
            EvolutionSettings,
            MissionSettings,
            EnergySettings,
            PhaseSettings,
            GatheringSettings,
            BeginningSettings,
            FormationSettings,
        ),
        *(
            DrivingSettings,
            HoldingSettings,
            SquashSettings,
            LayeringSettings,
            TangentSettings,
            DetourSettings,
        ),
        *(
            BranchingSettings,
            DodgingSettings,
            PotentialSettings,
            ProjectionSettings,
            RegionSettings,
            ZoningSettings,
        ),
        *(
            ConsensusSettings,
            CrowdingSettings,
            DiffusionSettings,
            LaneSettings,
            OptimaSettings,
            OrderingSettings,
            SwarmingSettings,
            TradeoffSettings,
            TurnSettings,
        ),
    )
}
