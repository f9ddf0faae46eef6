"""Crowds, by PedPy: density, flow through a line, speed by density, time headway and distance.

PedPy (https://github.com/PedestrianDynamics/PedPy, MIT) defines and computes all of it; here tracks
become its tables. It is imported when it is needed: that takes seconds.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from app.studies.charts.array_charts import draw_curve, draw_points
from app.studies.measure import COUNT
from app.tracks.measures.track_measure import (
    MeasureChart,
    MeasureInput,
    MeasureResult,
    Progress,
    TrackMeasure,
    describe_values,
    distribution_chart,
    frame_series,
)
from app.tracks.tracks import PIXELS, UNITS
from worlds.input_error import InputError, shorten
from worlds.plug_ins import demand

if TYPE_CHECKING:
    import pandas as pd

CUT_OFF = 1.0
"""m: a Voronoi cell reaches no further from its pedestrian (PedPy's `Cutoff`)."""
FLOW_SECONDS = 4.0
"""s: the intervals that flow is counted in."""


def geometry(option: str, text: str, kind: str) -> Any:
    """A shape of WKT. Raises InputError for anything but this kind of shape."""
    from shapely import from_wkt, is_valid
    from shapely.errors import ShapelyError

    try:
        shape = from_wkt(text)
    except (ShapelyError, ValueError, TypeError):
        raise InputError(f"{option} = {shorten(text)} is no WKT, as in {EXAMPLES[kind]}") from None
    if kind == "Polygon" and shape.geom_type == "GeometryCollection" and len(shape.geoms) == 1:
        shape = shape.geoms[0]
    if shape.geom_type != kind or shape.is_empty or not is_valid(shape):
        raise InputError(
            f"{option} = {shorten(text)} is no {kind} that is sound: as in {EXAMPLES[kind]}"
        )
    if kind == "LineString" and len(shape.coords) != 2:
        raise InputError(f"{option} = {shorten(text)} has more than two ends")
    return shape


EXAMPLES = {
    "Polygon": "POLYGON ((0 0, 4 0, 4 3, 0 3, 0 0))",
    "LineString": "LINESTRING (0 0, 1 0)",
}


def lacks_walkable(given: MeasureInput) -> str:
    """What is missing to measure a crowd."""
    if given.tracks.dim != 2:
        return "tracks in the plane are needed, these are in space"
    if given.tracks.unit == PIXELS:
        return "metres are needed, these are pixels: --scale"
    if not (given.options.walkable or given.tracks.boundary):
        return "where people can walk is needed: --walkable WKT"
    return ""


def lacks_area(given: MeasureInput) -> str:
    """What is missing to measure density."""
    missing = lacks_walkable(given)
    if missing or given.options.area:
        return missing
    walkable = geometry("--walkable", given.options.walkable or given.tracks.boundary, "Polygon")
    if abs(walkable.convex_hull.area - walkable.area) > 1e-9 * walkable.area:
        return "the walkable area is not convex, so a part of it must be chosen: --area WKT"
    return ""


def lacks_line(given: MeasureInput) -> str:
    """What is missing to count a flow."""
    return lacks_walkable(given) or (
        "" if given.options.line else "a line to cross is needed: --line WKT"
    )


class CrowdTables:
    """Tracks as PedPy has them: metres, frames numbered by time, those who are inside.

    Raises InputError.
    """

    def __init__(self, given: MeasureInput):
        demand("pedpy", "a measure of crowds", "tracks")
        import pandas as pd
        import pedpy
        import shapely

        self.given = given
        tracks = given.tracks.in_metres()
        text = given.options.walkable or tracks.boundary
        polygon = geometry("--walkable", text, "Polygon")
        self.walkable = pedpy.WalkableArea(polygon)
        self.area_shape = (
            geometry("--area", given.options.area, "Polygon") if given.options.area else polygon
        )
        number = np.rint((tracks.time - tracks.time[0]) / tracks.step).astype(np.int64)
        at, row = np.nonzero(tracks.seen)
        place = tracks.position[at, row]
        inside = np.asarray(shapely.intersects_xy(polygon, place[:, 0], place[:, 1]))
        self.outside = int((~inside).sum())
        if not inside.any():
            raise InputError(f"{tracks.name}: nobody is ever inside of the walkable area")
        speed = given.motion.speed[at, row] * UNITS[given.tracks.unit]
        self.rows: pd.DataFrame = pd.DataFrame(
            {
                "id": row[inside], "frame": number[at[inside]], "x": place[inside, 0],
                "y": place[inside, 1],
            }
        )  # fmt: skip
        self.speed = self.rows[["id", "frame"]].assign(speed=speed[inside])
        self.data = pedpy.TrajectoryData(self.rows, frame_rate=tracks.rate)
        self.number = number
        self.notes = (
            f"{self.outside} places outside of the walkable area are left out",
        ) if self.outside else ()  # fmt: skip

    @property
    def area(self) -> Any:
        """Where density is measured."""
        import pedpy

        try:
            return pedpy.MeasurementArea(self.area_shape)
        except pedpy.errors.GeometryError as error:
            raise InputError(f"--area is not allowed: {' '.join(str(error).split())}") from None

    @property
    def line(self) -> Any:
        """Where flow is counted."""
        import pedpy

        return pedpy.MeasurementLine(geometry("--line", self.given.options.line, "LineString"))

    def voronoi(self) -> pd.DataFrame:
        """The cell of each pedestrian in each frame, within CUT_OFF."""
        if not hasattr(self, "_voronoi"):
            import pedpy

            self._voronoi = pedpy.compute_individual_voronoi_polygons(
                traj_data=self.data,
                walkable_area=self.walkable,
                cut_off=pedpy.Cutoff(radius=CUT_OFF, quad_segments=3),
            )
        return self._voronoi

    def voronoi_density(self) -> tuple[np.ndarray, pd.DataFrame]:
        """Density by frame of the tracks, 1/m^2, and PedPy's table of who is in the area."""
        import pedpy

        density, cells = pedpy.compute_voronoi_density(
            individual_voronoi_data=self.voronoi(), measurement_area=self.area
        )
        return self.by_frame(density, "density"), cells

    def by_frame(self, table: pd.DataFrame, column: str) -> np.ndarray:
        """A column of one of PedPy's tables by frame as the tracks have them; NaN without."""
        return table.set_index("frame")[column].reindex(self.number).to_numpy(float)

    def count(self) -> np.ndarray:
        """How many are in the walkable area in each frame, int (T,)."""
        many = self.rows.groupby("frame").size()
        return many.reindex(self.number, fill_value=0).to_numpy(np.int64)


@lru_cache(maxsize=1)
def crowd_tables(given: MeasureInput) -> CrowdTables:
    """The tables of tracks, made once for all measures of a crowd."""
    return CrowdTables(given)


def density(given: MeasureInput, progress: Progress) -> MeasureResult:
    """People per area by frame: counted, and by Voronoi cells."""
    import pedpy

    tables = crowd_tables(given)
    counted = tables.by_frame(
        pedpy.compute_classic_density(traj_data=tables.data, measurement_area=tables.area),
        "density",
    )
    progress(0.1)
    voronoi, _ = tables.voronoi_density()
    progress(1.0)
    result = frame_series(given, "density", "1/m²", voronoi, tables.count(), COUNT)
    columns = {**result.tables[""], "density_counted": counted}
    numbers = {f"counted, {k}": v for k, v in describe_values(counted).items()}
    return MeasureResult(
        {**result.numbers, **numbers}, {"": columns}, result.charts,
        ("density by Voronoi cells, no larger than 1 m about a pedestrian; beside it how many are "
         "in the area, by its size", *tables.notes),
    )  # fmt: skip


def diagram(given: MeasureInput, progress: Progress) -> MeasureResult:
    """Mean speed in the area against density in it, frame by frame."""
    tables = crowd_tables(given)
    density_, cells = tables.voronoi_density()
    progress(0.8)
    cells = cells[cells.intersection.notna()]
    joined = cells.merge(tables.speed, on=["id", "frame"])
    joined = joined[np.isfinite(joined.speed)]
    from shapely import area

    joined = joined.assign(weight=area(joined.intersection.to_numpy()))
    joined = joined[joined.weight > 0.0]
    sums = (joined.speed * joined.weight).groupby(joined.frame).sum()
    weights = joined.weight.groupby(joined.frame).sum()
    speed = (sums / weights).reindex(tables.number).to_numpy(float)
    there = np.isfinite(speed) & np.isfinite(density_)
    progress(1.0)
    rho, v = density_[there], speed[there]
    apart = rho - rho.mean() if len(rho) else rho
    is_spread = len(rho) > 2 and float(apart @ apart) > 1e-12 * float(rho @ rho)
    slope = float(apart @ v) / float(apart @ apart) if is_spread else math.nan
    chart = MeasureChart("density (1/m²)", "speed (m/s)", lambda axes: draw_points(axes, rho, v))
    return MeasureResult(
        {"frames": int(there.sum()), "mean density (1/m²)": float(rho.mean()) if len(rho) else
         math.nan, "mean speed (m/s)": float(v.mean()) if len(v) else math.nan,
         "change of speed by density (m³/s)": slope},
        {"": {"frame": given.tracks.frame[there], "time": given.tracks.time[there],
              "density": rho, "speed": v, "flow": rho * v}},
        (chart,),
        ("speed is the mean over those in the area, by the part of it that is theirs; frames "
         "follow each other, so their points are not independent", *tables.notes),
    )  # fmt: skip


def flow(given: MeasureInput, progress: Progress) -> MeasureResult:
    """People across a line by time: how many so far, and how many a second."""
    import pedpy

    tables = crowd_tables(given)
    table, crossing = pedpy.compute_n_t(traj_data=tables.data, measurement_line=tables.line)
    progress(0.7)
    so_far = tables.by_frame(table, "cumulative_pedestrians")
    seconds = np.sort(crossing.frame.to_numpy()) / tables.data.frame_rate + given.tracks.time[0]
    span = float(np.ptp(seconds)) if len(seconds) > 1 else 0.0
    rate = (len(seconds) - 1) / span if span > 0.0 else math.nan
    rows = pedpy.compute_flow(
        nt=table, crossing_frames=crossing, individual_speed=tables.speed,
        delta_frame=max(1, round(FLOW_SECONDS * tables.data.frame_rate)),
        frame_rate=tables.data.frame_rate,
    ) if len(seconds) > 1 else None  # fmt: skip
    progress(1.0)
    time = given.tracks.time
    chart = MeasureChart(
        "time (s)", "people across the line", lambda axes: draw_curve_of_steps(axes, time, so_far)
    )
    result_tables: dict[str, dict[str, np.ndarray]] = {
        "": {"frame": given.tracks.frame, "time": time, "across": so_far}
    }
    if rows is not None and len(rows):
        result_tables["intervals"] = {
            "flow": rows.flow.to_numpy(float), "mean_speed": rows.mean_speed.to_numpy(float)
        }  # fmt: skip
    return MeasureResult(
        {"people across": len(seconds), "mean flow (1/s)": rate,
         "from the first to the last (s)": span},
        result_tables, (chart,),
        ("the first crossing of each individual counts, in either direction", *tables.notes),
    )  # fmt: skip


def draw_curve_of_steps(axes: Any, time: np.ndarray, values: np.ndarray) -> None:
    """Draw a count that only rises."""
    every = max(1, len(time) // 500)
    draw_curve(axes, time[::every], values[::every])


def headway(given: MeasureInput, progress: Progress) -> MeasureResult:
    """Time from one individual to the next across the line."""
    import pedpy

    tables = crowd_tables(given)
    _, crossing = pedpy.compute_n_t(traj_data=tables.data, measurement_line=tables.line)
    progress(1.0)
    apart = np.diff(np.sort(crossing.frame.to_numpy())) / tables.data.frame_rate
    step = 1.0 / tables.data.frame_rate
    bins = max(1, min(60, round(float(np.max(apart, initial=step)) / step)))
    table, chart = distribution_chart(apart, "time headway (s)", bins)
    return MeasureResult(
        describe_values(apart), {"": {"headway": apart}, "distribution": table}, (chart,),
        (f"headways are whole frames of {given.tracks.step:.3g} s", *tables.notes),
    )  # fmt: skip


def neighbour_distance(given: MeasureInput, progress: Progress) -> MeasureResult:
    """Distance between those whose Voronoi cells touch."""
    import pedpy

    tables = crowd_tables(given)
    cells = tables.voronoi()
    progress(0.6)
    pairs = pedpy.compute_neighbors(cells, as_list=False)
    distance = pedpy.compute_neighbor_distance(traj_data=tables.data, neighborhood=pairs)
    progress(1.0)
    apart = distance.distance.to_numpy(float)
    table, chart = distribution_chart(apart, "distance between neighbours (m)")
    return MeasureResult(
        describe_values(apart) | {"pairs and frames": len(apart) // 2}, {"": table}, (chart,),
        ("neighbours are those whose Voronoi cells touch", *tables.notes),
    )  # fmt: skip


def voronoi_cost(frames: int, n: int) -> float:
    """Seconds for Voronoi cells, and for PedPy to be imported."""
    return 8.0 + 4e-3 * frames + 3e-4 * frames * n


PEDPY = "PedPy"
MEASURES = (
    TrackMeasure(
        "crowd-density", "People per area", PEDPY, density, voronoi_cost, lacks_area, "1/m²"
    ),
    TrackMeasure("fundamental-diagram", "Speed by density", PEDPY, diagram, voronoi_cost,
                 lacks_area),
    TrackMeasure("flow", "People across a line", PEDPY, flow, lambda frames, n: 8.0 + 1e-5 * frames
                 * n, lacks_line),
    TrackMeasure("time-headway", "Time from one to the next across a line", PEDPY, headway,
                 lambda frames, n: 8.0 + 1e-5 * frames * n, lacks_line),
    TrackMeasure("neighbour-distance", "Distance between neighbours by Voronoi cells", PEDPY,
                 neighbour_distance, voronoi_cost, lacks_walkable),
)  # fmt: skip
