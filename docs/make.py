"""Writes one page per rule from its declaration, with a picture of it at work.

    uv run python docs/make.py

A test holds the pages against the declarations.
"""

from __future__ import annotations

from pathlib import Path

from agents import Flock
from agents.catalogue import MODELS, Model
from agents.declare import Declared, declared

HERE = Path(__file__).parent / "rules"
AGENTS, SIZE, SEED = 200, 7.0, 4
TICKS = (0, 5, 15, 60)
ETA = 0.2


def parameter_row(one: Declared) -> str:
    """One line of the table of parameters."""
    default = one.default if one.kind != "number" else f"{one.default:g}"
    source = f"{one.description} ({one.source})".replace("|", "\\|")
    return f"| `{one.name}` | ${one.symbol}$ | {default} | {one.allowed} | {source} |"


def page(model: Model) -> str:
    """The page of a model."""
    rule = model.rule
    rows = "\n".join(parameter_row(one) for one in declared(model.parameters))
    where = " and ".join(f"{d}-D" for d in rule.dimensions)
    informed = {0: "none", 1: "one"}.get(rule.informed, str(rule.informed))
    signals = ", ".join(rule.signals) or "nothing more"
    return f"""# {rule.title} (`{rule.name}`)

{rule.summary}

$$
{rule.equation}
$$

![{rule.title} at work]({rule.name}.png)

*{AGENTS} agents, r = 1, eta = {ETA} rad, seed {SEED}. Colour is heading; the information UAV red.*

| | |
|---|---|
| Source | {rule.source} |
| Body | {model.body.title}: {model.body.source} |
| Dimensions | {where} |
| Information agents | {informed} by default |
| Agents tell each other | position, heading and {signals} |

## Parameters

| name | symbol | default | allowed | what it is |
|---|---|---|---|---|
{rows}

## Try it

```
uv run flockscope lab {rule.name}
uv run flockscope run {rule.name} --agents {AGENTS} --set eta={ETA} --ticks 100 --seed {SEED}
```

```python
from agents import Flock

flock = Flock("{rule.name}", agents={AGENTS}, eta={ETA}, rng={SEED})
flock.run(100)
print(flock.observe("polarisation"))
```
"""


def picture(model: Model) -> None:
    """Four moments of a run, as PNG."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from matplotlib.colors import hsv_to_rgb

    flock = Flock(model.name, agents=AGENTS, size=SIZE, eta=ETA, rng=SEED)
    figure, axes = plt.subplots(1, len(TICKS), figsize=(12, 3.3), layout="constrained")
    for axis, tick in zip(axes, TICKS, strict=True):
        flock.run(tick - flock.tick)
        x, y = flock.position.T
        ux, uy = flock.heading.T
        hue = np.arctan2(uy, ux) / (2 * np.pi) % 1.0
        colour = hsv_to_rgb(np.column_stack([hue, np.full_like(hue, 0.8), np.full_like(hue, 0.75)]))
        axis.quiver(x, y, ux, uy, color=colour, scale=20, width=0.009, headwidth=4, pivot="mid")
        know = flock.informed
        axis.quiver(x[know], y[know], ux[know], uy[know], color="#d62728", scale=12, width=0.014,
                    headwidth=4, pivot="mid", zorder=3)  # fmt: skip
        axis.set(xlim=(0, SIZE), ylim=(0, SIZE), xticks=[], yticks=[], aspect="equal")
        axis.set_title(
            f"tick {tick}, polarisation {flock.observe('polarisation'):.2f}", fontsize=10
        )
    figure.savefig(HERE / f"{model.name}.png", dpi=110)
    plt.close(figure)


def index() -> str:
    """The list of all pages."""
    lines = [f"- [{m.title}]({name}.md) (`{name}`): {m.summary}" for name, m in MODELS.items()]
    return (
        "# Rules\n\nMade from the rules' own declarations by `docs/make.py`.\n\n"
        + "\n".join(lines)
        + "\n"
    )


def pages() -> dict[str, str]:
    """File name -> text of every page."""
    return {f"{name}.md": page(model) for name, model in MODELS.items()} | {"README.md": index()}


def main() -> None:
    """Write everything."""
    HERE.mkdir(exist_ok=True)
    for name, text in pages().items():
        (HERE / name).write_text(text, encoding="utf-8")
    for model in MODELS.values():
        picture(model)


if __name__ == "__main__":
    main()
