"""J and dJ/du of the trapezoidal rule in minimal coordinates (x, phi_1, ...), by complex step: what the peers in these unknowns are
compared with. It differs from the paper's discretisation by O(dt^2).

T = 1/2 (mc + K m) x'^2 - x' sum_j b_j sin(phi_j) w_j + 1/2 sum_ij a_ij cos(phi_i - phi_j) w_i w_j,   V = g sum_j b_j sin(phi_j)
"""

import numpy as np

from common import (CART_MASS, FORCE, GRAVITY, HALF_LENGTH, HALF_STEP as h, HINGE_FRICTION, LINK_INERTIA, LINK_MASS, LINKS,
                    RAIL_FRICTION, START_ANGLE, STEPS, TARGET_ANGLE)

_LENGTH = 2 * HALF_LENGTH
_AFTER = LINKS - 1 - np.arange(LINKS)  # how many links hang on this one
_B = LINK_MASS * (HALF_LENGTH + _LENGTH * _AFTER)
_OUTER = np.maximum.outer(np.arange(LINKS), np.arange(LINKS))
_A = _LENGTH * _B[_OUTER] + np.diag(LINK_INERTIA + LINK_MASS * HALF_LENGTH**2 - LINK_MASS * HALF_LENGTH * _LENGTH * np.ones(LINKS))


def momentum_and_rate(q, v, u):
    """T_v and T_q - V_q + Q for rows of q, v and u."""
    phi, w, speed = q[:, 1:], v[:, 1:], v[:, :1]
    sin, cos = np.sin(phi), np.cos(phi)
    turn = phi[:, :, None] - phi[:, None, :]
    p, g = np.empty_like(q), np.empty_like(q)
    p[:, 0] = (CART_MASS + LINKS * LINK_MASS) * speed[:, 0] - (_B * sin * w).sum(1)
    p[:, 1:] = -_B * sin * speed + np.einsum("ij,bij,bj->bi", _A, np.cos(turn), w)
    g[:, 0] = u - RAIL_FRICTION * speed[:, 0]
    g[:, 1:] = -speed * _B * cos * w - w * np.einsum("ij,bij,bj->bi", _A, np.sin(turn), w) - GRAVITY * _B * cos
    g[:, 1] -= HINGE_FRICTION * w[:, 0]
    return p, g


def newton_matrix(q, v, u):
    """The real derivative of p - h g with respect to v, where q = q_start + h v."""
    n, tiny = LINKS + 1, 1e-30
    step = 1j * tiny * np.eye(n)
    p, g = momentum_and_rate(q.real + h * step, v.real + step, np.full(n, u))
    return (p - h * g).imag.T / tiny


def reference():
    """J and dJ/du, all controls at once."""
    n, tiny, count = LINKS + 1, 1e-30, STEPS + 1
    u = FORCE + 1j * tiny * np.eye(count)
    q, v = np.zeros((count, n), complex), np.zeros((count, n), complex)
    q[:, 1:] = START_ANGLE
    p, g = momentum_and_rate(q, v, u[:, 0])
    for i in range(1, count):
        q_start, p_start = q + h * v, p + h * g
        for _ in range(8):
            q = q_start + h * v
            p, g = momentum_and_rate(q, v, u[:, i])
            matrix = newton_matrix(q[:1], v[:1], FORCE)
            v = v - np.linalg.solve(matrix, (p - h * g - p_start).T).T
        q = q_start + h * v
        p, g = momentum_and_rate(q, v, u[:, i])
    j = 0.5 * ((q[:, 1:] - TARGET_ANGLE) ** 2).sum(1)
    return j[0].real, j.imag / tiny


if __name__ == "__main__":
    value, gradient = reference()
    print(f"{value!r} {gradient[0]!r} {gradient[50]!r} {gradient[100]!r}")
