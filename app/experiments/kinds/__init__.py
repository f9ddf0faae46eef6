"""The kinds of experiments."""

from app.experiments.kinds.consensus import Consensus
from app.experiments.kinds.convergence import Convergence
from app.experiments.kinds.crowding import Crowding
from app.experiments.kinds.diffusion import Diffusion
from app.experiments.kinds.driving import Driving
from app.experiments.kinds.energy import Energy
from app.experiments.kinds.formation import Formation
from app.experiments.kinds.gathering import Gathering
from app.experiments.kinds.mission import Mission
from app.experiments.kinds.phases import Phases
from app.experiments.kinds.settings import Settings
from app.experiments.kinds.squash import Squash
from app.experiments.kinds.swarming import Swarming

KINDS: dict[str, type[Settings]] = {
    one.kind: one
    for one in (
        Convergence,
        Mission,
        Energy,
        Phases,
        Gathering,
        Formation,
        Driving,
        Squash,
        Consensus,
        Swarming,
        Diffusion,
        Crowding,
    )
}
