"""Agents that are flown: before each tick their pilots say what they wish."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from agents.motion.agent_view import AgentView, numbers_of_action, wishes_of_actions
from agents.motion.hunting_motion import HuntingMotion
from agents.motion.motion import Motion
from agents.policies import Policy, known_policy
from agents.policy_process import PolicyError, process_of
from worlds.input_error import InputError, shorten


class Pilot(Protocol):
    """Says before each tick what steered agents wish."""

    fault: str
    """What has gone wrong, in one line; empty: nothing."""

    @property
    def is_active(self) -> bool:
        """Whether it wants to be asked in the coming tick."""

    def steer(self, flock: Motion) -> None:
        """Write what its agents wish in the coming tick."""

    def end_run(self, flock: Motion) -> None:
        """Tell what only the end of a run shows."""


class PolicyPilot:
    """Flies all agents of a kind at once, in the order of their identities; once something is wrong
    they follow their rule.

    `fault` says so, in one line with the agent and the tick. A policy that `ends` the run raises
    that as InputError.
    """

    def __init__(self, kind: str, policy: Policy):
        self.kind, self.policy = kind, policy
        self.fault = ""
        self.is_cut = False
        """Whether an action was beyond [-1, 1], which is told once."""

    @property
    def is_active(self) -> bool:
        """Until it has given up."""
        return not self.fault

    def steer(self, flock: Motion) -> None:
        """Ask the policy what its agents do, of what they see now. Raises InputError if it ends the
        run."""
        rows = flock.rows_of(self.kind)
        if not len(rows):
            return
        policy = self.policy
        rows = rows[np.argsort(flock.ids[rows])]
        seen = AgentView(flock, policy.k, len(rows)).look(rows)
        try:
            actions = process_of(policy).act(seen, numbers_of_action(flock))
            is_finite = np.isfinite(actions).all(axis=1)
            if not is_finite.all():
                first = int(np.argmin(is_finite))
                raise PolicyError(
                    f"{shorten(actions[first].tolist())} for agent {flock.ids[rows[first]]}, and "
                    "finite numbers are needed"
                )
        except PolicyError as error:
            self.give_up(flock, str(error))
            return
        if not self.is_cut and np.abs(actions).max() > 1.0:
            self.is_cut = True
            first = int(np.abs(actions).max(axis=1).argmax())
            flock.tell(
                f"{self.words(flock)}: {shorten(actions[first].tolist())} for agent "
                f"{flock.ids[rows[first]]}; numbers beyond [-1, 1] are cut off"
            )
        wishes = wishes_of_actions(flock, rows, actions, policy.scale)
        flock.steer(self.kind, wishes[np.argsort(rows)])

    def end_run(self, flock: Motion) -> None:
        """Nothing is left to tell: silence is told in the tick in which it is noticed."""

    def words(self, flock: Motion) -> str:
        """Who does something, and when."""
        return f"policy {self.policy.name} of kind {self.kind} at tick {flock.tick}"

    def give_up(self, flock: Motion, reason: str) -> None:
        """Give the agents back to their rule, and say why. Raises InputError if it ends the run."""
        line = f"{self.words(flock)}: {reason}"
        if self.policy.ends:
            raise InputError(f"{line}; the run ends, as it declares")
        self.fault = f"{line}; its agents follow their rule from now on"
        flock.steer(self.kind, np.full((len(flock.rows_of(self.kind)), flock.world.dim), np.nan))
        flock.tell(self.fault)


class SteeredMotion(HuntingMotion):
    """State and ticks of a flock of which some agents are flown.

    First the policies of kinds say what these wish, then the `pilots`, who may take single agents
    over. The compiled loop then runs one tick at a time. Pilots belong to this flock: copies of it,
    and what is saved of it, have none.
    """

    pilots: tuple[Pilot, ...] = ()
    """Who flies agents from outside, beside the policies of kinds."""
    _policies: dict[str, PolicyPilot] | None = None
    """Who flies the kinds that have a policy, by kind."""

    @property
    def is_flown(self) -> bool:
        """Whether somebody is asked, tick by tick, what steered agents wish."""
        is_asked = any(pilot.is_active for pilot in self.pilots)
        return is_asked or any(kind.policy for kind in self.kinds.kinds)

    def _ask_pilots(self) -> None:
        """Ask who flies agents what these wish in the coming tick. Raises InputError for a policy
        that is not known, or that ends the run."""
        known = self._policies or {}
        self._policies = {
            kind.name: self._pilot_of(kind.name, kind.policy, known)
            for kind in self.kinds.kinds
            if kind.policy
        }
        for pilot in (*self._policies.values(), *self.pilots):
            if pilot.is_active:
                pilot.steer(self)

    @staticmethod
    def _pilot_of(kind: str, name: str, known: dict[str, PolicyPilot]) -> PolicyPilot:
        """Who flies a kind by the policy of a name, as it is by now. Raises InputError."""
        policy = known_policy(name)
        pilot = known.get(kind)
        is_same = pilot is not None and pilot.policy is policy
        return pilot if pilot is not None and is_same else PolicyPilot(kind, policy)

    def end_run(self) -> None:
        """Let who flies agents from outside tell what only the end of the run shows."""
        for pilot in self.pilots:
            pilot.end_run(self)

    @property
    def faults(self) -> tuple[str, ...]:
        """What has gone wrong with who flies agents, a line each."""
        pilots = (*(self._policies or {}).values(), *self.pilots)
        return tuple(pilot.fault for pilot in pilots if pilot.fault)
