"""The outlines of what is solid: obstacles united, with their images across wrapping edges."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
import shapely

from worlds.input_error import InputError
from worlds.shape import SEGMENTS
from worlds.world import World

# Outlines of straight edges and exact arcs.
#
# Obstacles are united as polygons, in which a circle has `SEGMENTS` corners. Here the edges that
# come from a circle become arcs of it again, and where an arc meets something else is the place at
# which the circle itself does so: an outline is the same whichever way its polygons are turned.

CORNER = np.cos(np.radians(19.5))
"""Cosine of the least turn at a corner; where an outline turns less it is part of a curve. No
regular polygon turns by just that, so that rounding decides nowhere."""
ON = 1e-9
"""How far from a circle's polygon a place on it may be, for each unit of length."""
MOVED = 4.0 * 2.0 * math.sin(math.pi / SEGMENTS)
"""How far a corner may be from that of the polygons, for each unit of a circle's radius."""
SAGITTA = 1.0 - math.cos(math.pi / SEGMENTS)
"""How deep a chord of `SEGMENTS` in a full turn lies under its arc, for each unit of radius."""
TURN = 2.0 * math.pi
MOST_SWEEP = 0.25 * math.pi
"""The most that an arc turns by where distances to it are asked, rad: less than half a turn, and
near what is listed with it."""
CHORDS = SEGMENTS // 8
"""Of such an arc where it is a line."""


class OutlineRing(NamedTuple):
    """A closed ring of n edges, each to where the next begins, the solid on the left of all."""

    start: np.ndarray
    """Where each begins, (n, 2)."""
    centre: np.ndarray
    """Of the circle that it is an arc of, (n, 2); zeros where it is straight."""
    radius: np.ndarray
    """Of the circle, (n,): negative where the solid is outside of it, 0 where it is straight."""
    sweep: np.ndarray
    """The angle that an arc turns by about its centre, > 0, rad, (n,); 0 where it is straight."""

    @property
    def end(self) -> np.ndarray:
        """Where each ends, (n, 2)."""
        return np.roll(self.start, -1, axis=0)

    @property
    def length(self) -> np.ndarray:
        """Of each edge, (n,)."""
        edge = self.end - self.start
        return np.where(
            self.radius != 0.0, np.abs(self.radius) * self.sweep, np.hypot(edge[:, 0], edge[:, 1])
        )

    @property
    def normals(self) -> tuple[np.ndarray, np.ndarray]:
        """Unit normals to the free side where each edge begins and where it ends, (n, 2) each."""
        edge = self.end - self.start
        straight = self.radius == 0.0
        length = np.where(straight, np.hypot(edge[:, 0], edge[:, 1]), 1.0)[:, None]
        normal = np.column_stack([edge[:, 1], -edge[:, 0]]) / length
        r = np.where(straight, 1.0, self.radius)[:, None]
        first, last = (self.start - self.centre) / r, (self.end - self.centre) / r
        straight = straight[:, None]
        return np.where(straight, normal, first), np.where(straight, normal, last)

    @property
    def corners(self) -> np.ndarray:
        """The edges that begin at a corner, ascending."""
        first, last = self.normals
        return np.flatnonzero((first * np.roll(last, 1, axis=0)).sum(axis=1) < CORNER)

    def at(self, along: np.ndarray) -> np.ndarray:
        """The places so far along the ring from its first place, (m,) lengths -> (m, 2)."""
        length = self.length
        starts = np.concatenate([[0.0], np.cumsum(length)])
        along = along % starts[-1]
        k = np.clip(np.searchsorted(starts, along, side="right") - 1, 0, len(length) - 1)
        share = (along - starts[k]) / length[k]
        straight = self.start[k] + share[:, None] * (self.end - self.start)[k]
        angle = np.copysign(share * self.sweep[k], self.radius[k])
        c, s = np.cos(angle), np.sin(angle)
        x, y = (self.start - self.centre)[k].T
        on_arcs = self.centre[k] + np.column_stack([c * x - s * y, s * x + c * y])
        return np.where((self.radius[k] == 0.0)[:, None], straight, on_arcs)

    def divided(self, most: float) -> OutlineRing:
        """The same ring with no arc that turns by more than `most`, rad."""
        parts = np.maximum(1, np.ceil(self.sweep / most * (1.0 - 1e-9))).astype(int)
        if (parts == 1).all():
            return self
        k = np.repeat(np.arange(len(parts)), parts)
        part = np.arange(len(k)) - np.repeat(np.cumsum(parts) - parts, parts)
        starts = np.concatenate([[0.0], np.cumsum(self.length)])
        start = self.at(starts[k] + self.length[k] * part / parts[k])
        start[part == 0] = self.start
        return OutlineRing(start, self.centre[k], self.radius[k], (self.sweep / parts)[k])


class Solid(NamedTuple):
    """One connected outline: its outer ring first, then its holes."""

    rings: list[OutlineRing]
    polygon: shapely.Polygon
    """The same with chords in the place of arcs, `SEGMENTS` or more in a full turn."""

    @property
    def slack(self) -> float:
        """How far its polygon may be from its outline, length."""
        return SAGITTA * max(float(np.abs(ring.radius).max()) for ring in self.rings)


def solids_in(outline: shapely.Geometry, circles: np.ndarray) -> list[Solid]:
    """The connected parts of a united outline, with arcs of those circles (C, 3) that it is of."""
    parts = shapely.get_parts(shapely.orient_polygons(outline))
    x, y, r = circles.T
    tree = shapely.STRtree(shapely.box(x - r, y - r, x + r, y + r))
    part, near = tree.query(parts)
    circle_rows = np.split(near, np.searchsorted(part, np.arange(1, len(parts))))
    return [
        solid(polygon, circles[np.sort(k)]) for polygon, k in zip(parts, circle_rows, strict=True)
    ]


def solid(polygon: shapely.Polygon, circles: np.ndarray) -> Solid:
    """A polygon, its outer ring counterclockwise, with arcs where its edges are of circles (C, 3).

    Where arcs would cross what they meet, as a corner may that is nearer to a circle than its
    polygon is, the polygon is kept as it is.
    """
    straight = [straight_ring(shapely.get_coordinates(ring)[:-1]) for ring in rings_of(polygon)]
    rings = [ring_with_arcs(ring.start, circles) for ring in straight] if len(circles) else straight
    if all(len(ring.start) == 1 or not ring.radius.any() for ring in rings):
        return Solid(rings, polygon)
    chords = [ring.divided(TURN / SEGMENTS).start for ring in rings]
    chord_polygon = shapely.Polygon(chords[0], chords[1:])
    return Solid(rings, chord_polygon) if chord_polygon.is_valid else Solid(straight, polygon)


def rings_of(polygon: shapely.Polygon) -> list[shapely.LinearRing]:
    """The outer ring and the holes."""
    return [polygon.exterior, *polygon.interiors]


def straight_ring(place: np.ndarray) -> OutlineRing:
    """The ring of straight edges through places (n, 2)."""
    n = len(place)
    return OutlineRing(place, np.zeros((n, 2)), np.zeros(n), np.zeros(n))


def ring_with_arcs(place: np.ndarray, circles: np.ndarray) -> OutlineRing:
    """The ring through places (n, 2) with arcs where it goes along polygons of circles (C, 3)."""
    circle_of_edge = sources(place, circles)
    if (circle_of_edge < 0).all():
        return straight_ring(place)
    new = (circle_of_edge < 0) | (circle_of_edge != np.roll(circle_of_edge, 1))
    if not new.any():  # one circle all round
        cx, cy, r = circles[circle_of_edge[0]]
        sign = np.sign(cross(place[0] - (cx, cy), place[1] - (cx, cy)))
        return OutlineRing(place[:1], np.array([[cx, cy]]), np.array([sign * r]), np.array([TURN]))
    first = np.flatnonzero(new)
    circle_of_edge = circle_of_edge[first]
    arcs = circle_of_edge >= 0
    centre = np.where(arcs[:, None], circles[circle_of_edge, :2], 0.0)
    follows = place[(first + 1) % len(place)]
    sign = np.sign(cross(place[first] - centre, follows - centre))
    radius = np.where(arcs, sign * circles[circle_of_edge, 2], 0.0)
    was = place[first]
    start = was.copy()
    for k in np.flatnonzero(arcs | np.roll(arcs, 1)).tolist():
        meeting_place = edge_meeting(was, centre, radius, k)
        if meeting_place is None:
            return straight_ring(place)
        start[k] = meeting_place
    next_start = np.roll(start, -1, axis=0)
    sweep = np.where(arcs, swept_angles(centre, radius, start, next_start), 0.0)
    turn_before = np.where(arcs, swept_angles(centre, radius, was, np.roll(was, -1, axis=0)), 0.0)
    back = ((next_start - start) * (np.roll(was, -1, axis=0) - was)).sum(axis=1) <= 0.0
    if (np.abs(sweep - turn_before) > 2.0 * MOVED).any() or (~arcs & back).any():
        return straight_ring(place)
    return OutlineRing(start, centre, radius, sweep)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The z component of the product of vectors (..., 2), > 0 if b is to the left of a."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def swept_angles(
    centre: np.ndarray, radius: np.ndarray, a: np.ndarray, b: np.ndarray
) -> np.ndarray:
    """The angles in [0, 2 pi) from a to b about centres, clockwise where the radius is < 0."""
    a, b = a - centre, b - centre
    angle = np.arctan2(cross(a, b), (a * b).sum(axis=1))
    return np.where(radius < 0.0, -angle, angle) % TURN


def sources(place: np.ndarray, circles: np.ndarray) -> np.ndarray:
    """For each edge of a ring (n, 2) the circle (C, 3) along whose polygon it goes, or -1, (n,)."""
    ends = np.roll(place, -1, axis=0)
    middle = 0.5 * (place + ends)
    circle_of_edge = np.full(len(place), -1)
    for k, (x, y, r) in enumerate(circles):
        near = ON * (1.0 + abs(x) + abs(y) + r)
        candidates = np.flatnonzero(is_on_polygon(middle, x, y, r, near))
        is_on_circle = is_on_polygon(place[candidates], x, y, r, near) & is_on_polygon(
            ends[candidates], x, y, r, near
        )
        circle_of_edge[candidates[is_on_circle]] = k
    return circle_of_edge


def is_on_polygon(place: np.ndarray, x: float, y: float, r: float, near: float) -> np.ndarray:
    """Whether places (n, 2) lie on the polygon that stands for a circle, as `circle` makes it."""
    w = place - (x, y)
    away = np.hypot(w[:, 0], w[:, 1])
    step = TURN / SEGMENTS
    is_on = np.abs(away - r) <= SAGITTA * r + near
    angle = np.arctan2(w[is_on, 1], w[is_on, 0]) % step - 0.5 * step
    is_on[is_on] = np.abs(away[is_on] * np.cos(angle) - r * math.cos(0.5 * step)) <= near
    return is_on


def edge_meeting(
    place: np.ndarray, centre: np.ndarray, radius: np.ndarray, k: int
) -> np.ndarray | None:
    """Where edge k - 1 of a ring and edge k meet, nearest to its place k; None if they do not."""
    at = place[k]
    if radius[k] == 0.0:
        edge, round_ = place[(k + 1) % len(place)] - at, k - 1
    else:
        edge, round_ = at - place[k - 1], k
    if radius[k] != 0.0 and radius[k - 1] != 0.0:
        place_found = meeting_of_circles(
            at, centre[k - 1], abs(radius[k - 1]), centre[k], abs(radius[k])
        )
    else:
        place_found = line_meets(at, edge, centre[round_], abs(radius[round_]))
    if place_found is None or math.dist(place_found, at) > MOVED * abs(radius[round_]):
        return None
    return place_found


def line_meets(at: np.ndarray, edge: np.ndarray, centre: np.ndarray, r: float) -> np.ndarray | None:
    """Where the line through a place meets a circle, nearest to the place."""
    u = edge / math.hypot(*edge)
    w = at - centre
    b = float(u @ w)
    out = math.hypot(*w)
    c = (out - r) * (out + r)
    root = b * b - c
    if root < 0.0:
        return None
    divisor = b + math.copysign(math.sqrt(root), b)
    return at - c / divisor * u if divisor != 0.0 else at


def meeting_of_circles(
    at: np.ndarray, centre_a: np.ndarray, r: float, centre_b: np.ndarray, s: float
) -> np.ndarray | None:
    """Where two circles meet, nearest to a place."""
    d = math.dist(centre_a, centre_b)
    if d == 0.0:
        return None
    u = (centre_b - centre_a) / d
    a = 0.5 * (d + (r - s) * (r + s) / d)
    h2 = (r - a) * (r + a)
    if h2 < 0.0:
        return None
    h = math.copysign(math.sqrt(h2), float(cross(u, at - centre_a)))
    return centre_a + a * u + h * np.array([-u[1], u[0]])


def edge_rows(ring: OutlineRing) -> np.ndarray:
    """The edges of a ring as the surroundings have them, (n, 11): see `Surroundings.edge`."""
    start, end = ring.start, ring.end
    edge = end - start
    length = np.hypot(*edge.T)[:, None]
    along = edge / length
    normal = np.column_stack([along[:, 1], -along[:, 0]])
    return np.hstack([start, end, edge / length**2, normal, ring.centre, ring.radius[:, None]])


def corner_rows(ring: OutlineRing) -> np.ndarray:
    """Where the edges of a ring begin: unit normal, and 1 if it is smooth there, (n, 3)."""
    first, last = ring.normals
    previous = np.roll(last, 1, axis=0)
    smooth = (first * previous).sum(axis=1) >= CORNER
    # Where the outline turns right back there is no sum of normals: the way out is straight on.
    total = first + previous
    size = np.hypot(*total.T)[:, None]
    along = np.column_stack([-first[:, 1], first[:, 0]])
    total = np.where(size > 1e-9, total / np.maximum(size, 1e-9), -along)
    return np.column_stack([total, smooth])


def distance_to_edge(
    edge: np.ndarray, place: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """From each place (M, 2) to the edge in the same row (M, 11), of which no arc turns by pi.

    Returns the distance, where the nearest place of the edge is (its share of the edge, in [0, 1])
    and the side of the place: 1 if it is free, -1 if it is solid, 0 if an end is nearest; (M,).
    """
    a, b = edge[:, :2], edge[:, 2:4]
    w = place - a
    t = (w * edge[:, 4:6]).sum(axis=1)
    d = (w * edge[:, 6:8]).sum(axis=1)
    r = edge[:, 10]
    arc = r != 0.0
    out = place[arc] - edge[arc, 8:10]
    sign = np.sign(r[arc])
    begin, end = a[arc] - edge[arc, 8:10], b[arc] - edge[arc, 8:10]
    past_begin, before_end = sign * cross(begin, out), sign * cross(out, end)
    angle = np.abs(np.arctan2(past_begin, (begin * out).sum(axis=1)))
    arc_angle = np.abs(np.arctan2(cross(begin, end), (begin * end).sum(axis=1)))
    is_on_arc = (past_begin > 0.0) & (before_end > 0.0)
    nearer = ((place[arc] - a[arc]) ** 2).sum(axis=1) <= ((place[arc] - b[arc]) ** 2).sum(axis=1)
    t[arc] = np.where(is_on_arc, angle / arc_angle, np.where(nearer, 0.0, 1.0))
    d[arc] = sign * (np.hypot(out[:, 0], out[:, 1]) - np.abs(r[arc]))
    inner = (t > 0.0) & (t < 1.0)
    to_end = np.where((t <= 0.0)[:, None], w, place - b)
    away = np.where(inner, np.abs(d), np.hypot(to_end[:, 0], to_end[:, 1]))
    return away, np.clip(t, 0.0, 1.0), np.where(inner, np.sign(d), 0.0)


def places_of(edge: np.ndarray, share: np.ndarray) -> np.ndarray:
    """The places at shares (M,) of edges (M, 11), (M, 2)."""
    a, b, centre = edge[:, :2], edge[:, 2:4], edge[:, 8:10]
    s = share[:, None]
    straight = (1.0 - s) * a + s * b
    w, v = a - centre, b - centre
    angle = share * np.arctan2(cross(w, v), (w * v).sum(axis=1))
    c, d = np.cos(angle), np.sin(angle)
    arc = centre + np.column_stack([c * w[:, 0] - d * w[:, 1], d * w[:, 0] + c * w[:, 1]])
    return np.where(edge[:, 10:] != 0.0, arc, straight)


def chord_lines(edge: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Runs low to high of consecutive edges as shapely lines, with chords for arcs, (C,)."""
    chords = np.where(edge[:, 10] != 0.0, CHORDS, 1)
    edges = high - low
    owner = np.repeat(np.arange(len(low)), edges)
    k = low[owner] + np.arange(len(owner)) - np.repeat(np.cumsum(edges) - edges, edges)
    steps = chords[k] + (k == high[owner] - 1)  # the last edge brings its end
    run = np.repeat(np.arange(len(k)), steps)
    step = np.arange(len(run)) - np.repeat(np.cumsum(steps) - steps, steps)
    place = places_of(edge[k[run]], step / chords[k[run]])
    return shapely.linestrings(place, indices=owner[run])


SLIT = 1e-9
"""Width (length) of a hole that is none."""
Ball = tuple[tuple[float, float, float], float]
"""Centre and radius of a sphere."""


def outlines(world: World, margin: float | None) -> dict[tuple[float, float], shapely.Geometry]:
    """The union of the obstacles' footprints for each span of heights (bottom, top).

    In two dimensions there is one span, (-inf, inf). Obstacles are seen across wrapping edges:
    images within `margin` (length) of the box are among them, none if it is None. Raises InputError
    for an outline that crosses itself.
    """
    parts: dict[tuple[float, float], list[shapely.Geometry]] = {}
    for obstacle in world.obstacles:
        for outline, bottom, top in obstacle.spans():
            if not outline.is_valid:
                reason = shapely.is_valid_reason(outline)
                raise InputError(f"obstacle {obstacle.label} of {world.name} is unsound: {reason}")
            low = 0.0 if bottom is None else bottom
            high = world.height if top is None else top
            if margin is not None and endless(world, low, high):
                low, high = -math.inf, math.inf
            for dx, dy, dz in shifts(world) if margin is not None else [(0.0, 0.0, 0.0)]:
                image = shapely.transform(outline, lambda at, by=(dx, dy): at + by)
                if not (dx or dy) or near_box(world, image.bounds, margin or 0.0):
                    span = (low + dz, high + dz) if world.dim == 3 else (-math.inf, math.inf)
                    parts.setdefault(span, []).append(image)
    return {span: remove_slits(shapely.union_all(images)) for span, images in parts.items()}


def remove_slits(outline: shapely.Geometry) -> shapely.Geometry:
    """An outline without holes that have no width, which rounding leaves where shapes meet."""
    parts = shapely.get_parts(outline)
    rings = [[ring for ring in part.interiors if is_wide(ring)] for part in parts]
    if sum(map(len, rings)) == sum(shapely.get_num_interior_rings(parts)):
        return outline
    cleaned = [
        shapely.Polygon(part.exterior, ring) for part, ring in zip(parts, rings, strict=True)
    ]
    return cleaned[0] if len(cleaned) == 1 else shapely.MultiPolygon(cleaned)


def is_wide(ring: shapely.LinearRing) -> bool:
    """Whether there is any room in a hole."""
    return shapely.Polygon(ring).area > SLIT * ring.length


def footprints(world: World) -> dict[tuple[float, float], shapely.Geometry]:
    """The outlines without images: what there is to draw."""
    return outlines(world, None)


def spheres(world: World, margin: float) -> list[Ball]:
    """The spheres of a world in three dimensions, with their images within `margin` of the box."""
    balls: list[Ball] = []
    if world.dim < 3:
        return balls
    for obstacle in world.obstacles:
        for (x, y, z), r in obstacle.spheres():
            for dx, dy, dz in shifts(world):
                u, v = x + dx, y + dy
                if not (dx or dy) or near_box(world, (u - r, v - r, u + r, v + r), margin):
                    balls.append(((u, v, z + dz), r))
    return balls


def circles(world: World, margin: float) -> np.ndarray:
    """Circles that outlines have arcs of: x, y, radius, (C, 3), with images as in `outlines`."""
    circle_sets = {
        (x + dx, y + dy, r)
        for obstacle in world.obstacles
        for (x, y), r in obstacle.circles()
        for dx, dy, _ in shifts(world)
        if not (dx or dy)
        or near_box(world, (x + dx - r, y + dy - r, x + dx + r, y + dy + r), margin)
    }
    return np.array(sorted(circle_sets)).reshape(-1, 3)


def solids(world: World, margin: float) -> list[tuple[tuple[float, float], list[Solid]]]:
    """The connected outlines of each span of heights, with exact arcs, as in `outlines`."""
    round_ = circles(world, margin)
    return [(span, solids_in(outline, round_)) for span, outline in outlines(world, margin).items()]


def endless(world: World, bottom: float, top: float) -> bool:
    """Whether a span of heights goes on for ever, because z wraps and it fills the box."""
    return world.dim == 3 and bool(world.wraps[2]) and top - bottom >= world.size[2]


def shifts(world: World) -> list[tuple[float, float, float]]:
    """The vectors from a place to its images, zero first; one back and forth per wrapping axis."""
    steps = [(0.0, -side, side) if wraps else (0.0,) for side, wraps in sides(world)]
    return [(x, y, z) for x, y, z in itertools.product(*steps)]


def sides(world: World) -> list[tuple[float, bool]]:
    """Length of each of three sides of the box, and whether it wraps."""
    axes = list(zip(world.size, world.wraps.tolist(), strict=True))
    return [*axes, (0.0, False)][:3]


def near_box(world: World, bounds: tuple[float, ...], margin: float) -> bool:
    """Whether bounds on the plan (x, y, x, y) come within a margin of the box."""
    low = np.array(world.low[:2]) - margin
    high = np.array(world.low[:2]) + world.size[:2] + margin
    return bool((np.array(bounds[:2]) <= high).all() and (np.array(bounds[2:]) >= low).all())
