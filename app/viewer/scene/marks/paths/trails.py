"""Where the agents have been."""

from __future__ import annotations

from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.marks.paths.streaks import Streaks, chosen
from app.viewer.scene.shown.drawing_style import LINE

MOST_AGENTS = 800


class Trails(Streaks):
    """A line behind each agent, or of very many agents behind some."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        super().__init__(scene, f"{root}/flock/trails")

    def draw(self, picture: Picture) -> Changes:
        if picture.look.trails != LINE or picture.look.trail_length < 1:
            return self.hide()
        rows = chosen(picture.frame.informed, MOST_AGENTS)
        return self.follow(picture, picture.frame.ids[rows], picture.at[rows], picture.colour[rows])
