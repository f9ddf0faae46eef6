"""Draws the worlds of the pages docs/worlds*.md and writes their tables.

    uv run python docs/make_worlds.py

A test checks the tables against the declarations.
"""

from __future__ import annotations

import re
import tempfile
import textwrap
import tomllib
from pathlib import Path

from app.worlds.contents import points
from app.worlds.world_picture import draw_world
from worlds.generators import GENERATORS, draw_obstacles, generate
from worlds.generators.generate import describe_range
from worlds.layout import layout_names, read_layout, world, world_from_layout
from worlds.readers import read_geometry, world_around

HERE = Path(__file__).parent
PICTURES = HERE / "pictures" / "worlds"
SIDE = 10.0
"""Side of the box of a layout that leaves it open, m."""
SEED = 5
WIDTH = 118
"""Letters of a line of a page."""


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
        about = textwrap.fill(
            f"{layout['title']}.{source}", WIDTH, break_long_words=False, break_on_hyphens=False
        )
        parts.append(f"## `{name}`\n\n{about}\n\n![{name}](pictures/worlds/{name}.png)")
    return "\n\n".join(parts)


GENERATED = {
    "worlds-by-chance.md": ("parameters", parameters),
    "worlds-built-in.md": ("layouts", layouts),
}
"""Page -> the name of its generated part, and what makes it."""


def read_page(name: str) -> str:
    """The text of a page of docs/."""
    return (HERE / name).read_text(encoding="utf-8")


def page(name: str) -> str:
    """A page of GENERATED with its generated part as it is declared now."""
    mark, make = GENERATED[name]
    begin, end = f"<!-- {mark} -->", f"<!-- end of {mark} -->"
    before, _, rest = read_page(name).partition(begin)
    return f"{before}{begin}\n\n{make()}\n\n{end}{rest.partition(end)[2]}"


def draw() -> None:
    """Every layout under its name, every generator as make-KIND, and the pages' own examples."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    for name in layout_names():
        draw_world(
            draw_obstacles(world(name, unsized=lambda _: SIDE), SEED), PICTURES / f"{name}.png"
        )
    for kind in GENERATORS:
        draw_world(generate(kind, SEED, (60.0, 40.0)), PICTURES / f"make-{kind}.png")
    yard = world_from_layout(tomllib.loads(code(read_page("worlds.md"), "toml")), "yard")
    draw_world(yard, PICTURES / "boundary-points.png", points(yard))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "hall.geojson"
        file.write_text(code(read_page("worlds-from-drawings.md"), "json"), encoding="utf-8")
        draw_world(world_around(read_geometry(file)), PICTURES / "hall.png")


def main() -> None:
    """Write everything."""
    for name in GENERATED:
        (HERE / name).write_text(page(name), encoding="utf-8")
    draw()


if __name__ == "__main__":
    main()
