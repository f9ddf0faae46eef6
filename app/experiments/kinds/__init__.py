"""The kinds of experiments."""

from app.experiments.kinds.beginning import Beginning
from app.experiments.kinds.branching import Branching
from app.experiments.kinds.consensus import Consensus
from app.experiments.kinds.convergence import Convergence
from app.experiments.kinds.crowding import Crowding
from app.experiments.kinds.detours import Detours
from app.experiments.kinds.diffusion import Diffusion
from app.experiments.kinds.dodging import Dodging
from app.experiments.kinds.driving import Driving
from app.experiments.kinds.energy import Energy
from app.experiments.kinds.evolution import Evolution
from app.experiments.kinds.formation import Formation
from app.experiments.kinds.gathering import Gathering
from app.experiments.kinds.holding import Holding
from app.experiments.kinds.lanes import Lanes
from app.experiments.kinds.layering import Layering
from app.experiments.kinds.mission import Mission
from app.experiments.kinds.optima import Optima, Tradeoff
from app.experiments.kinds.ordering import Ordering
from app.experiments.kinds.phases import Phases
from app.experiments.kinds.potential import Potential
from app.experiments.kinds.projections import Projections
from app.experiments.kinds.regions import Regions
from app.experiments.kinds.settings import Settings
from app.experiments.kinds.squash import Squash
from app.experiments.kinds.swarming import Swarming
from app.experiments.kinds.tangents import Tangents
from app.experiments.kinds.turns import Turns
from app.experiments.kinds.zoning import Zoning

KINDS: dict[str, type[Settings]] = {
    one.kind: one
    for one in (
        *(Convergence, Evolution, Mission, Energy, Phases, Gathering, Beginning, Formation),
        *(Driving, Holding, Squash, Layering, Tangents, Detours),
        *(Branching, Dodging, Potential, Projections, Regions, Zoning),
        *(Consensus, Crowding, Diffusion, Lanes, Optima, Ordering, Swarming, Tradeoff, Turns),
    )
}
