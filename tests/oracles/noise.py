"""The engine's noise: a hash of (seed, tick, agent, draw), in Python integers modulo 2**64.

The mixing steps are the finaliser of splitmix64 (Steele, Lea & Flood, OOPSLA 2014).
"""

import math

import numpy as np

G = 0x9E3779B97F4A7C15  # 2**64 / golden ratio, odd
WORD = 2**64


def mix(z):
    """The splitmix64 finaliser of a 64-bit word."""
    z %= WORD
    z ^= z >> 30
    z = z * 0xBF58476D1CE4E5B9 % WORD
    z ^= z >> 27
    z = z * 0x94D049BB133111EB % WORD
    z ^= z >> 31
    return z


def key(seed, tick):
    """The 64-bit word that all draws of one tick start from."""
    return mix(mix(seed + G) + (tick + 1) * G)


def uniform(seed, tick, ident, draw):
    """A float in [0, 1) with 53 random bits; at most 16 draws per agent and tick."""
    return (mix(key(seed, tick) + (ident * 16 + draw) * G) >> 11) * 2.0**-53


def turns(seed, tick, ids, eta):
    """Angular noise, (N,) rad: uniform in [-eta / 2, eta / 2), paper equation (6)."""
    return np.array([eta * (uniform(seed, tick, int(i), 0) - 0.5) for i in ids])


def directions(seed, tick, ids):
    """Vectorial noise in 2-D, (N, 2): unit vectors at a uniform angle."""
    theta = [math.tau * uniform(seed, tick, int(i), 0) for i in ids]
    return np.array([(math.cos(t), math.sin(t)) for t in theta]).reshape(-1, 2)
