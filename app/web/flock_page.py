"""Writes a flock as one HTML file: its program, what it is drawn with, and the page's own scripts.

The page's policy lets its own script run by its hash, and nothing else: it connects to nothing.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import html
import json
import math
from collections.abc import Iterator
from importlib.metadata import version
from itertools import pairwise
from string import Template
from typing import Any

import numpy as np
import shapely

from agents.flock import Flock
from agents.spec import CompleteSpec
from agents.web_program import web_program
from app.package_files import STATIC
from app.viewer.gallery.saved_scene import SavedScene, command_line
from app.viewer.panels.dials import plain_symbol
from worlds.world import World

FOLDER = STATIC / "export"
SCRIPTS = ("kernel.js", "runner.js", "view.js", "page.js")
LIVELY = 30.0
"""Ticks a second at which a page begins."""
CORNERS = 48
"""Corners of an outline from which on it is drawn without upright edges."""
CIRCLE = np.linspace(0.0, 2.0 * math.pi, 49)


def flock_page(flock: Flock, title: str = "") -> str:
    """The page of a flock that stands at its start, titled as its model is unless `title` says.

    Raises InputError for what no page can do yet.
    """
    program = web_program(flock)
    rule = flock.model.rule
    triangles, lines = drawn_obstacles(flock.world)
    manifest = program.manifest | {"triangles": triangles, "lines": lines}
    for parameter in manifest["parameters"]:
        parameter["symbol"] = plain_symbol(parameter["symbol"])
    script = "'use strict';\n" + "\n".join((FOLDER / name).read_text("utf-8") for name in SCRIPTS)
    style = (FOLDER / "page.css").read_text("utf-8")
    texts = {
        "title": title or rule.title,
        "summary": rule.summary,
        "source": rule.source,
        "command": export_command(flock.spec),
        "seed": str(flock.seed),
        "agents": str(len(flock.ids)),
        "version": version("flockscope"),
        "speed": f"{math.log10(LIVELY):.2f}",
        "policy": page_policy(script, style),
    }
    parts = {
        "manifest": json.dumps(manifest, separators=(",", ":")).replace("<", "\\u003c"),
        "module": packed(program.module),
        "memory": packed(program.memory),
        "script": script,
        "style": style,
    }
    template = Template((FOLDER / "page.html").read_text("utf-8"))
    return template.substitute({name: html.escape(text) for name, text in texts.items()} | parts)


def export_command(spec: CompleteSpec) -> str:
    """What makes the page, as far as words can say it."""
    if isinstance(spec.world, World):
        return "flockscope export spec.toml"
    return command_line(SavedScene("", spec)).replace(" lab ", " export ", 1)


def packed(content: bytes) -> str:
    """Bytes as a page can hold them: by gzip, then base 64."""
    return base64.b64encode(gzip.compress(content, mtime=0)).decode()


def page_policy(script: str, style: str) -> str:
    """The Content-Security-Policy of a page with this script and this style, and nothing more."""

    def hashed(text: str) -> str:
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        return f"'sha256-{digest}'"

    return (
        f"default-src 'none'; script-src {hashed(script)} 'wasm-unsafe-eval'; "
        f"worker-src blob:; style-src {hashed(style)}; base-uri 'none'; form-action 'none'"
    )


def drawn_obstacles(world: World) -> tuple[list[Any], list[Any]]:
    """Corners of triangles, and ends of lines, (x, y, z) each, by which obstacles are drawn.

    In the plane obstacles are filled; in space their edges are drawn.
    """
    if world.dim == 2:
        outline = shapely.union_all([one.footprint() for one in world.obstacles])
        filled = shapely.get_parts(shapely.constrained_delaunay_triangles(outline))
        corners = [corner for triangle in filled for corner in triangle.exterior.coords[:3]]
        return [rounded((x, y, 0.0)) for x, y in corners], []
    ends = [end for one in world.obstacles for end in edges(one, world)]
    return [], [rounded(end) for end in ends]


def edges(obstacle: Any, world: World) -> Iterator[tuple[float, float, float]]:
    """The ends of an obstacle's edges in space, two by two."""
    floor, ceiling = world.low[2], world.low[2] + world.size[2]
    for outline, bottom, top in obstacle.spans():
        low = floor if bottom is None else bottom
        high = ceiling if top is None else top
        for ring in (outline.exterior, *outline.interiors):
            corners = list(ring.coords)
            for (x, y), (to_x, to_y) in pairwise(corners):
                for z in (low, high):
                    yield from ((x, y, z), (to_x, to_y, z))
                if len(corners) <= CORNERS:
                    yield from ((x, y, low), (x, y, high))
    for (x, y, z), radius in getattr(obstacle, "spheres", list)():
        c, s = radius * np.cos(CIRCLE), radius * np.sin(CIRCLE)
        zero = np.zeros_like(c)
        for circle in ((c, s, zero), (c, zero, s), (zero, c, s)):
            points = np.column_stack(circle) + np.array([x, y, z])
            for start, end in pairwise(points.tolist()):
                yield from (tuple(start), tuple(end))


def rounded(corner: tuple[float, float, float]) -> list[float]:
    """A corner in few digits."""
    return [float(f"{value:.5g}") for value in corner]
