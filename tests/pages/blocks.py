"""The blocks of code on README and the pages of docs/, in the order in which they are printed."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = [
    "README.md",
    *(
        str(page.relative_to(ROOT))
        for page in sorted((ROOT / "docs").rglob("*.md"))
        if not {"_build", "_made"} & set(page.parts)  # which the site is made with
    ),
]
SHELL = ("", "sh", "bash", "console", "shell")
"""What a fence may say of commands; a block by indentation says nothing."""
PIECE = re.compile(
    r"^(?P<fence>`{3,}|~{3,})[ \t]*(?P<language>[\w-]*)[^\n]*\n(?P<fenced>.*?)^(?P=fence)[ \t]*$"
    r"|(?<=\n\n)(?P<indented>(?:    [^\n]*\n|\n(?=\n*    ))+)"
    r"|^(?P<prose>[^\n]+\n?)",
    re.MULTILINE | re.DOTALL,
)
SAVED = re.compile(r"[Ss]aved as\s+`([^`\s]+)`")
"""How a page gives a block the name of its file, in the paragraph before or after the block."""


@dataclass(frozen=True)
class Block:
    """A block of code: its page, its first line there, what a fence calls it, its text.

    `file` is the name under which the page tells the reader to save it, "" if it does not.
    """

    page: str
    line: int
    language: str
    code: str
    indented: bool
    file: str = ""

    @property
    def is_shell(self) -> bool:
        """Whether it is printed as commands are."""
        return self.language in SHELL

    @property
    def lines(self) -> list[str]:
        """Its lines but for the empty ones, those that end with a backslash joined."""
        return [line for line in self.code.replace("\\\n", " ").splitlines() if line.strip()]

    def __str__(self) -> str:
        return f"{self.page}:{self.line}"


def text_of(page: str) -> str:
    """The text of a page."""
    return (ROOT / page).read_text(encoding="utf-8")


def blocks_of(page: str, text: str | None = None) -> list[Block]:
    """The blocks of a page, of its file or of another text."""
    text = text_of(page) if text is None else text
    found = []
    for piece in PIECE.finditer(text):
        if piece["prose"] is not None:
            continue
        indented = piece["indented"] is not None
        code = piece["indented"] if indented else piece["fenced"]
        if indented:
            code = re.sub(r"^    ", "", code, flags=re.MULTILINE).strip("\n") + "\n"
        before = text[: piece.start()].rstrip("\n").rpartition("\n\n")[2]
        after = text[piece.end() :].lstrip("\n").partition("\n\n")[0]
        named = SAVED.search(before) or SAVED.search(after)
        found.append(
            Block(
                page=page,
                line=text.count("\n", 0, piece.start()) + 1 + (not indented),
                language=piece["language"] or "",
                code=code,
                indented=indented,
                file=named[1] if named else "",
            )
        )
    return found


BLOCKS = [block for page in PAGES for block in blocks_of(page)]
INLINE = re.compile(r"(?<!`)`(flockscope [^`]+)`(?!`)")
"""A command within a sentence."""


def inline_commands(page: str) -> list[str]:
    """The commands within the sentences of a page, line breaks as spaces."""
    return [" ".join(found.split()) for found in INLINE.findall(text_of(page))]
