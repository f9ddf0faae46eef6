"""SVG drawings: what a browser would fill is solid, on the layers of Inkscape, with y upwards."""

import itertools
import math

import pytest
import shapely

from worlds.input_error import InputError
from worlds.obstacles import Disc
from worlds.readers import read_geometry
from worlds.readers.drawing_contents import MOST_ITEMS, PlanQuestion

HEAD = (
    '<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" '
    'xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape" viewBox="0 0 20 12" '
    'width="200mm" height="120mm">'
)
SOLID = {"obstacle": ["*"]}


@pytest.fixture
def svg(tmp_path):
    class Drawing:
        path = tmp_path / "room.svg"

        def read(self, body, roles=SOLID, unit="m", **options):
            self.path.write_text(f"{HEAD}{body}</svg>")
            return read_geometry(self.path, roles, unit=unit, **options)

        def refused(self, body, **options):
            with pytest.raises(InputError) as refusal:
                self.read(body, **options)
            line = str(refusal.value)
            assert "room.svg" in line
            assert "\n" not in line
            return line

    return Drawing()


def layer(label, body, more=""):
    return f'<g inkscape:groupmode="layer" inkscape:label="{label}" id="l1" {more}>{body}</g>'


def test_layers_are_those_of_inkscape(svg):
    body = (
        layer("walkable", '<rect width="20" height="12"/>')
        + layer("Pillars", '<g id="g7"><circle cx="4" cy="3" r="1" id="north"/></g>')
        + '<g id="kiosk"><rect x="10" y="10" width="3" height="1"/></g>'
        + '<rect class="tree" x="17" width="1" height="1"/><text>Hall</text>'
    )
    taken = svg.read(body, roles=None)
    assert {row.layer: row.role for row in taken.layers} == {
        "walkable": "walkable", "Pillars": "obstacle", "kiosk": "obstacle", "tree": "obstacle",
        "unnamed": "ignore",
    }  # fmt: skip
    disc, kiosk, tree = taken.obstacles
    assert disc == Disc(name="Pillars", centre=(4, 9), radius=1)
    assert kiosk.footprint().equals(shapely.box(10, 1, 13, 2))
    assert tree.footprint().equals(shapely.box(17, 11, 18, 12))
    assert taken.walkable.equals(shapely.box(0, 0, 20, 12))
    assert taken.changes == ("1 text on layer 'unnamed' left out",)


def test_transforms_and_uses_are_followed(svg):
    body = (
        '<defs><rect id="r" width="2" height="1"/></defs>'
        '<g transform="translate(5 4)"><use xlink:href="#r" x="1" transform="rotate(90)"/></g>'
        '<circle r="1" transform="translate(10 6) scale(2)"/>'
    )
    turned, disc = svg.read(body).obstacles
    # x: 5 - 1 to 5, y downwards: 4 + 1 to 4 + 3.
    assert turned.footprint().symmetric_difference(shapely.box(4, 5, 5, 7)).area < 1e-9
    assert disc == Disc(name="obstacle", centre=(10, 6), radius=2)
    (oblique,) = svg.read('<circle cx="3" cy="3" r="1" transform="skewX(45)"/>').obstacles
    assert oblique.footprint().area == pytest.approx(math.pi, rel=1e-3)
    assert oblique.footprint().bounds[3] == pytest.approx(10.0, abs=1e-3)
    width = oblique.footprint().bounds[2] - oblique.footprint().bounds[0]
    assert width == pytest.approx(2 * math.sqrt(2), rel=1e-3)
    (tilted,) = svg.read('<rect x="3" width="4" height="1" transform="rotate(30)"/>').obstacles
    assert tilted.footprint().area == pytest.approx(4.0)
    x, y = 3 * math.cos(math.pi / 6), 12 - 3 * math.sin(math.pi / 6)
    assert tilted.points[0] == pytest.approx((x, y))


@pytest.mark.parametrize(
    ("inner", "rule", "area"),
    [
        ("M1 1h2v2h-2z", "nonzero", 16.0),
        ("M1 1v2h2v-2z", "nonzero", 12.0),
        ("M1 1h2v2h-2z", "evenodd", 12.0),
    ],
)
def test_fill_rules_say_what_is_a_hole(svg, inner, rule, area):
    body = f'<path d="M0 0h4v4h-4z{inner}" fill-rule="{rule}"/>'
    (made,) = svg.read(body).obstacles
    assert made.footprint().area == area


def test_curves_are_drawn_by_chords(svg):
    body = (
        '<ellipse cx="10" cy="6" rx="4" ry="2"/>'
        '<path d="M0 0a2 2 0 0 1 4 0z"/><path d="M10 0c0 2 4 2 4 0z"/>'
    )
    ellipse, half, bow = (one.footprint() for one in svg.read(body).obstacles)
    assert ellipse.area == pytest.approx(math.pi * 8, rel=1e-3)
    assert half.area == pytest.approx(math.pi * 2, rel=1e-3)
    assert bow.area == pytest.approx(4.8, rel=2e-3)  # 3/5 of width times height of the handles


def test_lines_without_a_fill_are_lines(svg):
    body = layer(
        "Walls",
        '<path d="M1 1h10v5h-10z" style="fill:none;stroke:black"/>'
        '<line x1="13" y1="1" x2="13" y2="5" stroke="black"/>'
        '<polyline points="15,1 18,1 18,4" fill="none"/>',
    )
    assert "an open line from (13, 11) to (13, 7)" in svg.refused(body, roles=None)
    closed, straight, bend = (
        one.footprint().area for one in svg.read(body, roles=None, thickness=0.2).obstacles
    )
    assert closed == pytest.approx(10.2 * 5.2 - 9.8 * 4.8)
    assert (straight, bend) == (pytest.approx(0.8), pytest.approx(1.2))


def test_the_unit_is_asked_for(svg):
    body = layer("walkable", '<rect width="20" height="12"/>')
    with pytest.raises(PlanQuestion, match=r"room.svg does not say its unit") as question:
        svg.read(body, roles=None, unit=None)
    options = [choice.options for choice in question.value.choices]
    assert {"unit": "cm"} in options
    assert svg.read(body, roles=None, unit="ft").walkable.area == pytest.approx(240 * 0.3048**2)


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("<g", "is not SVG"),
        ('<path d="M0 0L2 2L2 0L0 2z"/>', "path 1: the outline crosses itself at (1, 11)"),
        ('<path id="bow" d="M0 0L1e20 2L2 0z"/>', "path 1 'bow': point 2 is"),
        ('<g id="a"><use xlink:href="#a"/></g>', "the element 'a' uses itself"),
        ("<g>" * 60 + "</g>" * 60, "nested more than 50 deep"),
        ("", "there is nothing on its layers"),
        ('<path d="M 0 0 L x"/>', "room.svg"),
        ('<rect width="wide" height="2"/>', "room.svg"),
    ],
)
def test_what_cannot_be_used_is_told(svg, body, words):
    assert words in svg.refused(body)


def test_drawings_that_multiply_are_refused_before_they_do(svg):
    groups = "".join(
        f'<g id="g{k}">' + f'<use xlink:href="#g{k + 1}"/>' * 10 + "</g>" for k in range(9)
    )
    body = f'<defs>{groups}<rect id="g9" width="1" height="1"/></defs><use xlink:href="#g0"/>'
    assert f"draws more than {MOST_ITEMS} elements" in svg.refused(body)


@pytest.mark.parametrize("href", ['xlink:href="!g{}"', 'href="#g{0}" xlink:href="#"'])
def test_uses_are_counted_as_the_library_follows_them(svg, href):
    uses = [href.format(k) for k in range(10)]
    groups = "".join(f'<g id="g{k}">' + f"<use {uses[k + 1]}/>" * 10 + "</g>" for k in range(9))
    body = f'<defs>{groups}<rect id="g9" width="1" height="1"/></defs><use {uses[0]}/>'
    assert f"draws more than {MOST_ITEMS} elements" in svg.refused(body)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_entities_are_not_read_in_whatever_letters_they_are_written(tmp_path, encoding):
    path = tmp_path / "bomb.svg"
    text = f'<?xml version="1.0" encoding="{encoding}"?><!DOCTYPE svg [<!ENTITY a "x">]>'
    path.write_text(text + "<svg>&a;</svg>", encoding)
    with pytest.raises(InputError, match="it declares entities, which are not read"):
        read_geometry(path)


def test_entities_are_not_read(tmp_path):
    path = tmp_path / "bomb.svg"
    names = "abcdefgh"
    entities = "".join(f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in itertools.pairwise(names))
    path.write_text(f'<!DOCTYPE svg [<!ENTITY a "x">{entities}]><svg>&h;</svg>')
    with pytest.raises(InputError, match="it declares entities, which are not read"):
        read_geometry(path)
    path.write_text("<html><body/></html>")
    with pytest.raises(InputError, match="its outermost element is 'html'"):
        read_geometry(path)
