"""The pages of the rules say what the rules declare."""

from __future__ import annotations

import runpy
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGES = runpy.run_path(str(ROOT / "docs" / "make.py"))["pages"]()


@pytest.mark.parametrize("name", sorted(PAGES))
def test_page_is_the_declaration(name):
    written = (ROOT / "docs" / "rules" / name).read_text(encoding="utf-8")
    assert written == PAGES[name], "run `uv run python docs/make.py`"


@pytest.mark.parametrize("name", sorted(n for n in PAGES if n != "README.md"))
def test_page_has_its_picture(name):
    png = (ROOT / "docs" / "rules" / name).with_suffix(".png")
    assert png.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
