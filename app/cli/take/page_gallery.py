"""Pages of flocks in a folder of a web site, and one page that leads to all of them."""

from __future__ import annotations

import html
from pathlib import Path
from string import Template
from typing import Any

from agents import Flock
from app.cli.terminal.outcome_table import print_stderr, print_written_files
from app.cli.terminal.progress import Progress
from app.viewer.gallery.scene_collection import WORLDS, GalleryCard, cards, find_scene, pictures
from app.viewer.lab.flock_page import FOLDER, VIEWER_FILES, PageWords, page_files, pair_page
from app.viewer.run.paired_run import companion
from worlds.file_writer import demand_writable, write_bytes
from worlds.input_error import InputError


def write_folder(folder: Path, files: dict[str, bytes], overwrite: bool) -> dict[Path, int]:
    """Write a page's files into a folder; their sizes in bytes. What shows pages is the same for
    all of one version: only where it is another one is `overwrite` needed. Raises InputError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"--folder {folder} cannot be made: {error.strerror}") from None
    new = {
        folder / name: content
        for name, content in files.items()
        if name not in VIEWER_FILES or not is_same(folder / name, content)
    }
    for path in new:
        demand_writable("--folder", path, overwrite)
    for path, content in new.items():
        write_bytes("--folder", path, content, overwrite)
    return {folder / name: len(content) for name, content in files.items()}


def is_same(path: Path, content: bytes) -> bool:
    """Whether a file is there and has this content."""
    return path.is_file() and path.read_bytes() == content


INDEX = "index.html"
LINK = (
    '<a class="card" href="{page}">{picture}<h2>{title}</h2><p>{line}</p><small>{size}</small></a>'
)


def write_gallery(folder: Path, overwrite: bool, quiet: bool) -> dict[str, Any]:
    """Write a page of every scene and model, and INDEX; what was written, in bytes, and what was
    refused, and why. Raises InputError."""
    if folder.exists():
        demand_writable("--folder", folder / INDEX, overwrite)
    shown = [card for card in cards() if card.group != WORLDS]
    sizes: dict[str, int] = {}
    refused: dict[str, str] = {}
    links = []
    with Progress("pages", quiet) as progress:
        for number, card in enumerate(shown):
            progress.update(number / len(shown), text=card.title)
            name = card.name.replace(":", "-")
            try:
                opened = find_scene(card.name)
                words = PageWords.of_scene(opened, f"flockscope export --scene {card.name}")
                flock = Flock(opened.spec)
                if opened.beside is None:
                    files = page_files(flock, name, words)
                else:
                    page = pair_page(flock, companion(flock, opened.beside), words)
                    files = {f"{name}.html": page.encode()}
            except InputError as refusal:
                refused[card.name] = str(refusal)
                continue
            picture = pictures().get(card.picture)
            files |= {} if picture is None else {card.picture: picture}
            written = write_folder(folder, files, overwrite)
            sizes |= {path.name: size for path, size in written.items()}
            own = sum(size for path, size in written.items() if path.name not in VIEWER_FILES)
            links.append(link_to(card, f"{name}.html", own))
    index = Template((FOLDER / "index.html").read_text("utf-8")).substitute(
        style=VIEWER_FILES[1], links="\n".join(links)
    )
    write_bytes("--folder", folder / INDEX, index.encode(), overwrite)
    if not quiet:
        for name, why in refused.items():
            print_stderr(f"flockscope: {name} has no page: {why}")
        print_written_files(folder / INDEX)
    return {"index": str(folder / INDEX), "files": sizes, "refused": refused}


def link_to(card: GalleryCard, page: str, size: int) -> str:
    """The way to a page, as HTML."""
    picture = f'<img src="{card.picture}" alt="" loading="lazy">' if card.picture else ""
    return LINK.format(
        page=html.escape(page),
        picture=picture,
        title=html.escape(card.title),
        line=html.escape(card.line),
        size=f"{size / 1000:.0f} kB",
    )
