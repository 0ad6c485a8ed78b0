"""The paper's scheme in its plain form: all 4n + m unknowns y = (v, g, q, p, sigma) of a step, dense matrices (g = dp*/dt)."""

import numpy as np

from common import FORCE, HALF_STEP as h, STEPS, TARGET_ANGLE, Maximal, row, time_ms

x = Maximal()
n, m = x.n, x.m
SIZE = 4 * n + m
V, G, Q, P = (slice(i * n, (i + 1) * n) for i in range(4))
S = slice(4 * n, SIZE)
E1, E2, E3, E4, E5 = V, G, Q, P, S
PUSH = np.zeros(n)
PUSH[0] = 1.0


def phi_q(sin, cos):
    return x.a - x.c * sin + x.s * cos


def equations(y, before, u):
    """f(y_i, y_{i-1}, u_i) and its Jacobian with respect to y_i."""
    v, g, q, p, sigma = y[V], y[G], y[Q], y[P], y[S]
    sin, cos = np.sin(q), np.cos(q)
    jacobian = phi_q(sin, cos)
    curvature = -(x.c * cos + x.s * sin)  # of Phi: its second derivatives are on the diagonal
    bend = sigma @ curvature
    bend_q = sigma @ (x.c * sin - x.s * cos)
    f = np.empty(SIZE)
    f[E1] = q - before[Q] - h * (v + before[V])
    f[E2] = p - before[P] - h * (g + before[G])
    f[E3] = x.mass * v + sigma @ jacobian - p
    f[E4] = x.weight + PUSH * u - x.damping @ v + v * bend - g
    f[E5] = jacobian @ v
    f_y = np.zeros((SIZE, SIZE))
    eye = np.eye(n)
    f_y[E1, V], f_y[E1, Q] = -h * eye, eye
    f_y[E2, G], f_y[E2, P] = -h * eye, eye
    f_y[E3, V], f_y[E3, Q], f_y[E3, P], f_y[E3, S] = np.diag(x.mass), np.diag(bend), -eye, jacobian.T
    f_y[E4, V], f_y[E4, G], f_y[E4, Q] = np.diag(bend) - x.damping, -eye, np.diag(v * bend_q)
    f_y[E4, S] = (curvature * v).T
    f_y[E5, V], f_y[E5, Q] = jacobian, curvature * v
    return f, f_y


def before_jacobian():
    """f's Jacobian with respect to y_{i-1}: constant."""
    f_y = np.zeros((SIZE, SIZE))
    eye = np.eye(n)
    f_y[E1, V], f_y[E1, Q] = -h * eye, -eye
    f_y[E2, G], f_y[E2, P] = -h * eye, -eye
    return f_y


def simulate(u):
    """All y_i, and the Jacobians at them."""
    y = np.zeros((STEPS + 1, SIZE))
    y[0, Q] = x.start
    y[0, G] = x.weight + PUSH * u[0]
    jacobians = [None]
    for i in range(1, STEPS + 1):
        y[i] = 2 * y[i - 1] - y[i - 2] if i > 1 else y[0]
        for _ in range(20):
            f, f_y = equations(y[i], y[i - 1], u[i])
            delta = np.linalg.solve(f_y, -f)
            y[i] += delta
            if np.abs(delta).max() < 1e-9 * np.abs(y[i]).max():
                break
        jacobians.append(equations(y[i], y[i - 1], u[i])[1])
    return y, jacobians


def cost(y):
    error = y[STEPS, Q][x.angles] - TARGET_ANGLE
    return 0.5 * error @ error


def gradient(u):
    y, jacobians = simulate(u)
    f_before = before_jacobian().T
    right = np.zeros(SIZE)
    right[Q][x.angles] = -(y[STEPS, Q][x.angles] - TARGET_ANGLE)
    dj = np.zeros(STEPS + 1)
    for i in range(STEPS, 0, -1):
        w = np.linalg.solve(jacobians[i].T, right)
        dj[i] = w[E4] @ PUSH
        right = -(f_before @ w)
    # u_0 acts through g_0 alone.
    dj[0] = -right[G] @ PUSH
    return cost(y), dj


controls = np.full(STEPS + 1, FORCE)
value, dj = gradient(controls)
row("numpy, dense", "maximal, 4n + m, the paper's scheme", time_ms(lambda: simulate(controls)), time_ms(lambda: gradient(controls)),
    value, dj, "derivatives and adjoint by hand")
