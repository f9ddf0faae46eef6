"""DeLaurier (1993) as the paper writes it: one section, one instant, plain numbers.

h: plunging, m, downward. theta: pitch, rad, nose up, mean theta_bar. U: flight speed. The section
is uncambered and turns about its leading edge; forces per metre of span.
"""

import math

RHO = 1.225


def wake(k, AR):
    """F'(k) and G'(k)."""
    C1 = 0.5 * AR / (2.32 + AR)
    C2 = 0.181 + 0.772 / AR
    return 1.0 - C1 * k**2 / (k**2 + C2**2), -C1 * C2 * k / (k**2 + C2**2)


def alpha_prime(alpha, d_alpha, k, theta_bar, U, c, AR):
    """The flow's relative angle of attack at three quarters of the chord."""
    F, G = wake(k, AR)
    w0_over_U = 2.0 * theta_bar / (2.0 + AR)
    return AR / (2.0 + AR) * (F * alpha + c / (2.0 * U) * G / k * d_alpha) - w0_over_U


def attached(angle, middle, d_theta, Vx, U, c, eta_s, Cd_f):
    """dN_c and dF_x of an attached flow; `angle` is alpha' + theta_bar."""
    del middle
    V = math.sqrt(Vx**2 + (U * angle - 0.5 * c * d_theta) ** 2)
    dN_c = RHO * U * V / 2.0 * 2.0 * math.pi * angle * c
    dT_s = eta_s * 2.0 * math.pi * (angle - c * d_theta / (4.0 * U)) ** 2 * RHO * U * V / 2.0 * c
    dD_f = Cd_f * RHO * Vx**2 / 2.0 * c
    return dN_c, dT_s - dD_f


def stalled(angle, middle, d_theta, Vx, U, c, Cd_cf):
    """dN_c and dF_x of a flow that has left; `middle` is V_n, the velocity across mid chord."""
    del angle, d_theta, U
    return Cd_cf * RHO * math.hypot(Vx, middle) * middle / 2.0 * c, 0.0


def leading_edge_angle(angle, d_theta, U, c):
    """The angle by which DeLaurier tells whether the flow has left."""
    return angle - 0.75 * c * d_theta / U
