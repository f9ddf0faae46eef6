"""A laboratory for flocks: build one, put it in a world, watch it, steer it, measure it.

What is named here and in the modules below is what a script, a notebook or a package of your own
may import; nothing else is promised.

- `flockscope`: flocks, the models by name, kinds of agents and what their own numbers are drawn
  from, environments in which agents learn, worlds, sweeps, batches, sensitivity, optima, runs of
  the laboratory, and the error for what cannot be used
- `flockscope.rules`: for who writes a rule
- `flockscope.worlds`: worlds, their obstacles and missions; layouts, readers, generators, checks
- `flockscope.observables`: functions of arrays, for flocks and for tracks of real animals
- `flockscope.flight`: what one flapping-wing aircraft needs to fly
- `flockscope.live`: a source of poses and a link to cars of your own
- `flockscope.tracks`: tracks of real animals, people and robots, read from files

Importing it costs nothing: what a name stands for is imported when it is first asked for.

>>> from flockscope import Flock
>>> Flock("vem", agents=30, size=5.0, rng=1)
<Flock vem, N = 30, world wrap, tick 0, seed 1>
"""

from __future__ import annotations

from importlib import import_module

TYPE_CHECKING = False  # as `typing` has it, which takes longer to import than all of this
if TYPE_CHECKING:
    from typing import Any

    __version__: str

    from flockscope._flocks import Flock as Flock
    from flockscope._flocks import Member as Member
    from flockscope._flocks import MissionRecord as MissionRecord
    from flockscope._flocks import Series as Series
    from flockscope._flocks import fly as fly
    from flockscope._flocks import follow as follow
    from flockscope._learning import env as env
    from flockscope._learning import gym_env as gym_env
    from flockscope._learning import vector_env as vector_env
    from flockscope._models import MODELS as MODELS
    from flockscope._models import Kind as Kind
    from flockscope._models import Recording as Recording
    from flockscope._models import Spec as Spec
    from flockscope._models import chase as chase
    from flockscope._models import each as each
    from flockscope._models import flee as flee
    from flockscope._models import from_file as from_file
    from flockscope._models import lognormal as lognormal
    from flockscope._models import model as model
    from flockscope._models import normal as normal
    from flockscope._models import one_of as one_of
    from flockscope._models import uniform as uniform
    from flockscope._policies import Policy as Policy
    from flockscope._policies import policy as policy
    from flockscope._sweeps import batch_run as batch_run
    from flockscope._sweeps import optimise as optimise
    from flockscope._sweeps import runs_frame as runs_frame
    from flockscope._sweeps import sensitivity as sensitivity
    from flockscope._sweeps import sweep as sweep
    from flockscope.worlds import Box as Box
    from flockscope.worlds import CShape as CShape
    from flockscope.worlds import Disc as Disc
    from flockscope.worlds import Goal as Goal
    from flockscope.worlds import InputError as InputError
    from flockscope.worlds import Mission as Mission
    from flockscope.worlds import Path as Path
    from flockscope.worlds import Polygon as Polygon
    from flockscope.worlds import Prism as Prism
    from flockscope.worlds import Ring as Ring
    from flockscope.worlds import Sphere as Sphere
    from flockscope.worlds import StartRegion as StartRegion
    from flockscope.worlds import Union as Union
    from flockscope.worlds import Wall as Wall
    from flockscope.worlds import World as World
    from flockscope.worlds import world as world

_HOMES = {
    "_flocks": ("Flock", "Member", "MissionRecord", "Series", "fly", "follow"),
    "_models": (
        *("MODELS", "Recording", "Spec", "from_file", "model"),
        *("each", "lognormal", "normal", "one_of", "uniform"),
        *("Kind", "chase", "flee"),
    ),
    "_learning": ("env", "gym_env", "vector_env"),
    "_policies": ("Policy", "policy"),
    "_sweeps": ("batch_run", "optimise", "runs_frame", "sensitivity", "sweep"),
    "worlds": (
        *("Box", "CShape", "Disc", "Goal", "InputError", "Mission", "Path", "Polygon", "Prism"),
        *("Refusal", "Ring", "Sphere", "StartRegion", "Union", "Wall", "World", "world"),
    ),
}
"""Which module has a name: worlds need no compiler, and models no Mesa."""
__all__ = sorted({name for names in _HOMES.values() for name in names} - {"Refusal"})
_MODULES = ("flight", "live", "observables", "rules", "tracks", "worlds")


def __getattr__(name: str) -> Any:
    """What a name stands for; imported when it is first asked for."""
    if name == "__version__":
        return import_module("importlib.metadata").version(__name__)
    if name in _MODULES:
        return import_module(f"{__name__}.{name}")
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{home}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*__all__, *_MODULES, "__version__"])
