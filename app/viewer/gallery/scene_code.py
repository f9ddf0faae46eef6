"""A scene in the words of the command line and of Python."""

from __future__ import annotations

import shlex
from typing import Any

from agents.catalogue import model as find_model
from agents.spec import DEFAULT, OPTIONS, Spec
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.run.run_preset import at_home
from worlds.world import World

DRAWN = "its world was changed: save the scene as a file and run"


def command_line(scene: SavedScene) -> str:
    """What opens the run from a shell, as far as words can say it.

    >>> command_line(SavedScene("mine", at_home("vem", agents=30, parameters={"eta": 0.5})))
    'flockscope lab vem --agents 30 --seed 1 --set eta=0.5'
    """
    spec = scene.spec
    if isinstance(spec.world, World):
        return f"flockscope lab scene.toml  # {DRAWN} this"
    words = [spec.model] + ([] if scene.beside is None else ["--beside", scene.beside.model])
    for name, value in options(spec).items():
        words += [f"--{name.replace('_', '-')}", written(value)]
    for one in (spec, scene.beside):
        for name, value in {} if one is None else changed(one):
            words += ["--set", f"{name}={written(value)}"]
    if scene.speed is not None and scene.speed != float("inf"):
        words += ["--speed", written(scene.speed)]
    return shlex.join(["flockscope", "lab", *words])


def python(scene: SavedScene) -> str:
    """A script that makes the run.

    >>> print(python(SavedScene("mine", at_home("vem", agents=30))))
    from flockscope import Flock
    <BLANKLINE>
    flock = Flock("vem", agents=30, seed=1)
    flock.run(100)
    """
    spec = scene.spec
    if isinstance(spec.world, World):
        made = 'flock = Flock(Spec.read("spec.toml"))\nflock.run(100)'
        why = "# its world was changed: download its spec first"
        return f"{why}\nfrom flockscope import Flock, Spec\n\n{made}"
    values = {**options(spec), **dict(changed(spec))}
    given = "".join(f", {name}={value!r}" for name, value in values.items())
    made = f'flock = Flock("{spec.model}"{given})\nflock.run(100)'
    return f"from flockscope import Flock\n\n{made}"


def options(spec: Spec) -> dict[str, Any]:
    """The options of a run that are not as its model has them; the seed always."""
    usual = at_home(spec.model)
    return {
        name: getattr(spec, name)
        for name in OPTIONS
        if getattr(spec, name) is not None
        and (name == "seed" or getattr(spec, name) != getattr(usual, name))
    }


def changed(spec: Spec) -> list[tuple[str, Any]]:
    """The parameters that are not at their defaults."""
    usual = find_model(spec.model or DEFAULT).parameters().model_dump()
    return [(name, value) for name, value in spec.parameters.items() if usual.get(name) != value]


def written(value: Any) -> str:
    """A value on a command line."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.10g}" if isinstance(value, float) else str(value)
