"""The words of `Flock` and `Spec` with their types, written by `packing/flock_words.py`.

A model of a file of your own has parameters that stand here not: give them as
`Flock(Spec("mine", parameters={"pull": 0.5}))`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypedDict

import numpy as np

from agents.individuals import Distribution
from worlds.world import World

Number = float | Distribution | Sequence[float] | np.ndarray
"""A number of all agents, or what gives each agent its own."""


class ParameterWords(TypedDict, total=False):
    """Parameters of rules and bodies, of all models."""

    a: Number
    a_frict: Number
    a_max: Number
    a_shill: Number
    ahead: Number
    alpha: Number
    alpha_s: Number
    alpha_turn: Number
    b: Number
    beta: Literal["alpha-form", "printed"] | Number
    beta_p: Number
    body: Number
    border: Number
    c: Number
    C: Number
    c1a: Number
    c1b: Number
    c1g: Number
    c2a: Number
    c2b: Number
    c2g: Number
    C_a: Number
    c_align: Number
    c_att: Number
    c_frict: Number
    c_goal: Number
    C_p: Number
    C_r: Number
    c_rep: Number
    chi: Number
    circle: Number
    clearance: Number
    climb: Number
    contact: Literal["always", "start", "stops", "crashes"]
    d: Number
    d_0: Number
    d_a: Number
    d_beta: Number
    d_c: Number
    d_min: Number
    d_o: Number
    D_r: Number
    d_r: Number
    d_s: Number
    D_t: Number
    derivative: Number
    dr_a: Number
    dr_o: Number
    drop: Number
    dropout: Number
    dt: Number
    dtheta: Number
    eps: Number
    eta: Number
    fov: Number
    g: Number
    gain: Number
    gamma: Number
    guard: bool
    h: Number
    haste: Number
    hop: Number
    integral: Number
    J: Number
    k: Number
    K: Number
    k_alpha: Number
    k_beta: Number
    k_gamma: Number
    k_iu: Number
    l_a: Number
    l_r: Number
    lag: Number
    latency: Number
    layers: Literal["delayed", "instant"]
    length: Number
    look_ahead: Number
    loss: Number
    m: Number
    margin: Number
    max_force: Number
    max_speed: Number
    min_speed: Number
    miss: Number
    mu: Number
    n_sub: Number
    neighbourhood_weight: bool
    neighbours: Literal["metric", "nearest"]
    noise_bearing: Number
    noise_range: Number
    noise_xy: Number
    noise_yaw: Number
    omega: Number
    p1: Number
    p2: Number
    p_frict: Number
    p_max: Number
    p_rep: Number
    p_shill: Number
    power: Number
    predators: Number
    Q: Number
    r: Number
    r0_frict: Number
    r0_rep: Number
    r0_shill: Number
    r_alignment: Number
    r_att: Number
    r_avoid: Number
    r_border: Number
    r_cohesion: Number
    r_r: Number
    r_rep: Number
    r_separation: Number
    repulsion: Number
    reverse: bool
    rho: Number
    s: Number
    sense: Literal["counterclockwise", "clockwise"]
    sensing: Literal["tracking", "own"]
    servo: Number
    sigma: Number
    soft: Number
    spread: Number
    step: Number
    step_time: Number
    T: Number
    t_c: Number
    t_s: Number
    tau: Number
    tau_a: Number
    tau_e: Number
    tau_s: Number
    theta: Number
    theta_max: Number
    theta_obstruct: Number
    tip: Number
    v0: Number
    v_flock: Number
    v_frict: Number
    v_max: Number
    v_min: Number
    v_shill: Number
    v_start: Number
    w: Number
    w_a: Number
    w_alignment: Number
    w_avoidance: Number
    w_c: Number
    w_cohesion: Number
    w_seek: Number
    w_separation: Number
    ways: Literal["two", "own", "goal"]
    wheel_max: Number
    width: Number
    windup: Number
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
