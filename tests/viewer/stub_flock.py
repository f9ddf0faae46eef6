"""A flock that needs no compiler: what the simulation asks of a flock, and nothing else."""

from __future__ import annotations

import time
from concurrent.futures import Future
from pathlib import Path
from types import MappingProxyType, SimpleNamespace

import numpy as np

from agents.engine.arrays import Arrays
from agents.kinds import NO_KINDS
from agents.models.declare import Parameters, checked, parameter
from agents.snapshot import Snapshot
from agents.spec import Spec
from agents.state.agent_rows import Crashes
from app.viewer.run.kernel_compiler import CompileEstimate
from app.viewer.run.run_preset import preset_spec
from worlds.input_error import InputError
from worlds.world import World


class Knobs(Parameters):
    """One parameter."""

    eta: float = parameter(0.5, "Noise", symbol=r"\eta", source="none", low=0.0, high=6.28)


class StubCompiling:
    """A compile that is done when a test says so: `ready.set_result(None)`."""

    def __init__(self, flocks):
        self.flocks = list(flocks)
        self.estimate = CompileEstimate(time.monotonic(), 8.0, True)
        self.ready: Future[None] = Future()
        self.closed = False

    def covers(self, _flocks) -> bool:
        return not self.closed

    def close(self) -> None:
        self.closed = True


class StubSnapshot(Snapshot):
    """A stub at a tick, with links, groups and layers of its places."""

    reach = together = dt = 1.0

    def _largest(self, _name: str) -> float:
        return 1.0


class StubFlock:
    """Agents that fly straight on; at the tick `breaks_at` they raise `error` instead."""

    is_compiled = True
    loop = None
    individuals = own = redrawn = MappingProxyType({})
    kinds = NO_KINDS
    differing = ()

    def __init__(
        self,
        start: Spec,
        breaks_at: float = float("inf"),
        error: Exception | None = None,
        cost: float = 0.0,
    ):
        n = start.agents
        self.options = start
        rng = np.random.default_rng(start.seed)
        self.side = start.size or 5.0
        self.position = rng.uniform(0, self.side, (n, start.dim))
        self.heading = np.zeros((n, start.dim))
        self.heading[:, 0] = 1.0
        self.speed = np.full(n, 0.03)
        self.informed = np.arange(n) == 0
        self.ids = np.arange(n)
        self.world = World("wrap", (self.side,) * start.dim, ("wrap",) * start.dim)
        self.model = SimpleNamespace(
            rule=SimpleNamespace(
                converges=False,
                zones=(),
                reach="r",
                view="",
                hunters="",
                sees_points=False,
                form="birds",
            ),
            body=SimpleNamespace(unit="ticks", touches=None, vehicle=None),
            nearest=lambda _: 0,
            columns=(),
            individual=(),
            tells=(),
            signals=(),
        )
        self.dt = 1.0
        self.seed = start.seed
        self.can_crash = False
        self.seen = self.hollow = self.paired = None
        self.warning = ""
        self.active = np.ones(n, bool)
        self.crashes = Crashes(*np.empty((3, 0), int), np.empty((0, start.dim)), np.empty(0, int))
        self.reach = 1.0
        self.together = 1.0
        self.tick = 0
        self.parameters = checked(Knobs, start.parameters)
        self.spec = SimpleNamespace(
            to_toml=lambda: f"seed = {start.seed}\n",
            but=start.but,
            agents=start.agents,
            seed=start.seed,
        )
        self.breaks_at, self.error, self.cost = breaks_at, error or ArithmeticError("NaN"), cost

    def advance(self, ticks: int) -> None:
        for _ in range(ticks):
            if self.tick >= self.breaks_at:
                raise self.error
            time.sleep(self.cost)
            self.position = (self.position + 0.03 * self.heading) % self.side
            self.tick += 1

    @property
    def all_parameters(self) -> dict[str, float]:
        return self.parameters.model_dump()

    def set(self, **values) -> None:
        self.parameters = checked(Knobs, self.parameters.model_dump() | values)

    def snapshot(self, copy: bool = True, signals: bool = False) -> StubSnapshot:  # noqa: ARG002
        n, dim = self.position.shape
        state = self.position, self.heading, self.speed, self.informed, self.ids
        rest = np.zeros(n, np.int32), np.empty((0, n)), np.empty((0, 2 + dim)), np.empty((n, 0, 0))
        arrays = Arrays(*(array.copy() for array in (*state, *rest)), own=np.empty((n, 0)))
        start = self.model, self.world, self.parameters, self.seed, self.tick, arrays
        return StubSnapshot(*start, next_id=n)

    def warm(self) -> None:
        pass

    def stray(self) -> None:
        return None

    def observe(self, _name: str) -> float:
        return 1.0

    def layers(self) -> np.ndarray:
        return np.where(self.informed, 1, 2)

    def group_labels(self) -> np.ndarray:
        return np.zeros(len(self.ids), int)

    def links(self) -> np.ndarray:
        return np.array([[0, 1]])

    def inspect(self, row: int) -> SimpleNamespace:
        return SimpleNamespace(
            id=row,
            row=row,
            neighbours=np.array([1]),
            separation=np.ones((1, self.position.shape[1])),
            weights=np.array([1.0]),
            signals={"layer": 2.0},
            minds=True,
            places=(),
            model=None,
            name="",
            known={},
        )

    def save(self, path) -> None:
        Path(path).write_bytes(b"saved")


def timed_stub(dt: float = 0.02, unit: str = "s", strict: bool = False, **more) -> StubFlock:
    """A stub with a title, a time and, if `strict`, a range of its own."""
    flock = StubFlock(preset_spec(agents=8), **more)
    flock.dt = dt
    flock.model.title, flock.model.body.unit = "Stub", unit
    if strict:
        take = flock.set

        def refuse(**values) -> None:
            if values["eta"] > 2.0:
                raise InputError(f"eta = {values['eta']} is too much")
            take(**values)

        flock.set = refuse
    return flock
