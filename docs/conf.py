"""How Sphinx makes the site of these pages; `docs/build_site.py` calls it.

Markdown pages read well as files too. What only the site has is reStructuredText: its sections, and
what `made_pages.py` writes into `_made` from declarations.
"""

from __future__ import annotations

import re
import sys
from html import escape
from importlib import metadata
from pathlib import Path
from typing import Any

from docutils.nodes import SkipNode

HERE = Path(__file__).parent
ROOT = HERE.parent
sys.path[:0] = [str(HERE), str(ROOT)]

import made_pages  # noqa: E402

from app.viewer.panels.dials import as_text, in_mathtext, line_svg  # noqa: E402

FLOCKS = HERE / "_build" / "run"
"""Pages that run flocks, which `build_site.py` has written."""
RUNNING = {"rules": "model-", "lessons": "lesson-"}
"""Folders of pages of what runs, and what its page is called before its name."""
SIZE = 13.5
"""Of letters in an equation, pt."""

project = "flockscope"
author = "The flockscope authors"
copyright = "the flockscope authors. MIT licence"
release = metadata.version("flockscope")
extensions = ["myst_nb", "sphinx_design", "sphinx.ext.autodoc"]
suppress_warnings = ["misc.highlighting_failure"]  # CSV and WKT, which Pygments does not know
exclude_patterns = ["_build", "**/__pycache__", "**.ipynb_checkpoints", "README.md"]
default_role = "literal"
highlight_language = "text"
nitpicky = False
smartquotes = False

myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 4
myst_dmath_double_inline = True
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 600
nb_execution_in_temp = True
nb_output_stderr = "remove"  # what libraries say of the notebook itself

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
python_use_unqualified_type_names = True
autodoc_default_options = {"members": True}

html_theme = "pydata_sphinx_theme"
html_title = "flockscope"
html_logo = "../static/logo.svg"
html_favicon = "../static/logo.svg"
html_static_path = ["_static", "../static/gallery"]
html_css_files = ["site.css"]
html_js_files = ["gallery.js"]
html_copy_source = False
html_show_sourcelink = False
html_theme_options = {
    "logo": {"text": "flockscope"},
    "navbar_end": ["theme-switcher"],
    "navbar_persistent": ["search-button"],
    "header_links_before_dropdown": 9,
    "show_nav_level": 1,
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}
html_use_index = False
html_sidebars = {"index": [], "_made/gallery": []}
html_context = {"default_mode": "auto"}


def complete_page(app: Any, name: str, source: list[str]) -> None:
    """Turn links that leave docs/ to pages of the site where it has them, else into names; put a
    button below the title of a model or a lesson that runs in the site."""
    if name.startswith("_made/"):
        return
    source[0] = made_pages.rewrite_links(source[0], name.count("/"))
    kind, _, card = name.partition("/")
    page = f"{RUNNING.get(kind, '')}{card}.html"
    if kind in RUNNING and app.tags.has("flocks") and (FLOCKS / page).is_file():
        title, _, rest = source[0].partition("\n")
        button = made_pages.run_button(f"../run/{page}", title.lstrip("# "), "Run it in this page")
        source[0] = f'{title}\n\n<p class="flock-run">{button}</p>\n{rest}'


def rewrite_docstring(
    _app: Any, _kind: str, _name: str, _of: Any, _options: Any, lines: list[str]
) -> None:
    """Make reStructuredText of a docstring."""
    made_pages.rewrite_docstring(lines)


def short_signature(
    _app: Any, _kind: str, _name: str, thing: Any, _options: Any, _signature: str, _returns: str
) -> tuple[str, str] | None:
    """The keys of a table that pydantic checks; its types are in the text."""
    return made_pages.signature_of(thing)


def write_inline(self: Any, node: Any) -> None:
    """Write a symbol as text, with what stands below and above it."""

    def small(match: re.Match[str]) -> str:
        tag = "sub" if match[1] == "_" else "sup"
        return f"<{tag}>{match[2].strip('{}')}</{tag}>"

    self.body.append(f'<i class="math">{as_text(escape(node.astext()), small)}</i>')
    raise SkipNode


def write_block(self: Any, node: Any) -> None:
    """Write an equation as SVG in the colour of the text, broken where it has wide gaps: nothing is
    loaded, and nothing runs."""
    lines = re.split(r"\\qquad|\\\\\s*\n", node.astext())
    shown = "".join(f"<div>{as_svg(line.strip().rstrip(','))}</div>" for line in lines)
    self.body.append(f'<div class="math">{shown}</div>')
    raise SkipNode


def as_svg(latex: str) -> str:
    """LaTeX as an SVG element. Raises ValueError where it cannot be set."""
    svg = line_svg(in_mathtext(latex), SIZE)
    if svg is None:
        raise ValueError(f"the formula {latex!r} cannot be set")
    return svg


def setup(app: Any) -> dict[str, bool]:
    """Called by Sphinx."""
    made_pages.write_all(HERE / "_made", FLOCKS if app.tags.has("flocks") else None)
    app.add_html_math_renderer("svg", (write_inline, None), (write_block, None))
    app.connect("source-read", complete_page)
    app.connect("autodoc-process-signature", short_signature)
    app.connect("autodoc-process-docstring", rewrite_docstring)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


html_math_renderer = "svg"
