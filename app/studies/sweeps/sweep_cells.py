"""A cell of a sweep: a run but for its seed, what of it differs, and what its numbers depend on."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from agents.flock import Flock
from agents.policies import known_policy
from agents.spec import Spec, changed_versions, versions
from app.strict_table import Value
from app.studies.runs.store import canonical
from app.studies.sweeps.sweep_job import SweepJob
from worlds.world import World

OPEN = ("seed", "versions", "layout", "start")
"""What of a spec is told apart from it."""


@dataclass(frozen=True)
class Cell:
    """Runs that differ by their seed only."""

    spec: Spec
    axes: dict[str, Value]
    """What differs from cell to cell, in the order of the design."""
    design: int
    """The number of its design, from 0."""
    identity: dict[str, Any]
    """The run with nothing left open, and how it is measured."""
    basis: dict[str, Any]
    """What else its numbers depend on: versions, code, world."""
    redrawn: int = 0
    """Numbers of agents that were drawn again in the run of the first seed."""
    warning: str = ""
    """What that run warns of."""

    @cached_property
    def hash(self) -> str:
        """What the store knows it by: another one if anything is different."""
        text = canonical({"identity": self.identity, "basis": self.basis})
        return hashlib.sha256(text.encode()).hexdigest()[:24]

    @cached_property
    def first_seed(self) -> int:
        """A seed that follows from what the cell is, with room for a million behind it."""
        digest = hashlib.sha256(canonical(self.identity["spec"]).encode()).digest()
        return int.from_bytes(digest[:5], "big") << 20

    @property
    def stored_text(self) -> str:
        """As the store keeps it."""
        return canonical(
            {
                "axes": self.axes,
                "design": self.design,
                "identity": self.identity,
                "basis": self.basis,
            }
        )


class Basis:
    """What numbers depend on beside the run itself; what cells share is found once."""

    def __init__(self, making: SweepJob, seed: int):
        self.making = making
        self.seed = seed
        self.versions = versions()
        self.measures = {measure.column: measure.fingerprint for measure in making.measures}
        self.worlds: dict[tuple, str] = {}

    def cell(self, spec: Spec, axes: dict[str, Value], design: int) -> Cell:
        """The cell of a run, which is built for it. Raises InputError."""
        flock = Flock(spec.but(seed=self.seed))
        run, until = flock.options, self.making.until
        left = {*OPEN, "world", "size", "dim", "parameters"}
        # Runs whose agents are alike are known as before there were others.
        left |= {key for key in ("individuals", "kinds", "to") if not getattr(run, key)}
        values = run.model_dump(exclude=left)
        identity = {
            "spec": values
            | {
                "world": flock.world.name,
                "size": list(flock.world.size),
                "parameters": flock.parameters.model_dump(),
                **{
                    f"parameters of {one.kind.name}": one.parameters.model_dump()
                    for one in flock.kind_models
                },
            },
            "ticks": self.making.ticks,
            "stop": until and [*until.says, until.hold, until.every],
            "observe": [
                [measure.column, measure.name or measure.function, measure.every, measure.over]
                for measure in self.making.measures
            ],
        }
        digest = hashlib.sha256(flock.position.tobytes())
        digest.update(flock.heading.tobytes())
        digest.update(flock.speed.tobytes())
        basis = {
            "versions": self.versions,
            f"the rule of {run.model}": flock.loop.cache_folder.name,
            **{
                f"the rule of {one.model.name}, of kind {one.kind.name}": loop.cache_folder.name
                for one, loop in zip(flock.kind_models, flock.loops[1:], strict=True)
            },
            f"the world {flock.world.name}": self.world(spec, flock.world),
            "how a flock starts": digest.hexdigest()[:12],
            **{
                f"the policy {kind.policy}": known_policy(kind.policy).digest
                for kind in run.kinds
                if kind.policy
            },
            **{f"the measure {name}": measure for name, measure in self.measures.items()},
        }
        redrawn = sum(flock.redrawn.values())
        return Cell(spec, axes, design, identity, basis, redrawn, flock.warning)

    def world(self, spec: Spec, world: World) -> str:
        """A hash of the world of a run; where it has a name, name and size say which it is."""
        key = (spec.world, spec.layout is None, world.size, world.name)
        if not isinstance(spec.world, str | None) or spec.layout is not None:
            return hash_world(world)
        if key not in self.worlds:
            self.worlds[key] = hash_world(world)
        return self.worlds[key]


def hash_world(world: World) -> str:
    """A hash of a world."""
    return hashlib.sha256(world.to_toml().encode()).hexdigest()[:12]


def changes(old: Mapping[str, Any], new: Mapping[str, Any]) -> list[str]:
    """What is different in what two cells of the same run depend on, in words.

    >>> changes({"versions": {"numpy": "1"}, "rule": 1}, {"versions": {"numpy": "2"}, "rule": 2})
    ['numpy 1, now 2', 'rule has changed']
    """
    lines: list[str] = []
    changed = changed_versions(old.get("versions", {}), new.get("versions", {}))
    lines += [f"{name} {before}, now {now}" for name, before, now in changed]
    lines += [
        f"{name} has changed"
        for name in new
        if name != "versions" and name in old and old[name] != new[name]
    ]
    return lines
