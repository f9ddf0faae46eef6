"""Zones for bodies that stay solid among obstacles: the flocking only wishes, a guard decides.

Of the thesis (`agents.rules.zones`) are the three zones, sight in the zones of orientation and
attraction, and the field round obstacles (4.1). Added are:

- the guard (`agents.rules.terms.reserved_ball`): every agent reserves a ball in which it can
  circle, and only makes steps that leave it one. From the tick on from which all balls are apart,
  one of the first of a run, there are no crashes, whatever the wishes are: that is proved;
- repulsion all round, beside the other two zones and not in place of them, and from farther: at
  d_r = 2 the balls seldom meet, so that the guard seldom has to say no;
- attraction weighs less than orientation (w_a), so that the flock flies and does not mill;
- calls: agents that come near each other anyway tell where they are, and each is drawn to the
  middle of those it hears within d_c, seen or not. That keeps the flock one: sight alone loses
  those behind, and with a field of view of 90 degrees nearly everybody is behind somebody.

w_c = 0 is flocking by sight alone, and without `guard` the agents do what they wish.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from agents.engine.block import Decision
from agents.engine.noise import cos_sin
from agents.models.declare import Rule, parameter
from agents.models.tries import LessonCheck, LessonStep
from agents.rules.couzin import miss_direction
from agents.rules.terms.potential_field import bend_around_obstacles
from agents.rules.terms.reserved_ball import (
    OUT_X,
    OUT_Y,
    OUT_Z,
    RADIUS,
    SKIN,
    Direction,
    Escape,
    ReservedBall,
    ball_after_escape,
    escape,
    nearer,
    note_planes,
    overlap,
    own_ball,
    side_direction,
    spiral,
    turn_of,
)
from agents.rules.terms.zone_sums import ALL_ROUND, edge_of, zone_sums
from agents.rules.zones import REPELLED_ALL_ROUND, Zones
from worlds.compilation import compiled

# The step of an agent that is nearest to its wish and leaves it a way out.

HALF = math.sqrt(0.5)
COSINES = (1.0, HALF, HALF, 0.0, 0.0, -HALF, -HALF, -1.0)
SINES = (0.0, HALF, -HALF, 1.0, -1.0, HALF, -HALF, 0.0)
"""Of 0, 45, -45, 90, -90, 135, -135, 180 degrees: headings and sides of escapes that are tried."""
SIDES, PACES, HEADINGS = 8, 2, 9
"""How many sides to escape to, speeds and headings are tried."""


class GuardedStep(NamedTuple):
    """A step, and the ball that the agent reserves after it."""

    u: Direction
    """The new heading."""
    speed: float
    ball: ReservedBall


class StepOptions(NamedTuple):
    """What an agent chooses from: a heading, a speed, and the escape from there."""

    toward: Direction
    """The side to which it wants to turn."""
    angle: float
    """By how much it wants to turn, rad."""
    turn_limit: float
    """By how much it can, rad."""
    fast: float
    """The speed that it wants, as near as it can get to it in a tick."""
    slow: float
    """The speed if it slows down."""
    fast_escape: Escape
    slow_escape: Escape
    out: Direction
    """The side to which it would escape now."""
    flat: bool
    """Whether it lives in the plane z = 0."""


@compiled
def leaves_plane(flat, k):
    """Whether the k-th of eight directions leads out of the plane of a flat world."""
    return flat and 0 < k < SIDES - 1


@compiled
def about(u, n, k):
    """The unit vector n turned by the k-th angle about u, a unit vector at right angles to it."""
    c, s = COSINES[k], SINES[k]
    return Direction(
        c * n.x + s * (u.y * n.z - u.z * n.y),
        c * n.y + s * (u.z * n.x - u.x * n.z),
        c * n.z + s * (u.x * n.y - u.y * n.x),
    )


@compiled
def turn_by(u, n, angle):
    """The heading u turned by an angle (rad) towards n, at right angles to it."""
    c, s = cos_sin(angle)
    return Direction(c * u.x + s * n.x, c * u.y + s * n.y, c * u.z + s * n.z)


@compiled
def step_options(me, wish, pace, p):
    """What the agent can do that wishes for a heading `wish` and a speed `pace`."""
    u = Direction(me.ux, me.uy, me.uz)
    turn_limit = turn_of(p)
    along = min(1.0, max(-1.0, wish.x * u.x + wish.y * u.y + wish.z * u.z))
    fast = nearer(me.speed, min(max(pace, p.v_min), p.v_max), p)
    slow = nearer(me.speed, p.v_min, p)
    return StepOptions(
        side_direction(u, wish),
        min(math.acos(along), turn_limit),
        turn_limit,
        fast,
        slow,
        escape(fast, p),
        escape(slow, p),
        side_direction(u, Direction(me.signal[OUT_X], me.signal[OUT_Y], me.signal[OUT_Z])),
        (me.z == 0.0) & (me.uz == 0.0),
    )


@compiled
def candidate_heading(me, options, k):
    """The k-th heading: the wanted one, straight on, then full turns to seven other sides."""
    u = Direction(me.ux, me.uy, me.uz)
    if k == 0:
        return turn_by(u, options.toward, options.angle)
    if k == 1:
        return u
    return turn_by(u, about(u, options.toward, k - 1), options.turn_limit)


@compiled
def escape_step(me, options, own):
    """The last resort, to go on with the escape: the ball stays."""
    return GuardedStep(
        turn_by(Direction(me.ux, me.uy, me.uz), options.out, options.turn_limit), options.slow, own
    )


@compiled
def ball_distance(speed, escape_path, p):
    """How far from an agent the ball reaches that it reserves after a step, at most; length."""
    return (
        speed * p.tau + math.sqrt(escape_path.along**2 + escape_path.across**2) + escape_path.radius
    )


@compiled
def farthest_ball(me, options, own, p):
    """How far beyond the ball `own` any ball can reach that is tried, at most; length."""
    to = math.sqrt((own.x - me.x) ** 2 + (own.y - me.y) ** 2 + (own.z - me.z) ** 2)
    reach = max(
        ball_distance(options.fast, options.fast_escape, p),
        ball_distance(options.slow, options.slow_escape, p),
    )
    return max(to + reach - own.radius, 0.0)


@compiled
def choose_safe_step(me, near, surroundings, wish, pace, p):
    """The first safe step for an agent that wishes a heading (unit vector) and a speed.

    Those nearest to the wish, and to the present escape, come first: for each heading the wanted
    speed before slowing down, and for each speed the escapes to the sides near the present one
    before the others; at last the present escape. If none is safe, which happens only while
    reserved balls overlap as a run starts, the least unsafe. Without the guard (p.guard) the step
    that is wished, safe or not.
    """
    options = step_options(me, wish, pace, p)
    own = own_ball(me)
    planes = note_planes(me, near, own, farthest_ball(me, options, own, p), p)
    best = last = escape_step(me, options, own)
    least_overlap = math.inf
    for heading in range(HEADINGS):
        if leaves_plane(options.flat, heading - 1):
            continue
        u = candidate_heading(me, options, heading)
        side = side_direction(u, options.out)
        for slows in range(PACES):
            speed, escape_path = (
                (options.slow, options.slow_escape)
                if slows
                else (options.fast, options.fast_escape)
            )
            d = speed * p.tau
            at = Direction(me.x + d * u.x, me.y + d * u.y, me.z + d * u.z)
            for k in range(SIDES):
                if leaves_plane(options.flat, k):
                    continue
                ball = ball_after_escape(at, u, about(u, side, k), escape_path)
                over = overlap(near, planes, surroundings, own, ball, p)
                if over == 0.0 or p.guard == 0.0:
                    return GuardedStep(u, speed, ball)
                if over < least_overlap:
                    least_overlap, best = over, GuardedStep(u, speed, ball)
    return last if overlap(near, planes, surroundings, own, own, p) < least_overlap else best


WISH, BALL = 0, 3
"""Where in its memory an agent keeps the velocity it has chosen, and what it will tell next."""
STOPPED = 1e-9
"""Speed that a body is asked for to stop, length/s: a wish of no length means cruise."""
SHARES = 8.0
"""So many radii of a reserved ball two agents may be apart whose next ones could meet."""


class GuardedZones(Zones):
    """Parameters of the guarded zones: the thesis's, the weight of attraction, and the calls."""

    d_r: float = parameter(
        2.0,
        "Outer radius of the zone of repulsion, all round",
        words="Zone of repulsion",
        symbol="d_r",
        unit="length",
        low=0.05,
        high=30.0,
        step=0.05,
        source="ours: reserved balls with bodies need 1.34 already; 1.34 in the thesis",
    )
    alpha: float = parameter(
        270.0,
        "Field of view: agents outside of this full angle about the heading are not seen",
        words="Field of view",
        symbol="\\alpha",
        unit="deg",
        low=0.0,
        high=360.0,
        step=5.0,
        source="ours: a bird sees about as far round; 90 in the thesis, table 5.1",
    )
    w_a: float = parameter(
        0.1,
        "Weight of attraction to an agent seen, beside orientation by one",
        words="Weight of attraction",
        symbol="w_a",
        low=0.0,
        high=5.0,
        proposed=(0.0, 1.0),
        step=0.05,
        source="ours; 1 in the thesis",
    )
    w_c: float = parameter(
        0.5,
        "Weight of the calls: of the way to the middle of those that are heard; 0 for sight alone",
        words="Weight of the calls",
        symbol="w_c",
        low=0.0,
        high=5.0,
        step=0.1,
        source="ours",
    )
    d_c: float = parameter(
        10.0,
        "Distance within which calls are heard, all round",
        words="Range of the calls",
        symbol="d_c",
        unit="length",
        low=0.0,
        high=30.0,
        step=0.5,
        source="ours",
    )

    guard: bool = parameter(
        True,
        "Whether only steps are made that leave room to circle; off, agents do what they wish",
        words="Guard",
        symbol="g",
        source="ours",
    )

    @property
    def range(self) -> float:
        """The largest distance at which agents notice each other, length.

        All those are noticed whose reserved balls could meet after the next tick.
        """
        body = getattr(self, "body", 0.0) + 2.0 * SKIN
        step = getattr(self, "v_max", 0.0) * getattr(self, "tau", 0.0)
        return max(
            self.d_r,
            self.d_o,
            self.d_a,
            self.d_c,
            SHARES * largest_ball_radius(self) + 2 * step + body,
        )

    @property
    def sight(self) -> float:
        """The largest distance at which obstacles are noticed, length."""
        return max(self.Q, largest_ball_radius(self) + SKIN) + 0.5 * getattr(self, "body", 0.0)


plain_spiral, plain_turn = spiral.py_func, turn_of.py_func
"""As Python calls them."""


def largest_ball_radius(p: Any) -> float:
    """The radius of an agent's largest reserved ball, that at its largest speed; length."""
    if not hasattr(p, "v_max"):
        return 0.0
    return plain_spiral(p.v_max, p.v_min, p.a_max * p.tau, plain_turn(p), p.tau).radius


@compiled
def mean_direction(me, near, p):
    """The mean of the unit vectors to all within d_c, (x, y, z); shorter within a flock."""
    x = y = z = n = 0.0
    for j in range(near.n):
        dx = near.x[j] - me.x
        dy = near.y[j] - me.y
        dz = near.z[j] - me.z
        d2 = dx * dx + dy * dy + dz * dz
        is_heard = 1.0 if (d2 > 0.0) & (d2 <= p.d_c * p.d_c) else 0.0
        share = is_heard / math.sqrt(d2 if d2 > 0.0 else 1.0)
        x += share * dx
        y += share * dy
        z += share * dz
        n += is_heard
    n = max(n, 1.0)
    return x / n, y / n, z / n


@compiled
def wished_velocity(me, near, surroundings, p):
    """The velocity that flocking asks for, of length v0."""
    s = zone_sums(me, near, p.d_r, p.d_o, p.d_a, ALL_ROUND, edge_of(p.alpha))
    fx, fy, fz = s.ox + p.w_a * s.ax, s.oy + p.w_a * s.ay, s.oz + p.w_a * s.az
    length = math.sqrt(fx * fx + fy * fy + fz * fz)
    share = 1.0 / length if length > 1e-12 else 0.0
    cx, cy, cz = mean_direction(me, near, p)
    x = s.rx + share * fx + p.w_c * cx
    y = s.ry + share * fy + p.w_c * cy
    z = s.rz + share * fz + p.w_c * cz
    to = miss_direction(me, x, y, z, p.sigma)
    return bend_around_obstacles(me, to.x, to.y, to.z, surroundings, p)


@compiled
def perceive(me, near, surroundings, p):
    """Choose a step by the wish and by the guard; remember it and the ball reserved after it."""
    x, y, z = wished_velocity(me, near, surroundings, p)
    speed = math.sqrt(x * x + y * y + z * z)
    wish = Direction(me.ux, me.uy, me.uz)
    if speed > 0.0:
        wish = Direction(x / speed, y / speed, z / speed)
    step = choose_safe_step(me, near, surroundings, wish, speed, p)
    wanted_speed = max(step.speed, STOPPED)
    me.memory[WISH] = wanted_speed * step.u.x
    me.memory[WISH + 1] = wanted_speed * step.u.y
    me.memory[WISH + 2] = wanted_speed * step.u.z
    d = step.speed * p.tau
    me.memory[BALL + OUT_X] = step.ball.x - (me.x + d * step.u.x)
    me.memory[BALL + OUT_Y] = step.ball.y - (me.y + d * step.u.y)
    me.memory[BALL + OUT_Z] = step.ball.z - (me.z + d * step.u.z)
    me.memory[BALL + RADIUS] = step.ball.radius


@compiled
def decide(me, near, surroundings, p):
    """The velocity of the step that was chosen."""
    return Decision(me.memory[WISH], me.memory[WISH + 1], me.memory[WISH + 2])


@compiled
def show(me, p, out):
    """An agent that has reserved nothing yet would escape to its left."""
    if out[RADIUS] == math.inf:
        u = Direction(me.ux, me.uy, me.uz)
        first = ball_after_escape(
            Direction(0.0, 0.0, 0.0), u, side_direction(u, u), escape(me.speed, p)
        )
        out[OUT_X], out[OUT_Y], out[OUT_Z] = first.x, first.y, first.z
        out[RADIUS] = first.radius


@compiled
def remember(me, near, p, out):
    """The signals that others receive: the ball reserved after the step."""
    for k in range(RADIUS + 1):
        out[k] = me.memory[BALL + k]


@compiled
def weigh(me, near, p, out):
    """1 for those in the zones of repulsion and orientation, w_a for those in that of attraction.

    Those that are heard weigh w_c more, divided among them.
    """
    edge = edge_of(p.alpha)
    heard_count = 0.0
    for j in range(near.n):
        dx, dy, dz = near.x[j] - me.x, near.y[j] - me.y, near.z[j] - me.z
        heard_count += 1.0 if 0.0 < dx * dx + dy * dy + dz * dz <= p.d_c * p.d_c else 0.0
    for j in range(near.n):
        dx, dy, dz = near.x[j] - me.x, near.y[j] - me.y, near.z[j] - me.z
        d = math.sqrt(dx * dx + dy * dy + dz * dz)
        is_visible = dx * me.ux + dy * me.uy + dz * me.uz >= edge * d
        out[j] = p.w_c / heard_count if 0.0 < d <= p.d_c else 0.0
        if 0.0 < d < p.d_r or (is_visible and p.d_r <= d < p.d_o):
            out[j] += 1.0
        elif is_visible and max(p.d_r, p.d_o) <= d <= p.d_a:
            out[j] += p.w_a


GUARDED = Rule(
    name="guarded",
    title="Guarded zones",
    summary="The thesis's zones with a guard: each agent reserves a ball in which it can circle "
    "and only takes steps that leave it one, so that solid bodies never touch. Also added to the "
    "thesis: repulsion all round, and calls, heard all round, that keep the flock together.",
    equation=r"w_i = -\sum_{zor} \hat r_{ij} + \frac{\sum_{zoo} \hat v_j + w_a \sum_{zoa} "
    r"\hat r_{ij}}{|\cdot|} + \frac{w_c}{n_c} \sum_{D_{ij} \le d_c} \hat r_{ij}, \quad v_i = "
    r"\text{the step nearest to } v_0 \hat w_i \text{ with } (c_i' - c_i) \cdot e_{ij} + \rho_i' "
    r"\le \rho_i + \tfrac12 g_{ij}",
    source="thesis, (3.6) to (3.12), (4.1), (4.2); the guard and the calls are ours",
    checked="the aim of the thesis, no crash: {guarded-alpha#1} (`flockscope paper guarded-alpha`)",
    tags=("robotics", "birds", "flapping wings", "collisions", "swarm"),
    parameters=GuardedZones,
    decide=decide,
    sifts=True,
    wish="velocity",
    reach="range",
    together="d_a",
    # Named as in recordings: the centre of the reserved ball seen from the agent, its radius.
    signals=("room_x", "room_y", "room_z", "room_radius"),
    symmetries=("shift", "rotation"),  # one that knows no way out yet escapes to its left
    show=show,
    remember=remember,
    memory=("wish_x", "wish_y", "wish_z", "next_x", "next_y", "next_z", "next_radius"),
    units={
        "room": "length",
        "room_radius": "length",
        "wish": "length/time",
        "next": "length",
        "next_radius": "length",
    },
    words={
        "room": "to its ball's middle",
        "room_radius": "its ball's radius",
        "wish": "velocity it wants",
        "next": "to its next ball's",
        "next_radius": "next ball's radius",
    },
    perceive=perceive,
    weigh=weigh,
    zones=REPELLED_ALL_ROUND,
    view="alpha",
    sees_obstacles=True,
    led=False,
    tries=(
        LessonStep(
            "Switch the guard off.",
            "Agents crash into each other and into the blocks; with it nobody does.",
            {"guard": False},
            LessonCheck("crashes", "above", 1, 300),
            anew=True,
        ),
        LessonStep(
            "Let nobody hear the calls.",
            "Out of each other's sight the flock comes apart into several groups.",
            {"w_c": 0.0},
            LessonCheck("groups", "above", 2.5, 300),
            anew=True,
        ),
        LessonStep(
            "Double the zone of repulsion.",
            "Everybody backs away from everybody: the flock is twice as wide, and goes nowhere.",
            {"d_r": 4.0},
            LessonCheck("gyration-radius", "above", 5, 300),
            anew=True,
        ),
    ),
)
