"""Two processes test whole files, and all that looks into a browser is one file to them.

Two browsers at once, without a GPU, would keep each other waiting.
"""

from __future__ import annotations

import pytest
from hypothesis import settings
from xdist.scheduler import LoadFileScheduling

BROWSER = "tests/browser"

settings.register_profile("any machine", deadline=None)
settings.load_profile("any machine")


class ByFile(LoadFileScheduling):
    """Which tests stay together."""

    def _split_scope(self, nodeid):
        file = super()._split_scope(nodeid)
        return BROWSER if file.startswith(BROWSER) else file


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Hand out tests so."""
    return ByFile(config, log)
