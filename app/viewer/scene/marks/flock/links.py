"""Lines between neighbours."""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.drawn_frame import DIMMED, Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments
from app.viewer.scene.draw.seam import split_at_seams
from app.viewer.scene.shown import palette, tone

MOST = 12_000


class Links:
    """Thin lines; of very many pairs a fair and steady sample is drawn."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._lines = add_lines(scene, f"{root}/flock/links", thickness=1.0)

    def draw(self, picture: Picture) -> Changes:
        pairs = picture.frame.links
        if not picture.look.links or pairs is None or not len(pairs):
            return [(self._lines, "visible", False)]
        pairs = sample(pairs[np.all(pairs < len(picture.at), axis=1)], MOST)
        at = picture.at
        points = split_at_seams(at[pairs[:, 0]], at[pairs[:, 1]], picture.stage.period)
        faint = 0.55 if picture.frame.inspected is not None else 0.25 * (len(pairs) > 2_000)
        colour = picture.mixed(palette.LINK, min(faint, DIMMED))
        return segments(self._lines, points, tone.single(colour))


def sample(pairs: np.ndarray, most: int) -> np.ndarray:
    """About `most` of the pairs (M, 2), chosen by the pair itself: a kept one stays, no flicker."""
    if len(pairs) <= most:
        return pairs
    low, high = np.sort(pairs.astype(np.uint64), axis=1).T
    mixed = (low * np.uint64(0x9E3779B97F4A7C15)) ^ (high * np.uint64(0xC2B2AE3D27D4EB4F))
    mixed = (mixed ^ (mixed >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)
    return pairs[(mixed >> np.uint64(44)) < np.uint64(2**20 * most // len(pairs))]
