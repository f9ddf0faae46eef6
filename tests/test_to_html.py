"""`Flock.to_html`: a flock as a page, from Python."""

from __future__ import annotations

import pytest

from app.viewer.lab.flock_page import drawn_obstacles
from flockscope import Flock, InputError


def test_a_flock_is_written_as_it_stands(tmp_path):
    flock = Flock("vem", agents=10, rng=1)
    flock.run(3)
    flock.to_html(tmp_path / "flock.html", live=True, title="Mine")
    page = (tmp_path / "flock.html").read_text("utf-8")
    assert "<h1>Mine</h1>" in page
    assert '"tick":3,' in page
    assert flock.tick == 3


def test_what_cannot_be_written_is_refused(tmp_path):
    flock = Flock("vem", agents=10, rng=1)
    with pytest.raises(InputError, match="live = False is not allowed"):
        flock.to_html(tmp_path / "flock.html", live=False)
    with pytest.raises(InputError, match=r"ends in \.html"):
        flock.to_html(tmp_path / "flock.txt")
    (tmp_path / "flock.html").write_text("mine")
    with pytest.raises(InputError, match="exists already"):
        flock.to_html(tmp_path / "flock.html")
    assert (tmp_path / "flock.html").read_text() == "mine"


@pytest.mark.parametrize(
    ("model", "lines"), [("hwvem-nav", None), ("olfati-saber", 2), ("squashing", 72), ("vem", 0)]
)
def test_a_missions_path_or_goal_is_drawn(model, lines):
    world = Flock(model, agents=3, rng=1).world
    _, ends = drawn_obstacles(world)
    if lines is None:
        lines = len(world.mission.path.waypoints) - 1
        assert [*world.mission.path.waypoints[0], 0.0] == ends[0]
    assert len(ends) == 2 * lines
