"""The file of a laboratory, as the command line is given it."""

from __future__ import annotations

from pathlib import Path

from app.live.kinds import FILE, kind_of
from app.live.laboratory.lab import Lab, read_lab
from worlds.refusal import Refusal


def laboratory(file: Path, source: str | None = None, link: str | None = None) -> Lab:
    """The laboratory of a file, with another of its sources or links if one is named.

    Links that are Python files lie beside it, and are only run when they are opened. Raises
    Refusal.
    """
    lab = read_lab(file)
    folder = file.parent.resolve()
    lab = lab.model_copy(
        update={
            "link": beside(folder, lab.link),
            "links": {name: beside(folder, text) for name, text in lab.links.items()},
        }
    )
    return with_ends(lab, source, link) if source or link else lab


def beside(folder: Path, link: str) -> str:
    """The text of a link, its Python file, if it is one, with its folder. Raises Refusal."""
    kind = kind_of(link)
    if not kind.endswith(FILE):
        return link
    if not (folder / kind).is_file():
        raise Refusal(f"there is no file {folder / kind} (link {link!r})")
    return f"{folder / kind}{link.removeprefix(kind)}"


def with_ends(lab: Lab, source: str | None, link: str | None) -> Lab:
    """The laboratory with what was named of its sources and links. Raises Refusal."""
    from app.live.operating.choices import chosen, links, sources

    poses, commands = sources(lab), links(lab)
    made = chosen(lab, source or next(iter(poses)), link or next(iter(commands)), lab.rule)
    if link and made.link != commands[link]:
        raise Refusal(
            f"--link {link!r} is not allowed: emulated cars have a link of their own (--dry sends "
            "nothing)"
        )
    return made
