"""A figure as SVG in the text of a page: in its colours and its face, with shapes to click.

matplotlib writes SVG for a file of its own. In a page it is part of a document that has a theme and
other pictures: fixed colours become the page's variables, so that both themes show it; ids are made
unique or go; words stay words, in the page's face; and shapes get classes and links.
"""

from __future__ import annotations

import hashlib
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any
from xml.etree import ElementTree

from app.figure import EDGE, GRID, INK, NAMED, UNDATED, new_figure
from app.studies.charts.colour_table import CENSORED, COLOURS, EMPTY, FAILED

DOTS_AN_INCH = 72.0
"""Of the page: matplotlib's SVG has points, 72 an inch, for its units."""
PAGE_LOOK = {**NAMED, "font.size": 11, "axes.labelsize": 12, "axes.linewidth": 1.0}
"""In pixels of a picture that is as wide as it was made."""
PAGE_COLOURS = {
    "#000000": "var(--fs-text)",
    "#ffffff": "var(--fs-surface)",
    INK: "var(--fs-quiet)",
    EDGE: "var(--fs-edge)",
    GRID: "var(--fs-line)",
    EMPTY: "var(--fs-raised)",
    CENSORED: "var(--fs-gave-up)",
    FAILED: "var(--fs-failed)",
    COLOURS[0]: "var(--fs-accent)",
    **{colour: f"var(--fs-series-{k})" for k, colour in enumerate(COLOURS[1:], 2)},
}
"""Of the table of all charts, as page.css has them. The colours of a map are values, and stay."""
CLASS = "fs-"
"""How the id of an artist begins that is a class of its shapes."""
CLICKED = "fs-target"
"""The class of what is not seen: where a click means the shape beside it."""
SHAPES, WORDS = ("path", "use"), ("text", "tspan", "title")
"""Elements that are drawn, and those whose spaces are kept."""
UNFIT = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML cannot have, in whatever users call things."""
LINKED = "{http://www.w3.org/1999/xlink}href"


@dataclass(frozen=True)
class ShapeLink:
    """What a shape of a chart says under the mouse, and what a click is told by: its data."""

    title: str
    data: Mapping[str, object] = field(default_factory=dict)
    """Name -> value of the attributes `data-NAME`."""


@contextmanager
def page_figure(width: float, height: float) -> Iterator[Any]:
    """An empty figure for a page, so many pixels large, to be drawn and made SVG before this
    ends."""
    with new_figure(PAGE_LOOK) as figure:
        figure.set_size_inches(width / DOTS_AN_INCH, height / DOTS_AN_INCH)
        yield figure


def page_svg(
    figure: Any,
    label: str = "",
    links: Mapping[str, Sequence[ShapeLink | None]] | None = None,
) -> str:
    """The figure as an SVG element, as wide as what it is put into.

    `label` is read out in its place. An artist whose id (`gid`) begins with `fs-` gives its shapes
    that class; `links` has, by such ids, a link for each shape of the artist, in their order. A
    shape whose link is None is left out.
    """
    file = io.StringIO()
    figure.savefig(file, format="svg", facecolor="none", metadata=UNDATED["svg"])
    root = ElementTree.fromstring(UNFIT.sub("\ufffd", file.getvalue()))
    for element in root.iter():
        element.tag = element.tag.rpartition("}")[2]
    for name in ("metadata", "defs"):  # its own styles would be those of the whole page
        for node in root.findall(name):
            if node.find("style") is not None or name == "metadata":
                root.remove(node)
    for group in list(root.iter("g")):
        name = group.get("id", "")
        if name.startswith(CLASS):
            mark_shapes(group, name, (links or {}).get(name))
    for element in root.iter():
        fit_to_page(element)
    name_ids(root)
    box = root.get("viewBox", "")
    root.attrib.clear()
    root.attrib |= {
        "class": "fs-figure",
        "viewBox": box,
        "role": "group" if links else "img",  # what is in an image cannot be pressed
        "aria-label": without_control_characters(label),
    }
    return ElementTree.tostring(root, encoding="unicode")


def mark_shapes(
    group: ElementTree.Element, name: str, links: Sequence[ShapeLink | None] | None
) -> None:
    """Give the shapes of an artist their class, and wrap those that have a link."""
    defined = {shape for defs in group.iter("defs") for shape in defs.iter()}
    shapes = [
        (parent, shape)
        for parent in group.iter()
        for shape in parent
        if shape.tag in SHAPES and shape not in defined
    ]
    for _, shape in shapes:
        shape.set("class", name)
    if links is None:
        return
    if len(links) != len(shapes):
        raise ValueError(f"{len(links)} links for {len(shapes)} shapes of {name}")
    for (parent, shape), link in zip(shapes, links, strict=True):
        at = list(parent).index(shape)
        parent.remove(shape)
        if link is not None:
            parent.insert(at, linked_shape(shape, link))


def linked_shape(shape: ElementTree.Element, link: ShapeLink) -> ElementTree.Element:
    """A shape that can be pressed, by mouse and by key."""
    wrapped = ElementTree.Element("g")
    for name, value in link.data.items():
        wrapped.set(f"data-{name}", without_control_characters(str(value)))
    wrapped.attrib |= {"tabindex": "0", "role": "button"}
    title = ElementTree.SubElement(wrapped, "title")
    title.text = without_control_characters(link.title)
    wrapped.append(shape)
    return wrapped


def without_control_characters(words: str) -> str:
    """Words without what XML cannot have."""
    return UNFIT.sub("\ufffd", words)


def fit_to_page(element: ElementTree.Element) -> None:
    """Write one element as a page needs it: its colours, its face, short numbers."""
    entries = (entry.partition(":") for entry in element.get("style", "").split(";"))
    style = {name.strip(): value.strip() for name, _, value in entries if value}
    for name in ("fill", "stroke"):
        if name in style:
            style[name] = PAGE_COLOURS.get(style[name].lower(), style[name])
    if element.tag == "text":
        style.pop("font-family", None)
    if element.get("class") == CLICKED:
        for name in ("fill", "fill-opacity", "stroke"):
            style.pop(name, None)
    if style:
        element.set("style", "; ".join(f"{name}: {value}" for name, value in style.items()))
    else:
        element.attrib.pop("style", None)
    if "d" in element.attrib:
        element.set("d", short_numbers(" ".join(element.attrib["d"].split())))
    for name in ("x", "y", "transform"):
        if name in element.attrib:
            element.set(name, short_numbers(element.attrib[name]))
    if LINKED in element.attrib:
        element.set("href", element.attrib.pop(LINKED))
    if element.tag not in WORDS and not (element.text or "").strip():
        element.text = None
    if not (element.tail or "").strip():
        element.tail = None


def short_numbers(text: str) -> str:
    """Numbers to a hundredth of a pixel.

    >>> short_numbers("M 42.494537 -0.000001 L 3 4.5")
    'M 42.49 0 L 3 4.5'
    """
    return re.sub(r"-?\d+\.\d+", lambda match: f"{round(float(match[0]), 2) + 0.0:g}", text)


def name_ids(root: ElementTree.Element) -> None:
    """Keep the ids that are referred to, under names that no other picture of the page has."""
    text = ElementTree.tostring(root, encoding="unicode")
    used = set(re.findall(r'(?:href="|url\(|:)#([\w.-]+)', text))
    prefix = f"fs{hashlib.sha256(text.encode('utf-8', 'replace')).hexdigest()[:8]}-"
    for element in root.iter():
        name = element.attrib.pop("id", "")
        if name in used:
            element.set("id", prefix + name)
        for key in ("href", "clip-path"):
            if key in element.attrib:
                element.set(key, re.sub(r"#(?=[\w.-]+\)?$)", f"#{prefix}", element.attrib[key]))
