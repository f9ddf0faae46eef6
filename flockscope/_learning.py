"""What `flockscope` promises of agents that learn."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from agents.catalogue import model as find_model
from agents.flock_world import complete_spec
from agents.spec import Spec
from worlds.plug_ins import demand

if TYPE_CHECKING:
    from gymnasium.vector import AutoresetMode

    from app.learning.flock_env import FlockEnv
    from app.learning.flock_vector_env import FlockVectorEnv
    from app.learning.single_agent_env import SingleAgentEnv


def env(
    run: str | Spec,
    kind: str,
    *,
    k: int = 6,
    ticks: int = 200,
    reward: str | Callable[..., Any] = "align",
    scale: float = 1.0,
    **words: Any,
) -> FlockEnv:
    """A flock whose agents of a steered kind are players, as a `ParallelEnv` of PettingZoo.

    Parameters
    ----------
    run: a model by name, or a `Spec`; `words` are those of `Flock`, `kinds` among them.
    kind: the name of the kind that is steered.
    k: how many nearest agents a player sees, 1 to 64. ticks: how long a run lasts, >= 1.
    reward: `align`, `evade`, `hunt`, `reach-goal`, or a function of
        `app.learning.reward.StepResult` that gives what each player gains, (S,).
    scale: what an action of 1 is, where the rule wishes an acceleration or a velocity, > 0.

    Raises InputError. Needs the extra `learn`.

    >>> from flockscope import Kind, env
    >>> players = env("vem", "robot", kinds=[Kind("robot", 2, steered=True)], agents=20)
    >>> players.possible_agents
    ['robot_0', 'robot_1']
    """
    demand("pettingzoo", "agents that learn", "learn")
    from app.learning.flock_env import FlockEnv

    return FlockEnv(spec_of(run, words), kind, k, ticks, reward, scale)


def gym_env(run: str | Spec, kind: str, *, ticks: int = 200, **words: Any) -> SingleAgentEnv:
    """The same with one steered agent, as an `Env` of Gymnasium; options as `env`.

    Raises InputError. Needs the extra `learn`.
    """
    demand("gymnasium", "agents that learn", "learn")
    from app.learning.single_agent_env import SingleAgentEnv

    own = own_words(words)
    return SingleAgentEnv(spec_of(run, words), kind, ticks=ticks, **own)


def vector_env(
    run: str | Spec,
    kind: str,
    number: int,
    *,
    ticks: int = 200,
    autoreset: str | AutoresetMode = "NextStep",
    **words: Any,
) -> FlockVectorEnv:
    """Many flocks as a `VectorEnv` of Gymnasium: one compiled call takes all through a tick.

    Flock i is that of `gym_env` with the seed of the first and i more, to the bit. `number`: 1 to
    65 536 flocks. `autoreset`: `NextStep`, `SameStep` or `Disabled`, see Gymnasium's
    `AutoresetMode`. Other options as `env`. Several agents of the kind are a team, see
    `app.learning.flock_vector_env.FlockVectorEnv`.

    Raises InputError. Needs the extra `learn`.

    >>> from flockscope import Kind, vector_env
    >>> flocks = vector_env("vem", "robot", 8, kinds=[Kind("robot", 1, steered=True)], agents=20)
    >>> seen, _ = flocks.reset(seed=1)
    >>> seen.shape
    (8, 44)
    """
    demand("gymnasium", "agents that learn", "learn")
    from app.learning.flock_vector_env import FlockVectorEnv

    own = own_words(words)
    return FlockVectorEnv(
        spec_of(run, words), number, kind, ticks=ticks, autoreset=autoreset, **own
    )


def own_words(words: dict[str, Any]) -> dict[str, Any]:
    """Those of the words that are the environment's own, taken out."""
    return {name: words.pop(name) for name in ("k", "reward", "scale") if name in words}


def spec_of(run: str | Spec, words: dict[str, Any]) -> Spec:
    """The run that the words of `Flock` ask for. Raises InputError."""
    spec = run if isinstance(run, Spec) else Spec(run)
    of_kinds = {name: words.pop(name) for name in ("kinds", "to") if name in words}
    spec = spec.but(**of_kinds).taking(**words)
    return complete_spec(spec, find_model(spec.model))


__all__ = ["env", "gym_env", "vector_env"]
