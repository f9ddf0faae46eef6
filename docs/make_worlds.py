"""Draws the worlds of docs/worlds.md and writes its tables.

    uv run python docs/make_worlds.py

A test holds the tables against the declarations.
"""

from __future__ import annotations

import re
import tempfile
import tomllib
from pathlib import Path

from app.worlds.contents import points
from app.worlds.world_picture import draw_world
from worlds.generators import GENERATORS, draw_obstacles, generate
from worlds.generators.generate import describe_range
from worlds.layout import layout_names, read_layout, world, world_from_layout
from worlds.readers import read_geometry, world_around

HERE = Path(__file__).parent
PAGE = HERE / "worlds.md"
PICTURES = HERE / "pictures" / "worlds"
SIDE = 10.0
"""Side of the box of a layout that leaves it open, m."""
SEED = 5


def code(text: str, kind: str) -> str:
    """The first piece of code of a kind on the page."""
    found = re.search(rf"```{kind}\n(.*?)```", text, re.DOTALL)
    assert found, kind
    return found[1]


def parameters() -> str:
    """The table of the generators' parameters."""
    rows = ["| kind | parameter | default | allowed | what it is |", "|---|---|---|---|---|"]
    for kind in GENERATORS.values():
        for name, field in kind.parameters.model_fields.items():
            rows.append(
                f"| `{kind.name}` | `{name}` | {field.default:g} | {describe_range(field)} "
                f"| {field.description} |"
            )
    return "\n".join(rows)


def layouts() -> str:
    """Title and picture of each layout."""
    parts = []
    for name in layout_names():
        layout = read_layout(name)
        source = f" Source: {layout['source']}." if layout.get("source") else ""
        parts.append(
            f"### `{name}`\n\n{layout['title']}.{source}\n\n![{name}](pictures/worlds/{name}.png)"
        )
    return "\n\n".join(parts)


def page(text: str) -> str:
    """The page with its tables as they are declared now."""
    for mark, made in (("parameters", parameters()), ("layouts", layouts())):
        begin, end = f"<!-- {mark} -->", f"<!-- end of {mark} -->"
        before, _, rest = text.partition(begin)
        text = f"{before}{begin}\n\n{made}\n\n{end}{rest.partition(end)[2]}"
    return text


def draw(text: str) -> None:
    """Every layout under its name, every generator as make-KIND, and the page's own examples."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    for name in layout_names():
        draw_world(
            draw_obstacles(world(name, unsized=lambda _: SIDE), SEED), PICTURES / f"{name}.png"
        )
    for kind in GENERATORS:
        draw_world(generate(kind, SEED, (60.0, 40.0)), PICTURES / f"make-{kind}.png")
    yard = world_from_layout(tomllib.loads(code(text, "toml")), "yard")
    draw_world(yard, PICTURES / "boundary-points.png", points(yard))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "hall.geojson"
        file.write_text(code(text, "json"), encoding="utf-8")
        draw_world(world_around(read_geometry(file)), PICTURES / "hall.png")


def main() -> None:
    """Write everything."""
    text = page(PAGE.read_text(encoding="utf-8"))
    PAGE.write_text(text, encoding="utf-8")
    draw(text)


if __name__ == "__main__":
    main()
