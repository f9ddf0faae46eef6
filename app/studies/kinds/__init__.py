"""The kinds of experiments."""

from app.studies.kinds.beginning import BeginningSettings
from app.studies.kinds.branching import BranchingSettings
from app.studies.kinds.consensus import ConsensusSettings
from app.studies.kinds.convergence import ConvergenceSettings
from app.studies.kinds.crowding import CrowdingSettings
from app.studies.kinds.detours import DetourSettings
from app.studies.kinds.diffusion import DiffusionSettings
from app.studies.kinds.dodging import DodgingSettings
from app.studies.kinds.driving import DrivingSettings
from app.studies.kinds.energy import EnergySettings
from app.studies.kinds.evolution import EvolutionSettings
from app.studies.kinds.formation import FormationSettings
from app.studies.kinds.gathering import GatheringSettings
from app.studies.kinds.holding import HoldingSettings
from app.studies.kinds.kind_settings import Settings
from app.studies.kinds.lanes import LaneSettings
from app.studies.kinds.layering import LayeringSettings
from app.studies.kinds.mission import MissionSettings
from app.studies.kinds.optima import OptimaSettings, TradeoffSettings
from app.studies.kinds.ordering import OrderingSettings
from app.studies.kinds.phases import PhaseSettings
from app.studies.kinds.potential import PotentialSettings
from app.studies.kinds.projections import ProjectionSettings
from app.studies.kinds.regions import RegionSettings
from app.studies.kinds.squash import SquashSettings
from app.studies.kinds.swarming import SwarmingSettings
from app.studies.kinds.tangents import TangentSettings
from app.studies.kinds.turns import TurnSettings
from app.studies.kinds.zoning import ZoningSettings

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
