"""The capture area: a rectangle on the floor, with a fence some way inside it."""

from __future__ import annotations

from pydantic import Field, model_validator

from app.strict_table import StrictTable


class TrackingArea(StrictTable):
    """Where the cars are tracked, metres in the frame of the tracking."""

    low: tuple[float, float]
    high: tuple[float, float]
    fence: float = Field(default=0.5, ge=0.0)
    """How far inside the area the cars are stopped, m."""

    @model_validator(mode="after")
    def _reaches_beyond_its_fence(self) -> TrackingArea:
        for axis in range(2):
            if self.high[axis] - self.low[axis] <= 2.0 * self.fence:
                raise ValueError(
                    f"there is no room within a fence of {self.fence:g} m between "
                    f"{'xy'[axis]} = {self.low[axis]:g} and {self.high[axis]:g}"
                )
        return self

    def inside(self, x: float, y: float) -> float:
        """How far (m) a point is inside the fence; negative beyond it.

        >>> TrackingArea(low=(-2, -2), high=(2, 2)).inside(1.25, 0)
        0.25
        """
        return min(
            x - self.low[0] - self.fence,
            self.high[0] - self.fence - x,
            y - self.low[1] - self.fence,
            self.high[1] - self.fence - y,
        )

    def clamp(self, x: float, y: float) -> tuple[float, float]:
        """The nearest point on or within the fence."""
        low = [edge + self.fence for edge in self.low]
        high = [edge - self.fence for edge in self.high]
        return min(max(x, low[0]), high[0]), min(max(y, low[1]), high[1])
