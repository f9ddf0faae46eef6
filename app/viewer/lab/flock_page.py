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
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from importlib.metadata import version
from itertools import pairwise
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
import shapely

from agents.catalogue import from_file
from agents.flock import Flock
from agents.kinds import NO_KINDS, KindTable
from agents.observables.catalogue import OBSERVABLES
from agents.spec import CompleteSpec, Spec
from agents.web.web_program import WebProgram, sliders, web_program
from app.package_files import STATIC
from app.viewer.gallery.saved_scene import SavedScene, command_line
from app.viewer.gallery.scene_steps import SceneStep, demand_in_page
from app.viewer.measuring.observable_format import observable_words
from app.viewer.panels.dials import marked_symbol
from app.viewer.scene.draw.agent_shapes import SWINGS, AgentShape, shape_of
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.colouring import KIND
from app.viewer.scene.shown.drawing_style import AS_MODEL
from worlds.file_writer import PAGES, demand_writable, write_text
from worlds.world import World

FOLDER = STATIC / "export"
SCRIPTS = ("kernel.js", "start.js", "runner.js", "view.js", "look.js", "page.js")
SHAPES, KINDS, KINDS_PAGE, FOLLOW = "shapes.js", "kinds.js", "kinds-page.js", "follow.js"
"""Of pages whose agents are no darts, whose agents differ, and whose world is open."""
LIVELY, FASTEST = 30.0, 1000.0
"""Ticks a second at which a page begins, and at most."""
CORNERS = 48
"""Corners of an outline from which on it is drawn without upright edges."""
CIRCLE = np.linspace(0.0, 2.0 * math.pi, 49)


@dataclass(frozen=True)
class PageWords:
    """What a page says of its flock, beside what its model declares."""

    title: str = ""
    """Empty: the model's."""
    watch: str = ""
    """What one should see; empty: what the rule does."""
    tries: str = ""
    """What to try first."""
    speed: float | None = None
    """Ticks a second at first; None: `LIVELY`."""
    plots: tuple[str, ...] = ()
    """Observables whose charts come first."""
    command: str = ""
    """What makes the page; empty: found from the flock's spec."""
    steps: tuple[SceneStep, ...] = ()
    """What a reader is led through; empty: the page has nothing of steps."""
    colour: str = ""
    """What colours stand for at first, where the page has that; empty: headings."""
    form: str = AS_MODEL
    """What agents are drawn as."""

    @classmethod
    def of_scene(cls, scene: SavedScene, command: str) -> PageWords:
        """Those of a scene. What it says to try is left to its steps, where it has any."""
        return cls(
            scene.title,
            scene.watch,
            "" if scene.steps else scene.tries,
            scene.speed,
            scene.plots,
            command,
            scene.steps,
            scene.look.get("colour", ""),
            scene.look.get("form", AS_MODEL),
        )


PLAIN_WORDS = PageWords()


Update = Callable[[float], None]
"""Hears the share that is done."""


def flock_page(
    flock: Flock, words: PageWords = PLAIN_WORDS, update: Update = lambda _: None
) -> str:
    """The page of a flock, which goes on from where it stands, as one file.

    Raises InputError for what no page can do yet.
    """
    return one_file(*page_parts(flock, words, update))


def one_file(page: PageText, script: str, style: str) -> str:
    """A page with all its parts in it."""
    if page.has_steps:
        script, style = with_steps(script, style)
    return page.filled(
        policy=page_policy([script], [style], page.picture_policy),
        style=f"<style>{style}</style>",
        module=f'<script type="text/plain" id="module">{packed(page.program.module)}</script>',
        memory=f'<script type="text/plain" id="memory">{packed(page.program.memory)}</script>',
        script=f"<script>{script}</script>",
    )


def with_steps(script: str, style: str) -> tuple[str, str]:
    """The script and the style of a page that may have steps."""
    return f"{script}\n{short_script('steps.js')}", style + read_style("steps.css")


def pair_page(
    flock: Flock, beside: Flock, words: PageWords = PLAIN_WORDS, update: Update = lambda _: None
) -> str:
    """The page of two flocks beside each other: each is a page in a frame, from its one start.

    Raises InputError for what no page can do.
    """
    command = words.command or f"{export_command(flock.spec)} --beside {beside.model.name}"
    own = PageWords(speed=words.speed, plots=words.plots, command=command, colour=words.colour)
    frames = []
    scripts: dict[str, None] = {}
    style = ""
    for number, one in enumerate((flock, beside)):

        def half_of(share: float, number: int = number) -> None:
            update(0.5 * (number + share))

        page, script, style = page_parts(one, own, half_of, is_fixed=True)
        scripts[script] = None
        text = html.escape(one_file(page, script, style))
        name = html.escape(one.model.rule.title)
        sandbox = "allow-scripts allow-downloads"
        frames.append(f'<iframe sandbox="{sandbox}" title="{name}" srcdoc="{text}"></iframe>')
    titles = " beside ".join(one.model.rule.title for one in (flock, beside))
    buttons = short_script("pair.js")
    return Template((FOLDER / "pair.html").read_text("utf-8")).substitute(
        policy=html.escape(page_policy([buttons, *scripts], [style])),
        version=version("flockscope"),
        title=html.escape(words.title or titles),
        watch=html.escape(words.watch),
        style=style,
        frames="\n".join(frames),
        script=buttons,
    )


VIEWER_FILES = ("viewer.js", "viewer.css")
"""What all pages of a folder share."""


def page_files(
    flock: Flock, name: str, words: PageWords = PLAIN_WORDS, update: Update = lambda _: None
) -> dict[str, bytes]:
    """The same as files of a folder on a web server: its page, which is called `name`, what runs,
    and what all pages of the folder share. Raises InputError."""
    page, _, style = page_parts(flock, words, update)
    script = page_script(has_shape=True, differ=True, is_open=True)
    script_file, style_file = VIEWER_FILES
    module, memory = f"{name}.wasm", f"{name}.bin"
    script, style = with_steps(script, style)  # one file for all pages, those without steps too
    text = page.filled(
        policy="default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src blob:; "
        f"style-src 'self'; connect-src 'self'; {page.picture_policy}"
        "base-uri 'none'; form-action 'none'",
        style=f'<link rel="stylesheet" href="{style_file}">',
        module=f'<script type="text/plain" id="module" data-file="{module}"></script>',
        memory=f'<script type="text/plain" id="memory" data-file="{memory}"></script>',
        script=f'<script src="{script_file}"></script>',
    )
    return {
        f"{name}.html": text.encode(),
        module: page.program.module,
        memory: page.program.memory,
        script_file: script.encode(),
        style_file: style.encode(),
    }


@dataclass(frozen=True)
class PageText:
    """A page that lacks but what differs between one file and a folder."""

    program: WebProgram
    texts: dict[str, str]
    manifest: str
    has_steps: bool
    has_pictures: bool = False
    """Whether a step has a picture."""

    @property
    def picture_policy(self) -> str:
        """What a Content-Security-Policy says of pictures: those that are in the page itself."""
        return "img-src data:; " if self.has_pictures else ""

    def filled(self, policy: str, **parts: str) -> str:
        """The page with its policy, and with its parts as HTML."""
        escaped = {name: html.escape(text) for name, text in self.texts.items()}
        template = Template((FOLDER / "page.html").read_text("utf-8"))
        return template.substitute(
            escaped | parts | {"manifest": self.manifest, "policy": html.escape(policy)}
        )


def page_parts(
    flock: Flock, words: PageWords, update: Update = lambda _: None, is_fixed: bool = False
) -> tuple[PageText, str, str]:
    """The page of a flock, its script and its style; see `web_program`. Raises InputError."""
    titles = [title for plot in words.plots for title in observable_words(plot).split(", ")]
    wanted = [name for name in OBSERVABLES if observable_words(name) in titles]
    wanted += [name for step in words.steps for name in (step.described_measure, step.watch)]
    program = web_program(flock, update, is_fixed, wanted)
    rule = flock.model.rule
    command = words.command or export_command(flock.spec)
    triangles, lines = drawn_obstacles(flock.world)
    obstacles = {"triangles": triangles, "lines": lines}
    colour = words.colour or (KIND if flock.kinds.kinds else "")
    form = rule.form if words.form == AS_MODEL else words.form
    shape = shape_of(flock.world.dim, flock.model.body.vehicle is not None, form)
    manifest = (
        program.manifest | obstacles | {"palette": page_palette(flock.world.dim, flock.kinds)}
    )
    manifest["tries"] = steps_to_try(flock, words)
    if colour:
        manifest["colour"] = colour
    if words.steps:
        demand_in_page(words.steps, manifest, command)
        manifest["steps"] = [step.page_values() for step in words.steps]
    first = {title: place for place, title in enumerate(dict.fromkeys(titles))}
    manifest["measures"].sort(key=lambda one: first.get(observable_words(one["name"]), len(first)))
    for parameter in manifest["parameters"]:
        parameter["symbol"] = marked_symbol(parameter["symbol"])
    if shape is not None:
        manifest["shape"] = page_shape(shape)
    script = page_script(shape is not None, "differ" in manifest, "open" in flock.world.edges)
    style = read_style("page.css")
    texts = {
        "title": words.title or rule.title,
        "watch": words.watch or rule.summary,
        "summary": rule.summary,
        "source": rule.source,
        "command": command,
        "seed": str(flock.seed),
        "agents": str(len(flock.ids)),
        "version": version("flockscope"),
        "speed": f"{math.log10(min(max(words.speed or LIVELY, 1.0), FASTEST)):.2f}",
    }
    as_json = json.dumps(manifest, separators=(",", ":")).replace("<", "\\u003c")
    has_pictures = any(step.picture for step in words.steps)
    return PageText(program, texts, as_json, bool(words.steps), has_pictures), script, style


def write_flock_page(flock: Flock, path: Path, title: str = "", overwrite: bool = False) -> None:
    """Write the page of a flock; nothing is left half-written. Raises InputError and OSError."""
    demand_writable("path", path, overwrite, PAGES)
    write_text("path", path, flock_page(flock, PageWords(title)), overwrite, PAGES)


def steps_to_try(flock: Flock, words: PageWords) -> list[dict[str, Any]]:
    """What a page proposes to try: in words, what sliders it sets, and what one then sees.

    Of what the model declares, the steps that change nothing but sliders, where the flock is as it
    was when they were found: in the model's own world, of as many agents, and nothing changed.
    """
    steps: list[dict[str, Any]] = []
    if words.tries:
        steps.append({"words": words.tries, "set": {}, "see": ""})
    model, spec = flock.model, flock.spec
    if spec == Flock(Spec(model.name, seed=spec.seed)).spec:
        moved = {slider.name for slider in sliders(flock)}
        steps += [
            {"words": step.words, "set": dict(step.set), "see": step.see}
            for step in model.to_try
            if not step.anew and set(step.set) <= moved
        ]
    return steps


class PageWriter:
    """In a process of its own, as to compile takes many seconds: writes pages of the models that
    there are, and of those of files of rules."""

    def __init__(self, files: Sequence[str]):
        for path in files:
            from_file(path)

    def write(self, spec: str) -> str:
        """The page of a flock at its start, of its spec as TOML. Raises InputError."""
        return flock_page(Flock(Spec.from_toml(spec, "the run")))

    def write_pair(self, flock: Flock, beside: Flock) -> str:
        """The page of two flocks, which go on from where they are. Raises InputError."""
        return pair_page(flock, beside)


def export_command(spec: CompleteSpec) -> str:
    """What makes the page, as far as words can say it."""
    if isinstance(spec.world, World):
        return "flockscope export spec.toml"
    return command_line(SavedScene("", spec)).replace(" lab ", " export ", 1)


def packed(content: bytes) -> str:
    """Bytes as a page can hold them: by gzip, then base 64."""
    return base64.b64encode(gzip.compress(content, mtime=0)).decode()


def page_policy(scripts: Sequence[str], styles: Sequence[str], more: str = "") -> str:
    """The Content-Security-Policy of a page with these scripts and styles, and nothing more but
    what `more` says."""

    def hashed(texts: Sequence[str]) -> str:
        digests = (hashlib.sha256(text.encode()).digest() for text in texts)
        return " ".join(f"'sha256-{base64.b64encode(one).decode()}'" for one in digests)

    return (
        f"default-src 'none'; script-src {hashed(scripts)} 'wasm-unsafe-eval'; "
        f"worker-src blob:; style-src {hashed(styles)}; {more}base-uri 'none'; form-action 'none'"
    )


@cache
def short_script(name: str) -> str:
    """A script without its comments and its indentation, which a page needs not carry."""
    lines = (FOLDER / name).read_text("utf-8").splitlines()
    bare = (re.sub(r"(^|(?<=[;,{])) *// .*", "", line).strip() for line in lines)
    return "\n".join(line for line in bare if line)


def read_style(name: str) -> str:
    """A style sheet of the page."""
    return (FOLDER / name).read_text("utf-8")


def page_script(has_shape: bool, differ: bool, is_open: bool) -> str:
    """The scripts of a page, in the order in which they need each other; `page.js` begins."""
    shapes, kinds = (SHAPES,) if has_shape else (), (KINDS, KINDS_PAGE) if differ else ()
    follow = (FOLLOW,) if is_open else ()
    names = (*SCRIPTS[:-1], *shapes, *kinds, *follow, SCRIPTS[-1])
    return "'use strict';\n" + "\n".join(short_script(name) for name in names)


def page_shape(shape: AgentShape) -> dict[str, Any]:
    """What a page has to know of its agents' shape: meshes in thousandths of the agent's size."""
    parts = [
        {
            "corners": np.rint(1000.0 * part.mesh[0]).astype(int).ravel().tolist(),
            "faces": part.mesh[1].ravel().tolist(),
            "shade": part.shade,
            "paint": "" if part.paint is None else digits(part.paint[None]),
            "hinge": part.hinge,
            "beats": SWINGS.index(part.beats),
        }
        for part in shape.parts
    ]
    motion = None if shape.motion is None else asdict(shape.motion)
    sizes = {"scale": shape.scale, "height": shape.height, "most": shape.most}
    return sizes | {"parts": parts, "motion": motion}


def page_palette(dim: int, kinds: KindTable = NO_KINDS) -> dict[str, Any]:
    """The laboratory's colours, six hexadecimal digits each, as few as a page can blend again.

    Those of headings are rows from diving to climbing, one in the plane; each row goes round from
    the azimuth 0 to itself, every 10 degrees.
    """
    rises = len(palette.HEADINGS)
    levels = [rises // 2] if dim == 2 else range(0, rises, rises // 8)
    hues = np.arange(0, 361, 10) % palette.HEADINGS.shape[1]
    return {
        "heading": [digits(palette.HEADINGS[level, hues]) for level in levels],
        "number": digits(palette.SPEEDS[::17]),
        "plain": digits(palette.PLAIN[None]),
        "informed": digits(palette.LEADER[None]),
        "group": digits(palette.GROUPS),
        "layer": digits(palette.LAYERS),
        "crashed": digits(palette.CRASHED[None]),
        "unknown": digits(palette.UNKNOWN[None]),
    } | (
        {"kind": digits(palette.kind_colours(kinds)), "caught": digits(palette.CAUGHT[None])}
        if kinds.kinds
        else {}
    )


def digits(colours: np.ndarray) -> str:
    """Colours (K, 3) as one string of hexadecimal digits."""
    return "".join(palette.css(colour)[1:] for colour in colours)


def drawn_obstacles(world: World) -> tuple[list[Any], list[Any]]:
    """Corners of triangles, and ends of lines, (x, y, z) each, by which obstacles are drawn.

    In the plane obstacles are filled; in space their edges are drawn.
    """
    if world.dim == 2:
        outline = shapely.union_all([one.footprint() for one in world.obstacles])
        filled = shapely.get_parts(shapely.constrained_delaunay_triangles(outline))
        corners = [corner for triangle in filled for corner in triangle.exterior.coords[:3]]
        triangles = [rounded((x, y, 0.0)) for x, y in corners]
        return triangles, [rounded(end) for end in mission_lines(world)]
    ends = [end for one in world.obstacles for end in edges(one, world)]
    return [], [rounded(end) for end in (*ends, *mission_lines(world))]


GOAL_SIZE = 0.02
"""Half the size of the cross at the goal, of the world's largest side."""


def mission_lines(world: World) -> Iterator[tuple[float, float, float]]:
    """The ends of what shows a mission, two by two: its path, the way of a goal that moves, or a
    cross at one that does not."""
    mission = world.mission
    if mission is None:
        return
    path, goal = mission.path, mission.goal
    ways = [(path.waypoints, path.closed)] if path is not None else []
    ways += [(goal.route, goal.closed)] if goal is not None else []
    for way, is_closed in ways:
        for start, end in pairwise((*way, way[0]) if is_closed else way):
            yield from (in_space(start), in_space(end))
    if goal is not None and len(goal.route) == 1:
        arm = GOAL_SIZE * max(world.size)
        for axis in range(world.dim):
            for sign in (-1.0, 1.0):
                moved = (x + sign * arm * (k == axis) for k, x in enumerate(goal.route[0]))
                yield in_space(tuple(moved))


def in_space(place: tuple[float, ...]) -> tuple[float, float, float]:
    """A place of two or three coordinates with three."""
    x, y, z = (*place, 0.0)[:3]
    return x, y, z


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
