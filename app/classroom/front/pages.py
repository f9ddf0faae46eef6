"""The pages that the front serves itself: how one comes in, the laboratory's, the teacher's."""

from __future__ import annotations

import html
from dataclasses import dataclass
from functools import cache
from string import Template

from app.front.client_page import font_face, hashed
from app.front.page_front import policy
from app.package_files import STATIC

FOLDER = STATIC / "classroom"
THEME = "classroom/theme.js"
STYLES = ("page.css", "classroom/pages.css")


@dataclass(frozen=True)
class Page:
    """A page of our own, whose words are put in where it says $name."""

    template: Template
    hashes: tuple[str, ...]

    def filled(self, **words: str) -> str:
        """The page with these words, which stand in it as text."""
        return self.template.substitute({name: html.escape(text) for name, text in words.items()})

    def policy(self, lines: tuple[str, ...] = ()) -> str:
        """What it may do; its forms are sent here alone."""
        return policy(self.hashes, lines).replace("form-action 'none'", "form-action 'self'")


@cache
def own_page(name: str, scripts: tuple[str, ...] = ()) -> Page:
    """A page of `static/classroom` with its scripts and styles in itself."""
    texts = [(STATIC / one).read_text("utf-8") for one in scripts]
    style = font_face() + "".join((STATIC / one).read_text("utf-8") for one in STYLES)
    added = f"<style>{style}</style>" + "".join(f"<script>{text}</script>" for text in texts)
    page = (FOLDER / name).read_text("utf-8")
    page = page.replace("</head>", added.replace("$", "$$") + "</head>")
    return Page(Template(page), tuple(hashed(text.encode()) for text in texts))
