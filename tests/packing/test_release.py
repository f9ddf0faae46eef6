"""The release script checks the version, and its checksums are those of the files."""

from __future__ import annotations

import hashlib
import runpy
from pathlib import Path

import pytest

SCRIPT = Path(__file__).parents[2] / "packing" / "release.py"


@pytest.fixture
def script():
    """What the script defines."""
    return runpy.run_path(str(SCRIPT))


def test_the_version_is_the_same_everywhere(script):
    assert script["check_version"]().startswith("version ")


def test_versions_that_differ_are_named(script, tmp_path):
    check = script["check_version"]
    for name, text in {
        "pyproject.toml": 'version = "0.2.0"\n',
        "CITATION.cff": "version: 0.1.0\n",
        "CHANGELOG.md": "# Changes\n\n## 0.2.0\n",
    }.items():
        (tmp_path / name).write_text(text)
    check.__globals__["ROOT"] = tmp_path
    with pytest.raises(SystemExit, match=r"'CITATION.cff': '0.1.0'"):
        check()


def test_every_file_but_those_of_the_site_has_its_checksum(script, tmp_path):
    (tmp_path / "flockscope.whl").write_bytes(b"wheel")
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "index.html").write_bytes(b"page")
    for _ in range(2):  # the second time its own file is there
        sums = script["write_sums"](tmp_path)
    assert sums.read_text() == f"{hashlib.sha256(b'wheel').hexdigest()}  flockscope.whl\n"
