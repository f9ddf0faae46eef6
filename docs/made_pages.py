"""Pages of the site that are made from declarations when it is built: nothing of them is kept.

Commands, what may be imported, files with their keys, observables, parameters, the gallery, and
the pages of the repository's root.
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from html import escape
from importlib import import_module
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Union, get_args, get_origin

import typer
from pydantic import BaseModel
from sphinx.pycode import ModuleAnalyzer
from typer.cli import get_docs_for_click

from agents.catalogue import MODELS
from agents.models.declare import declared
from agents.option import Option
from agents.spec import Spec
from app.cli.main import COMMANDS, load
from app.live.laboratory.lab_file import Lab
from app.studies.experiment_file import ExperimentFile
from app.studies.optimisation.study import OptimisationFile
from app.studies.sweeps.sweep_file import SweepFile
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.gallery.scene_collection import GROUPS, LESSON, MODEL, GalleryCard, cards
from app.viewer.gallery.scene_steps import SceneStep

ROOT = Path(__file__).parents[1]
SCENE_KEYS = {"tries": "try", "spec": "run"}
"""Keys of a scene's file that are called otherwise in the code."""
ROOT_PAGES = {
    "CONTRIBUTING.md": "contributing",
    "CHANGELOG.md": "changes",
    "SECURITY.md": "security",
    "THIRD-PARTY.md": "third-party",
}
"""Pages of the repository's root, and what they are called in the site."""
MODULES = ("", *(f".{name}" for name in ("rules", "worlds", "observables", "flight", "live")))
"""What may be imported, behind `flockscope`."""
FILES: dict[str, tuple[type[BaseModel], str]] = {
    "A run (spec)": (Spec, "[From Python](../python.md) and `flockscope run FILE.toml`."),
    "A step of a lesson": (
        SceneStep,
        "`[[steps]]` of a scene: [a flock as a web page](../export.md).",
    ),
    "A sweep": (SweepFile, "[Sweeps](../sweeps.md)."),
    "A search": (OptimisationFile, "[Optimisation](../optimisation.md)."),
    "An experiment of a paper": (ExperimentFile, "[The papers](../papers.md)."),
    "A laboratory of cars (lab.toml)": (Lab, "[Real cars](../live.md)."),
}
"""Files that people write: the class that reads them, and the page that explains them."""


def write_all(folder: Path, flocks: Path | None) -> None:
    """Write every page; one that is as it was is left alone, so that Sphinx reads it once.

    `flocks` is the folder of the pages that run flocks, if the site has them.
    """
    folder.mkdir(exist_ok=True)
    pages = {
        "command-line.md": command_line(),
        "python-api.rst": python_api(),
        "file-formats.md": file_formats(),
        "parameters.md": parameters(),
        "gallery.md": gallery(flocks),
    } | {f"{name}.md": root_page(file) for file, name in ROOT_PAGES.items()}
    for path in folder.iterdir():
        if path.name not in pages:
            path.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def rewrite_links(text: str, depth: int) -> str:
    """The text of a page `depth` folders below docs/, its links out of there as the site has them.

    >>> rewrite_links("[a](../README.md#start), [b](../SECURITY.md), [c](../agents/spec.py)", 0)
    '[a](index.rst), [b](_made/security.md), `agents/spec.py`'
    """
    up = "../" * depth

    def rewritten(match: re.Match[str]) -> str:
        words, path, anchor = match[1], match[2], match[3] or ""
        if path == "README.md":
            return f"[{words}]({up}index.rst)"
        if path in ROOT_PAGES:
            return f"[{words}]({up}_made/{ROOT_PAGES[path]}.md{anchor})"
        plain = words.strip("`")
        return f"`{path}`" if plain == path else f"{words} (`{path}`)"

    return re.sub(
        rf"(?<!!)\[([^\]]+)\]\({re.escape(up)}\.\./([\w./-]+)(#[\w-]+)?\)", rewritten, text
    )


def root_page(file: str) -> str:
    """A page of the repository's root, with its links as they are from here."""
    text = (ROOT / file).read_text(encoding="utf-8")

    def rewritten(match: re.Match[str]) -> str:
        words, path, anchor = match[1], match[2], match[3] or ""
        if path in ROOT_PAGES:
            return f"[{words}]({ROOT_PAGES[path]}.md{anchor})"
        if path == "README.md":
            return f"[{words}](../index.rst)"
        if path.startswith("docs/") and path.endswith((".md", ".ipynb")):
            return f"[{words}](../{path.removeprefix('docs/')}{anchor})"
        return f"`{path}`" if words.strip("`") == path else f"{words} (`{path}`)"

    return re.sub(
        r"(?<!!)\[([^\]]+)\]\((?!https?:|#|mailto:)([\w./-]+)(#[\w-]+)?\)", rewritten, text
    )


def command_line() -> str:
    """Every command with its arguments and options, as `--help` says them."""
    parts = [
        "# The command line",
        "`flockscope COMMAND --help` prints the same. Without a command, flockscope opens the "
        "laboratory.",
    ]
    for name, entry in COMMANDS.items():
        command = load(name)
        context = typer.Context(command, info_name=name)
        text = get_docs_for_click(obj=command, ctx=context, name=name, call_prefix="flockscope")
        text = re.sub(r"^(#+) ", r"#\1 ", text, flags=re.M)
        parts.append(text.replace("\\[", "[").strip() or entry.summary)
    return "\n\n".join(parts) + "\n"


def python_api() -> str:
    """What may be imported, module by module, from their docstrings."""
    parts = [
        "Python",
        "======",
        "",
        "What is named here may be imported; nothing else is promised.",
    ]
    described: dict[int, str] = {}
    for name in MODULES:
        module = import_module(f"flockscope{name}")
        names = [
            public for public in module.__all__ if id(getattr(module, public)) not in described
        ]
        others = sorted(set(module.__all__) - set(names))
        parts += ["", f"flockscope{name}", "-" * len(f"flockscope{name}")]
        parts += ["", (inspect.getdoc(module) or "").split("\n\n")[0]]
        if others:
            parts += [
                "",
                f"It also has {', '.join(f'`{other}`' for other in others)}, described above.",
            ]
        parts += ["", f".. currentmodule:: flockscope{name}"]
        for public in names:
            thing = getattr(module, public)
            described[id(thing)] = public
            parts += ["", *directive_of(thing, public)]
    return "\n".join(parts) + "\n"


def rewrite_docstring(lines: list[str]) -> None:
    """Make reStructuredText of a docstring, in place: its headings, its lists of parameters."""
    paragraphs = [part.split("\n") for part in "\n".join(lines).strip().split("\n\n")]
    lines[:] = [line for part in paragraphs for line in (*rewritten_paragraph(part), "")]


def rewritten_paragraph(lines: list[str]) -> list[str]:
    """A paragraph of a docstring as reStructuredText."""
    if lines[0].lstrip().startswith(">>>"):
        return lines
    heading = []
    if len(lines) > 1 and re.fullmatch(r"-{3,}", lines[1]):
        heading, lines = [f"**{lines[0]}**", ""], lines[2:]
    items: list[str] = []
    for line in lines:
        if items and (line.startswith(" ") or not heading):
            items[-1] += f" {line.strip()}"
        else:
            items.append(line.strip())
    escaped = [re.sub(r"(`[^`]*`)|([*|])", lambda m: m[1] or f"\\{m[2]}", item) for item in items]
    return heading + [f"- {item}" for item in escaped] if heading else escaped


def directive_of(thing: Any, name: str) -> Iterator[str]:
    """How autodoc is told of a name: by the kind of what it stands for."""
    if inspect.isclass(thing) or get_origin(thing):
        yield f".. autoclass:: {name}"
    elif callable(thing):
        yield f".. autofunction:: {name}"
    else:
        yield f".. data:: {name}"
        yield ""
        yield f"   {describe(thing)}"


def signature_of(thing: Any) -> tuple[str, str] | None:
    """How a class that pydantic checks is called; None for what has a signature of its own."""
    if not (inspect.isclass(thing) and issubclass(thing, BaseModel)):
        return None
    keys = [
        name if field.is_required() else f"{name}={field.get_default(call_default_factory=True)!r}"
        for name, field in thing.model_fields.items()
    ]
    return f"({', '.join(keys)})", ""


def describe(thing: Any) -> str:
    """What a value is, in a sentence."""
    title = getattr(thing, "title", None)
    return f"{type(thing).__name__}: {title}" if isinstance(title, str) else type(thing).__name__


def file_formats() -> str:
    """Every file that people write, key by key, from the classes that read them."""
    parts = [
        "# Files and their keys",
        "All of these are TOML. An unknown key is an error that names the file and the key. "
        "Layouts of worlds have [a page of their own](../worlds.md), recordings "
        "[too](../recordings.md), and the file of a class is [a ZIP file](../class.md).",
    ]
    scene = ModuleAnalyzer.for_module(SavedScene.__module__).find_attr_docs()
    rows = [
        f"| `{SCENE_KEYS.get(name, name)}` | {' '.join(scene['SavedScene', name]).strip()} |"
        for name in SavedScene.__dataclass_fields__
        if ("SavedScene", name) in scene
    ]
    parts += [
        "## A scene",
        "[Scene files](../laboratory-studies.md#scene-files). `run` has the keys of a run.",
        "\n".join(["| key | what it is |", "|---|---|", "| `title` | Its title. |", *rows]),
    ]
    for title, (table, where) in FILES.items():
        parts += [f"## {title}", where, key_table(table)]
        parts += [
            f"### {title}: `{key}`\n\n{key_table(inner)}" for key, inner in tables_in(table).items()
        ]
    return "\n\n".join(parts) + "\n"


def tables_in(table: type[BaseModel]) -> dict[str, type[BaseModel]]:
    """The tables within a table, by their keys."""
    found: dict[str, type[BaseModel]] = {}
    for name, field in table.model_fields.items():
        for inner in models_in(field.annotation):
            found[name if name not in found else f"{name}, as {inner.__name__}"] = inner
            for key, deeper in tables_in(inner).items():
                found[f"{name}.{key}"] = deeper
    return found


def models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """The classes of tables that a type names."""
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        yield annotation
    if get_origin(annotation) is Annotated:
        yield from models_in(get_args(annotation)[0])
    else:
        for inner in get_args(annotation):
            yield from models_in(inner)


def key_table(table: type[BaseModel]) -> str:
    """The keys of a table: kind, default and what each is."""
    rows = ["| key | kind | default | what it is |", "|---|---|---|---|"]
    for name, field in table.model_fields.items():
        default = "needed" if field.is_required() else default_words(field.get_default())
        about = about_key(table, name).replace("|", "\\|")
        rows.append(f"| `{name}` | {kind_words(field.annotation)} | {default} | {about} |")
    return "\n".join(rows)


def about_key(table: type[BaseModel], name: str) -> str:
    """What a key is: as the option that it is on the command line too, or from the table."""
    extra = table.model_fields[name].json_schema_extra
    option = extra.get("option") if isinstance(extra, dict) else None
    if isinstance(option, Option):
        return option.help + "."
    return table.model_fields[name].description or attribute_doc(table, name)


def attribute_doc(table: type[BaseModel], name: str) -> str:
    """The docstring below a field, of the class or of one above it."""
    for owner in table.__mro__:
        if name in inspect.get_annotations(owner):
            docs = ModuleAnalyzer.for_module(owner.__module__).find_attr_docs()
            return " ".join(docs.get((owner.__name__, name), ())).strip()
    return ""


def default_words(value: Any) -> str:
    """A default value as a file has it; tables and lists stand elsewhere."""
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    if isinstance(value, int | float | str) and value != "":
        return f"`{value}`"
    return ""


KINDS = {
    bool: "true or false", int: "whole number", float: "number", str: "text",
    list: "list", tuple: "list", dict: "table", type(None): "",
}  # fmt: skip


def kind_words(annotation: Any) -> str:
    """What kind of value a key has, in the words of people."""
    origin, inner = get_origin(annotation), get_args(annotation)
    if origin in (Union, UnionType):
        return " or ".join(dict.fromkeys(filter(None, map(kind_words, inner))))
    if origin is Annotated:
        return kind_words(inner[0])
    if str(origin).endswith("Literal"):
        return " or ".join(f"`{value}`" for value in inner)
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        return "table"
    return KINDS.get(origin or annotation, "text")


def parameters() -> str:
    """The parameters of all models, one table in the order of their names."""
    rows = sorted(
        (parameter.name, name, parameter)
        for name, model in MODELS.items()
        for parameter in declared(model.parameters)
    )
    lines = [
        f"| `{name}` | [{model}](../rules/{model}.md) | ${parameter.symbol}$ "
        f"| {parameter.default} | {parameter.allowed} | {parameter.description} |".replace(
            "\n", " "
        )
        for name, model, parameter in rows
    ]
    return "\n".join(
        [
            "# Parameters of all models",
            "",
            "The page of each model says where a parameter comes from.",
            "",
            "| name | model | symbol | default | allowed | what it is |",
            "|---|---|---|---|---|---|",
            *lines,
            "",
        ]
    )


def gallery(flocks: Path | None) -> str:
    """Every scene, lesson and model, with its picture; a press runs it in the page."""
    runs = (
        "Press *Run*: the flock runs in your browser. Nothing is installed, nothing leaves your "
        "machine. `flockscope lab` opens the same with all controls."
    )
    alone = "This copy of the site has no flocks that run: `flockscope lab` opens each of them."
    parts = ["# Gallery", runs if flocks else alone]
    for group in GROUPS:
        shown = [card for card in cards() if card.group == group]
        if shown:
            grid = "\n".join(card_html(card, flocks) for card in shown)
            parts += [f"## {group}", f'<div class="flock-cards">\n{grid}\n</div>']
    return "\n\n".join(parts) + "\n"


def run_button(page: str, title: str, words: str) -> str:
    """A button that runs a flock's page, HTML; see `_static/gallery.js`."""
    return (
        f'<button data-run="{page}" aria-label="Run {escape(title, quote=True)}">{words}</button>'
    )


def card_html(card: GalleryCard, flocks: Path | None) -> str:
    """A card: picture, title, what it is, a button if it runs, and where to read on."""
    page = f"{card.name.replace(':', '-')}.html"
    links = []
    if flocks is not None and (flocks / page).is_file():
        links.append(run_button(f"../run/{page}", card.title, "Run"))
    if card.name.startswith(MODEL):
        links.append(f'<a href="../rules/{card.name.removeprefix(MODEL)}.html">Read more</a>')
    elif card.name.startswith(LESSON):
        links.append(f'<a href="../lessons/{card.name.removeprefix(LESSON)}.html">Read more</a>')
    return (
        f'<div class="flock-card"><img src="../_static/{card.picture}" alt="" loading="lazy" '
        f'width="360" height="240"><h3>{escape(card.title)}</h3><p>{escape(card.line)}</p>'
        f'<p class="flock-links">{" ".join(links)}</p></div>'
    )
