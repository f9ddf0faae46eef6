"""Build the site of these pages into a folder, strictly, and check what came of it.

    uv run python docs/build_site.py [--out site] [--no-flocks] [--wheel dist]

A warning of Sphinx, a link that leads nowhere, a picture without words and a site that has more
than 15 MB when it is packed as a wheel are errors. `--no-flocks` leaves out the pages that run
flocks, which take many minutes the first time; the gallery then says so. `--wheel` also writes the
site as a wheel, which `flockscope docs` opens where it is installed.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from urllib.parse import unquote, urlsplit

from PIL import Image
from sphinx.cmd.build import main as run_sphinx

HERE = Path(__file__).parent
ROOT = HERE.parent
sys.path.insert(0, str(ROOT))
MOST_BYTES = 15_000_000
QUALITY, WIDEST = 75, 1000
"""Of WebP pictures: of 100, and pixels; a column of text has 800."""
PROJECT = """[project]
name = "flockscope-docs"
version = "{version}"
description = "The pages of flockscope, to read offline"
license = "MIT"
requires-python = ">=3.12"

[build-system]
requires = ["hatchling>=1.27"]
build-backend = "hatchling.build"

[tool.hatch.build.targets.wheel]
packages = ["flockscope_docs"]
"""


class Links(HTMLParser):
    """What a page points to, the anchors that it has, and its pictures without words."""

    def __init__(self, page: Path):
        super().__init__()
        self.targets: list[str] = []
        self.anchors: set[str] = set()
        self.wordless: list[str] = []
        self.feed(page.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take what a tag has of it."""
        values = dict(attrs)
        self.anchors |= {values[key] or "" for key in ("id", "name") if key in values}
        for key in ("href", "src", "data-run"):
            if values.get(key):
                self.targets.append(values[key] or "")
        if tag == "img" and "alt" not in values:
            self.wordless.append(values.get("src") or "?")


def faults(folder: Path) -> Iterator[str]:
    """What is wrong with a site, a line each."""
    pages = {
        page: Links(page) for page in sorted(folder.rglob("*.html"))
        if folder / "run" not in page.parents and "_static" not in page.parts
    }  # fmt: skip
    for page, links in pages.items():
        here = page.relative_to(folder)
        yield from (f"{here}: the picture {source} has no words" for source in links.wordless)
        for target in links.targets:
            parts = urlsplit(target)
            if parts.scheme or parts.netloc:
                continue
            path = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            if not path.exists():
                yield f"{here}: {target} leads nowhere"
            elif parts.fragment and path in pages and parts.fragment not in pages[path].anchors:
                yield f"{here}: {target}: there is no such heading"


def shrink(folder: Path) -> None:
    """Make WebP of the PNG pictures of a site and say so in its pages; leave out what no page asks
    for: source maps, and the loops of the gallery."""
    for unused in (*folder.rglob("*.map"), *(folder / "_static").glob("*-moves.webp")):
        unused.unlink()
    names = {}
    for picture in sorted((folder / "_images").glob("*.png")):
        small = picture.with_suffix(".webp")
        with Image.open(picture) as opened:
            opened.thumbnail((WIDEST, 10 * WIDEST))
            opened.save(small, quality=QUALITY, method=6)
        picture.unlink()
        names[picture.name] = small.name
    for page in folder.rglob("*.html"):
        text = page.read_text(encoding="utf-8")
        page.write_text(
            re.sub(r"_images/([^\"]+\.png)", lambda m: f"_images/{names.get(m[1], m[1])}", text),
            encoding="utf-8",
        )


def write_flocks(folder: Path) -> None:
    """Write the pages that run flocks: of every scene, lesson and model that a page can run."""
    from app.cli.take.page_gallery import write_gallery

    shutil.rmtree(folder, ignore_errors=True)
    for name, why in write_gallery(folder, overwrite=True, quiet=False)["refused"].items():
        print(f"no page of {name}: {why}", file=sys.stderr)


def packed_size(folder: Path) -> int:
    """Bytes of a folder as a wheel has it, which is a ZIP file."""
    with TemporaryFile() as file, zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in folder.rglob("*"):
            archive.write(path, path.relative_to(folder))
        return sum(entry.compress_size for entry in archive.infolist())


def write_wheel(site: Path, folder: Path, version: str) -> Path:
    """The wheel `flockscope-docs` with a site in it."""
    with TemporaryDirectory() as made:
        package = Path(made) / "flockscope_docs"
        shutil.copytree(site, package / "site")
        (package / "__init__.py").write_text('"""The pages of flockscope."""\n')
        (Path(made) / "pyproject.toml").write_text(PROJECT.format(version=version))
        command = ["uv", "build", "--quiet", "--wheel", "--out-dir", str(folder.resolve()), made]
        subprocess.run(command, check=True)
    return folder / f"flockscope_docs-{version}-py3-none-any.whl"


def main() -> int:
    """Build and check; the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "site", help="folder of the site")
    parser.add_argument("--no-flocks", action="store_true", help="without pages that run flocks")
    parser.add_argument("--wheel", type=Path, help="folder for a wheel with the site")
    given = parser.parse_args()
    out = given.out.resolve()
    if out.exists() and any(out.iterdir()) and not (out / "searchindex.js").exists():
        parser.error(f"--out {given.out} has files that are no site; choose an empty folder")
    built, flocks = HERE / "_build" / "site", HERE / "_build" / "run"
    shutil.rmtree(built, ignore_errors=True)
    tags = []
    if not given.no_flocks:
        tags = ["-t", "flocks"]
        write_flocks(flocks)
    doctrees = built.with_name("doctrees")
    if run_sphinx(
        ["-E", "-W", "--keep-going", "-q", "-d", str(doctrees), *tags, str(HERE), str(built)]
    ):
        return 1
    shrink(built)
    if not given.no_flocks:
        shutil.copytree(flocks, built / "run")
    shutil.rmtree(out, ignore_errors=True)
    shutil.copytree(built, out)
    found = list(faults(out))
    size = packed_size(out)
    if size > MOST_BYTES:
        found.append(
            f"the site has {size / 1e6:.1f} MB; at most {MOST_BYTES / 1e6:.0f} are allowed"
        )
    for fault in found:
        print(fault, file=sys.stderr)
    pages = len(list(out.rglob("*.html")))
    print(f"{out}: {pages} pages, {size / 1e6:.1f} MB packed")
    if given.wheel and not found:
        from importlib.metadata import version

        print(write_wheel(out, given.wheel, version("flockscope")))
    return bool(found)


if __name__ == "__main__":
    raise SystemExit(main())
