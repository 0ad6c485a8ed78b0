"""Computes triple_pendulum.json: a triple pendulum by the trapezoidal rule of the paper with 40 digits, and derivatives of its cost.

Three thin rods (1 kg, 1 m) hang in a chain from the origin and are released at rest, stretched out along the x axis; g = 9.81 m/s^2;
coordinates (x, y, phi) of each rod; a torque u_i on the first rod, all zero; dt = 0.01 s, 500 steps;
J = 1/2 sum (phi_k - 1)^2 at the end. Derivatives are central differences of whole simulations with steps of 1e-12: exact to 20 digits.

    python3 triple_pendulum.py > triple_pendulum.json
"""

import json
from mpmath import mp, mpf, matrix, lu_solve, cos, sin, norm, inf

mp.dps = 40
RODS, STEPS = 3, 500
N, M = 3 * RODS, 2 * RODS
MASS, HALF, GRAVITY = mpf(1), mpf(1) / 2, mpf("9.81")
INERTIA = MASS / 12


def arms(q, joint):
    """(body, sign, arm in the inertial frame) of the sides of a hinge: phi = r_b + R_b s_b - r_a - R_a s_a."""
    sides = [(joint, 1, -HALF)] + ([(joint - 1, -1, HALF)] if joint > 0 else [])
    return [(k, sign, [s * cos(q[3 * k + 2]), s * sin(q[3 * k + 2])]) for k, sign, s in sides]


def evaluate(q, v, sigma, torque):
    """Phi_q, (dPhi/dt)_q, L_q + Q, and L_qq on the diagonal."""
    phi_q, rate_q, force, second = matrix(M, N), matrix(M, N), matrix(N, 1), matrix(N, 1)
    for k in range(RODS):
        force[3 * k + 1] -= MASS * GRAVITY
    force[2] += torque
    for joint in range(RODS):
        s0, s1 = sigma[2 * joint], sigma[2 * joint + 1]
        for k, sign, (ax, ay) in arms(q, joint):
            turn = v[3 * k + 2]
            phi_q[2 * joint, 3 * k] = phi_q[2 * joint + 1, 3 * k + 1] = mpf(sign)
            phi_q[2 * joint, 3 * k + 2], phi_q[2 * joint + 1, 3 * k + 2] = -sign * ay, sign * ax
            rate_q[2 * joint, 3 * k + 2], rate_q[2 * joint + 1, 3 * k + 2] = -sign * ax * turn, -sign * ay * turn
            force[3 * k + 2] -= sign * (s0 * ax + s1 * ay) * turn
            second[3 * k + 2] += sign * (s0 * ay - s1 * ax) * turn
    return phi_q, rate_q, force, second


def masses():
    return [INERTIA if i % 3 == 2 else MASS for i in range(N)]


def step(state, dt, torque):
    q0, v0, p0, g0, sigma0 = state
    h, mass = dt / 2, masses()
    v, sigma = v0.copy(), sigma0.copy()
    for _ in range(12):
        q = q0 + h * (v0 + v)
        phi_q, rate_q, force, second = evaluate(q, v, sigma, torque)
        momentum = phi_q.T * sigma
        right, jacobian = matrix(N + M, 1), matrix(N + M, N + M)
        rate = phi_q * v
        for i in range(N):
            right[i] = p0[i] + h * (g0[i] + force[i]) - mass[i] * v[i] - momentum[i]
            jacobian[i, i] = mass[i] - h * h * second[i]
            for j in range(M):
                jacobian[i, N + j] = phi_q[j, i] - h * rate_q[j, i]
                jacobian[N + j, i] = phi_q[j, i] + h * rate_q[j, i]
        for j in range(M):
            right[N + j] = -rate[j]
        change = lu_solve(jacobian, right)
        for i in range(N):
            v[i] += change[i]
        for j in range(M):
            sigma[j] += change[N + j]
        if norm(change, inf) < mpf(10) ** -22:  # The next one is below 1e-40.
            break
    else:
        raise ArithmeticError("no convergence")
    q = q0 + h * (v0 + v)
    force = evaluate(q, v, sigma, torque)[2]
    return q, v, p0 + h * (g0 + force), force, sigma


def cost(torques=None, steps=None):
    """J, and the angles, for changes of some torques and step lengths."""
    torques, steps = torques or {}, steps or {}
    q = matrix([x for k in range(RODS) for x in (k + HALF, mpf(0), mpf(0))])
    v, sigma = matrix(N, 1), matrix(M, 1)
    state = (q, v, matrix(N, 1), evaluate(q, v, sigma, torques.get(0, mpf(0)))[2], sigma)
    for i in range(1, STEPS + 1):
        state = step(state, mpf("0.01") + steps.get(i, mpf(0)), torques.get(i, mpf(0)))
    angles = [state[0][3 * k + 2] for k in range(RODS)]
    return sum((phi - 1) ** 2 for phi in angles) / 2, angles


def derivative(**change):
    (kind, index), = change.items()
    small = mpf(10) ** -12
    return (cost(**{kind: {index: small}})[0] - cost(**{kind: {index: -small}})[0]) / (2 * small)


value, angles = cost()
nodes, lengths = [0, 100, 250, 400], [1, 200]
print(json.dumps({
    "J": float(value),
    "angles": [float(phi) for phi in angles],
    "nodes": nodes,
    "gradient": [float(derivative(torques=i)) for i in nodes],
    "steps": lengths,
    "step_gradient": [float(derivative(steps=i)) for i in lengths],
}, indent=1))
