"""Writes one page per model from its declaration, with a picture of it at work.

Beside them what `flockscope list` shows, so that listing need not import what models are made of.

    uv run python docs/make.py [MODEL ...]

Without names all are written. Tests hold the pages and the list against the declarations.
"""

from __future__ import annotations

import inspect
import json
import re
import sys
from pathlib import Path
from typing import Any

from make_papers import paper_pages
from rule_scenes import flock_of, scene_of

from agents.catalogue import BUILT_IN, MODELS, Model
from agents.engine.block import neighbour_of
from agents.engine.cache import global_values
from agents.flock import Flock
from agents.models.declare import DeclaredParameter, declared
from agents.models.related import related_models
from agents.observables.catalogue import OBSERVABLES, default_charts
from app.cli.choices import LISTED, list_declarations
from worlds.layout import read_layout

HERE = Path(__file__).parent / "rules"
ARTICLES = {
    "heading": "a heading",
    "acceleration": "an acceleration",
    "velocity": "a velocity",
}
VICSEK, MISSION, GOAL, ZONES, OTHERS = "vicsek", "mission", "goal", "zones", "others"
TITLES = {
    VICSEK: "The Vicsek family",
    MISSION: "The Vicsek family on a mission",
    GOAL: "Followers of a goal",
    ZONES: "Zones and flapping wings",
    OTHERS: "Other well-known flocks",
}
GROUPS = {
    VICSEK: "Agents of constant speed turn to a mean of their neighbours' headings; the rules "
    "differ in who counts how much.",
    MISSION: "The same rules lead a flock after its information UAV through a passage and past "
    "obstacles: in a body that keeps its distance and flies along what is in its way.",
    GOAL: "Every agent knows the goal, the gamma agent, and what is left to do is to keep the "
    "lattice and to get round obstacles.",
    ZONES: "Zones of repulsion, orientation and attraction with a field of view, as Couzin et al. "
    "published them and as a thesis gave them to flapping-wing aircraft, whose bodies crash.",
    OTHERS: "Boids, drones, people, particles and spins, with which other work can be compared.",
}


def group(model: Model) -> str:
    """The part of the list that a model is in."""
    if model.body.family in GROUPS:
        return model.body.family
    if model.rule.zones:
        return ZONES
    return GOAL if "gamma" in model.rule.forces else OTHERS


def parameter_row(one: DeclaredParameter) -> str:
    """One line of the table of parameters."""
    default = one.default if one.kind != "number" else f"{one.default:g}"
    if one.kind == "switch":
        default = str(one.default).lower()
    source = f"{one.description} ({one.source})".replace("|", "\\|")
    slider = "" if one.proposed is None else "{:g} to {:g}".format(*one.proposed)
    return f"| `{one.name}` | ${one.symbol}$ | {default} | {one.allowed} | {slider} | {source} |"


def listed(words: tuple[str, ...]) -> str:
    """Words as a sentence has them."""
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1]


def plainly(word: str) -> str:
    """A name of a column for people."""
    return word.replace("_", " ")


def reads_speed_of_others(function) -> bool:
    """Whether a part of a rule, or what it calls, asks a neighbour's speed."""
    if function is None or function is neighbour_of:
        return False
    asked = re.search(r"\b(other|near)\.speed\b", inspect.getsource(function.py_func))
    return bool(asked) or any(
        reads_speed_of_others(one)
        for one in global_values(function.py_func)
        if hasattr(one, "py_func")
    )


def facts(model: Model) -> list[tuple[str, str]]:
    """What a model is made of, one line each."""
    rule, body = model.rule, model.body
    made = [("Source", rule.source), ("Wants", ARTICLES[rule.wish])]
    if rule.forces:
        made.append((f"Its {rule.wish} is the sum of", listed(rule.forces)))
    made.append(("Body", f"{body.title}: {body.source}"))
    if body.forces:
        made.append(("Its velocity is the sum of", listed(body.forces)))
    told = [one for one in model.signals if " sent " not in one]
    hear = ["position", "heading", *(plainly(one) for one in told)]
    if reads_speed_of_others(rule.perceive) or reads_speed_of_others(rule.decide):
        hear.insert(2, "speed")
    made.append(("Agents tell each other", listed(tuple(hear))))
    if rule.zones:
        made.append(("Zones", zones(model)))
    if body.touches:
        made.append(("Crashes", crashes(model)))
    if body.measures:
        made.append(("Measured of each", listed(tuple(plainly(one) for one in body.measures))))
    if rule.memory:
        made.append(("Each remembers", listed(tuple(plainly(one) for one in rule.memory))))
    made.append(("Obstacles and walls", at_obstacles(model)))
    informed = {0: "none", 1: "one"}.get(rule.informed, str(rule.informed))
    made.append(("Information agents", f"{informed} by default" if rule.led else "none"))
    starts = f"; {model.dim}-D unless told otherwise" if model.dim else ""
    if rule.kinds:
        made.append(("Kinds that it knows", listed(rule.kinds)))
    made.append(("Dimensions", " and ".join(f"{d}-D" for d in rule.dimensions) + starts))
    if model.spacing is not None:
        made.append(("At the start", f"at least {model.spacing:g} from each other and all else"))
    made.append(("At home in", home(model)))
    made.append(("Unit of time", clock(model)))
    if rule.checked:
        made.append(("Checked against", with_links(with_numbers(rule.checked))))
    related = [f"[{other.title}]({other.name}.md)" for other in related_models(model, BUILT_IN)]
    if related:
        made.append(("See also", ", ".join(related)))
    return made


def with_numbers(text: str) -> str:
    """The text with what runs gave in the places of `{PAPER/ROW/N/MEASURE}` and `{PAPER#CLAIM}`.

    Of a row the mean, and what was published; claims are counted from 1. From `docs/papers`.
    """
    text = re.sub(r"\{([\w.-]+)#(\d+)\}", lambda found: claim_of(found[1], int(found[2])), text)
    return re.sub(
        r"\{([\w.-]+)/([^/}]+)/(\d+)/(\w+)\}", lambda found: row_of(*found.groups()), text
    )


def with_links(text: str) -> str:
    """The text, its commands that repeat a paper as links to the page with their results."""
    page_of = paper_pages()
    return re.sub(
        r"`flockscope paper ([\w.-]+)`",
        lambda command: f"[{command[0]}](../papers/{page_of[command[1]]})",
        text,
    )


def stored(paper: str) -> dict[str, Any]:
    """The stored results of a paper's full runs."""
    path = Path(__file__).parent / "papers" / f"{paper}.json"
    return json.loads(path.read_text(encoding="utf-8"))


def claim_of(paper: str, number: int) -> str:
    """A claim in words, and its verdict."""
    one = stored(paper)["claims"][number - 1]
    return f"{one['text']}: {one['verdict']}"


def row_of(paper: str, label: str, agents: str, measure: str) -> str:
    """The mean of a measure in a row, with the published one and the verdict where there are."""
    rows = stored(paper)["rows"]
    wanted = (label, int(agents), measure)
    row = next(one for one in rows if (one["label"], one["agents"], one["measure"]) == wanted)
    unit = "" if row["unit"] == "1" else f" {row['unit']}"
    found = f"{row['mean']:.4g}{unit}"
    if row.get("published_mean") is None:
        return found
    return f"{found} (published {row['published_mean']:.4g}: {row['verdict']})"


def crashes(model: Model) -> str:
    """What becomes of agents that touch something."""
    contact = getattr(model.parameters(), "contact", "")
    if contact == "stops":
        return "cars that touch stop each other; with `contact` they may crash for good"
    return "an agent that touches another, an obstacle or a wall falls"


def zones(model: Model) -> str:
    """The zones of a model with their outer radii, and how far round they are seen."""
    parameters = model.parameters()
    return "; ".join(
        f"{zone.name} to {zone.radius(parameters):g}"
        + (" all round" if zone.all_round else f" within {getattr(parameters, model.rule.view):g}°")
        for zone in model.rule.zones
    )


def at_obstacles(model: Model) -> str:
    """What agents do about what is solid."""
    rule, body = model.rule, model.body
    if rule.sees_points:
        return "the rule goes round their boundary points"
    if rule.sees_obstacles:
        return "the rule steers clear" + ("; the body never enters" if body.sees_obstacles else "")
    return "the body flies along them" if body.sees_obstacles else "agents bounce off"


def home(model: Model) -> str:
    """The world that a model is at home in, with its page."""
    title = str(read_layout(model.world)["title"])
    where = f"[`{model.world}`](../worlds-built-in.md#{model.world})"
    return f"{where} with {model.agents} agents. {title}"


def clock(model: Model) -> str:
    """The unit of time, and how long a tick is."""
    if model.body.unit == "ticks":
        return "tick"
    return f"{model.body.unit}; a tick is {model.body.lasts(model.parameters()):g} s"


def caption(model: Model, flock: Flock) -> str:
    """What the picture shows."""
    scene = scene_of(model)
    given = "".join(f", {name} = {value}" for name, value in scene.parameters.items())
    leaders = f" and {flock.spec.informed} information UAV" if flock.spec.informed else ""
    said = f"{flock.spec.agents} agents{leaders}{given}, seed {scene.seed}."
    if group(model) == MISSION:
        said += (
            " Colour is the number of hops to the information UAV, which is red; grey is no link."
        )
        return said + (" The dashed line is its path." if scene.window else "")
    said += " Colour is heading" + ("; the information UAV red." if leaders else ".")
    said += " Seen from above." if flock.world.dim == 3 else ""
    said += " Those that have crashed are grey." if flock.can_crash else ""
    if "seek" in model.rule.forces:
        said += " The star is the goal, which goes round the dotted line."
    return said + (" The star is the goal." if "gamma" in model.rule.forces else "")


def to_try(model: Model) -> str:
    """What there is to try with it; nothing if it declares nothing."""
    lines = "\n".join(
        f"{number}. **{one.words}** (`{one.changes}`{'; the run begins again' * one.anew}). "
        f"{one.see} *{one.proof.in_words[:1].upper()}{one.proof.in_words[1:]}.*"
        for number, one in enumerate(model.to_try, 1)
    )
    return (
        f"""## Try this

The guide of the laboratory (H) does it at a press; what it says is tested.

{lines}

"""
        if lines
        else ""
    )


def page(model: Model) -> str:
    """The page of a model."""
    rule, scene = model.rule, scene_of(model)
    flock = flock_of(model)
    rows = "\n".join(parameter_row(one) for one in declared(model.parameters))
    table = "\n".join(f"| {name} | {said} |" for name, said in facts(model))
    options = "".join(f" --set {name}={value}" for name, value in scene.parameters.items())
    keywords = "".join(f", {name}={value}" for name, value in scene.parameters.items())
    agents = flock.spec.agents
    many = f" --agents {agents}" if agents != model.agents else ""
    ticks = scene.ticks[-1]
    offered = [name for name, one in OBSERVABLES.items() if one.applies(flock)]
    measure = default_charts(model, offered)[0][0]
    return f"""# {model.title} (`{model.name}`)

{model.summary}

$$
{rule.equation}
$$

![{model.title} at work]({model.name}.png)

*{caption(model, flock)}*

| | |
|---|---|
{table}

## Parameters

| name | symbol | default | allowed | slider | what it is |
|---|---|---|---|---|---|
{rows}

{to_try(model)}## Try it

```
flockscope lab {model.name}
flockscope run {model.name}{many}{options} --ticks {ticks} --seed {scene.seed}
```

```python
from flockscope import Flock

flock = Flock("{model.name}", agents={agents}{keywords}, rng={scene.seed})
flock.run({ticks})
print(flock.observe("{measure}"))
```
"""


def index() -> str:
    """The list of all pages."""
    parts = ["# Models", "Made from the models' own declarations by `docs/make.py`."]
    for family, about in GROUPS.items():
        lines = [
            f"- [{m.title}]({name}.md) (`{name}`): {m.summary}"
            for name, m in MODELS.items()
            if group(m) == family
        ]
        parts += [f"## {TITLES[family]}", about, "\n".join(lines)]
    parts.append("[A rule of your own](../new-rule.md) is one file.")
    return "\n\n".join(parts) + "\n"


def pages() -> dict[str, str]:
    """File name -> text of every page."""
    return {f"{name}.md": page(model) for name, model in MODELS.items()} | {"README.md": index()}


def kept_list() -> str:
    """What `flockscope list` shows of what is built in, as it is kept."""
    return json.dumps(list_declarations(), indent=1, ensure_ascii=False) + "\n"


def main() -> None:
    """Write everything, or the pages of some models and the list."""
    from rule_pictures import draw

    HERE.mkdir(exist_ok=True)
    LISTED.write_text(kept_list(), encoding="utf-8")
    for name, text in pages().items():
        (HERE / name).write_text(text, encoding="utf-8")
    for name in sys.argv[1:] or MODELS:
        draw(MODELS[name], HERE / f"{name}.png")


if __name__ == "__main__":
    main()
