"""Whether a flock fits into this machine's memory, before anything of it is made."""

from __future__ import annotations

from agents.model import Model
from worlds.memory import demand_memory
from worlds.refusal import Refusal

MOST_AGENTS = 2**31 - 1
"""Rows are numbered by int32."""
BYTES = 200
"""Of an agent: its arrays, their sorted copy, and what its start is drawn from."""
BYTES_OF_A_SIGNAL = 16
"""Of each signal or memory of an agent, and its copy."""
BYTES_OF_A_THREAD = 4
"""Of each agent and thread: a thread counts the cells by itself."""


def demand_room(model: Model, agents: int, threads: int) -> None:
    """Refuse more agents than can be. Raises Refusal naming how much memory they would need."""
    if agents > MOST_AGENTS:
        raise Refusal(f"agents = {agents} is not allowed: the largest is {MOST_AGENTS}")
    each = BYTES + BYTES_OF_A_SIGNAL * len(model.columns) + BYTES_OF_A_THREAD * threads
    demand_memory(f"agents = {agents}", float(agents) * each)
