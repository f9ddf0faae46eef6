"""The words of `Flock` and `Spec` with their types, written by `packing/flock_words.py`.

A model of a file of your own has parameters that stand here not: give them as
`Flock(Spec("mine", parameters={"pull": 0.5}))`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypedDict

from worlds.world import World


class ParameterWords(TypedDict, total=False):
    """Parameters of rules and bodies, of all models."""

    a: float
    a_frict: float
    a_max: float
    a_shill: float
    ahead: float
    alpha: float
    alpha_s: float
    alpha_turn: float
    b: float
    beta: Literal["alpha-form", "printed"] | float
    beta_p: float
    body: float
    border: float
    c: float
    C: float
    c1a: float
    c1b: float
    c1g: float
    c2a: float
    c2b: float
    c2g: float
    C_a: float
    c_align: float
    c_att: float
    c_frict: float
    c_goal: float
    C_p: float
    C_r: float
    c_rep: float
    chi: float
    circle: float
    clearance: float
    climb: float
    contact: Literal["always", "start", "stops", "crashes"]
    d: float
    d_0: float
    d_a: float
    d_beta: float
    d_c: float
    d_min: float
    d_o: float
    D_r: float
    d_r: float
    d_s: float
    D_t: float
    derivative: float
    dr_a: float
    dr_o: float
    drop: float
    dropout: float
    dt: float
    dtheta: float
    eps: float
    eta: float
    fov: float
    g: float
    gain: float
    gamma: float
    guard: bool
    h: float
    haste: float
    hop: float
    integral: float
    J: float
    k: float
    K: float
    k_alpha: float
    k_beta: float
    k_gamma: float
    k_iu: float
    l_a: float
    l_r: float
    lag: float
    latency: float
    layers: Literal["delayed", "instant"]
    length: float
    look_ahead: float
    loss: float
    m: float
    margin: float
    max_force: float
    max_speed: float
    min_speed: float
    miss: float
    mu: float
    n_sub: float
    neighbourhood_weight: bool
    neighbours: Literal["metric", "nearest"]
    noise_bearing: float
    noise_range: float
    noise_xy: float
    noise_yaw: float
    p1: float
    p2: float
    p_frict: float
    p_max: float
    p_rep: float
    p_shill: float
    power: float
    predators: float
    Q: float
    r: float
    r0_frict: float
    r0_rep: float
    r0_shill: float
    r_alignment: float
    r_att: float
    r_avoid: float
    r_border: float
    r_cohesion: float
    r_r: float
    r_rep: float
    r_separation: float
    repulsion: float
    reverse: bool
    s: float
    sense: Literal["counterclockwise", "clockwise"]
    sensing: Literal["tracking", "own"]
    servo: float
    sigma: float
    soft: float
    spread: float
    step: float
    step_time: float
    T: float
    t_c: float
    t_s: float
    tau: float
    tau_a: float
    tau_e: float
    tau_s: float
    theta: float
    theta_max: float
    theta_obstruct: float
    tip: float
    v0: float
    v_flock: float
    v_frict: float
    v_max: float
    v_min: float
    v_shill: float
    v_start: float
    w: float
    w_a: float
    w_alignment: float
    w_avoidance: float
    w_c: float
    w_cohesion: float
    w_seek: float
    w_separation: float
    ways: Literal["two", "own", "goal"]
    wheel_max: float
    width: float
    windup: float
    yields: bool


class OptionWords(TypedDict, total=False):
    """Options of a run; None is as the model, or its world, has it."""

    agents: int | None
    informed: int | None
    seed: int | None
    world: str | World | None
    size: float | Sequence[float] | None
    dim: Literal[2, 3] | None
    activation: Literal["synchronous", "random", "sequential"] | None
    noise: Literal["angular", "vectorial"] | None
    spacing: float | None
    delay: float | None
    jitter: float | None
    lost: float | None
    place_error: float | None
    wind: float | None
    wind_heading: float | None
    wind_up: float | None
    gusts: float | None
    gust_time: float | None
    pulse: float | None
    pulse_at: float | None
    pulse_lasts: float | None


class FlockWords(OptionWords, ParameterWords, total=False):
    """All that `Flock` takes beside a model and how to run it."""


class SpecWords(OptionWords, total=False):
    """All that `Spec` takes beside a model."""

    start: Literal["random", "given"]
    parameters: Mapping[str, Any]
    layout: Mapping[str, Any] | None
    versions: Mapping[str, str]
