"""Reference values, written to `reference.json`: one coordinate, DOP853 with a tolerance of 1e-13, derivatives by complex step.

With the crank's angle a and its speed w, the kinetic energy is M(a) w^2 / 2 and the potential V(a), so M w' = torque - V_a - M_a w^2 / 2. The angles
c and r of the coupler and the rocker are integrated, too: c' = c_a w, r' = r_a w. A second program solves the equations in the absolute coordinates
of the three rods with Lagrange multipliers; its J is stored, too.
"""

import json

import numpy as np
from scipy.integrate import solve_ivp

import task
from task import COUPLER, CRANK, DENSITY, GRAVITY, GROUND, KNOTS, ROCKER, START, TORQUES

STEP = 1e-30  # of complex derivatives
TOLERANCE = 1e-13


def rod(length):
    """Mass and moment of inertia about the centre."""
    return DENSITY * length, DENSITY * length**3 / 12


def one_coordinate(coupler):
    """(a, w, c, r), torque -> rates; and the start."""
    (m_a, i_a), (m_c, i_c), (m_r, i_r) = rod(CRANK), rod(coupler), rod(ROCKER)
    j_a, j_c, j_r = i_a + m_a * CRANK**2 / 4, i_c + m_c * coupler**2 / 4, i_r + m_r * ROCKER**2 / 4  # about the ends

    def rate(state, torque):
        a, w, c, r = state
        sine, cosine = np.sin(c - r), np.cos(c - r)
        c_a, r_a = CRANK * np.sin(r - a) / (coupler * sine), CRANK * np.sin(c - a) / (ROCKER * sine)
        c_aa = (CRANK / coupler * np.cos(r - a) * (r_a - 1) - c_a * (c_a - r_a) * cosine) / sine
        r_aa = (CRANK / ROCKER * np.cos(c - a) * (c_a - 1) - r_a * (c_a - r_a) * cosine) / sine
        both = m_c * CRANK * coupler
        mass = j_a + m_c * CRANK**2 + j_c * c_a**2 + both * c_a * np.cos(c - a) + j_r * r_a**2
        half_mass_a = j_c * c_a * c_aa + both / 2 * (c_aa * np.cos(c - a) - c_a * np.sin(c - a) * (c_a - 1)) + j_r * r_a * r_aa
        weight = m_a * CRANK / 2 * np.cos(a) + m_c * (CRANK * np.cos(a) + coupler / 2 * np.cos(c) * c_a) + m_r * ROCKER / 2 * np.cos(r) * r_a
        return np.array([w, (torque - GRAVITY * weight - half_mass_a * w**2) / mass, c_a * w, r_a * w])

    return rate, np.array([START, 0.0, *task.closure(START, coupler)])


def absolute(coupler):
    """(x, y, angle of each rod, their rates), torque -> rates; the constraints are differentiated twice."""
    lengths = [CRANK, coupler, ROCKER]
    mass = np.diag([entry for length in lengths for entry in (rod(length)[0], rod(length)[0], rod(length)[1])])
    weight = -GRAVITY * np.array([0.0, 1.0, 0.0] * 3) * np.diag(mass)
    joints = [[(0, -1)], [(0, 1), (1, -1)], [(1, 1), (2, 1)], [(2, -1)]]  # A, B, C, D: rods and their ends; the ground does not move

    def end(q, v, index, sign):
        """Jacobian of an end with respect to q, and its acceleration without that of q."""
        half, (sin, cos) = sign * lengths[index] / 2, (np.sin(q[3 * index + 2]), np.cos(q[3 * index + 2]))
        jacobian = np.zeros((2, 9))
        jacobian[:, 3 * index : 3 * index + 2] = np.eye(2)
        jacobian[:, 3 * index + 2] = -half * sin, half * cos
        return jacobian, -half * v[3 * index + 2] ** 2 * np.array([cos, sin])

    def rate(state, torque):
        q, v = state[:9], state[9:]
        jacobian, bias = np.zeros((8, 9)), np.zeros(8)
        for row, joint in zip(range(0, 8, 2), joints):
            for sign, rod_and_end in zip((1, -1), joint):
                by_q, without = end(q, v, *rod_and_end)
                jacobian[row : row + 2] += sign * by_q
                bias[row : row + 2] += sign * without
        force = weight + torque * np.eye(9)[2]
        saddle = np.block([[mass, jacobian.T], [jacobian, np.zeros((8, 8))]])
        return np.concatenate([v, np.linalg.solve(saddle, np.concatenate([force, -bias]))[:9]])

    c, r = task.closure(START, coupler)
    along = lambda length, angle: length / 2 * np.array([np.cos(angle), np.sin(angle)])
    at_a, at_c, at_r = along(CRANK, START), along(coupler, c), along(ROCKER, r)
    return rate, np.concatenate([at_a, [START], 2 * at_a + at_c, [c], np.array([GROUND, 0.0]) + at_r, [r], np.zeros(9)])


def end_state(rate, state, torques):
    """The state at the end; the integration starts anew at each knot, where the torque has a kink."""

    def driven(t, state, start, torque, slope):
        return rate(state, torque + slope * (t - start))

    for start, end, before, after in zip(KNOTS, KNOTS[1:], torques, torques[1:]):
        linear = start, before, (after - before) / (end - start)
        found = solve_ivp(driven, (start, end), state, "DOP853", rtol=TOLERANCE, atol=TOLERANCE, args=linear)
        state = found.y[:, -1]
    return state


def value(torques, coupler):
    rate, start = one_coordinate(coupler)
    return task.cost(end_state(rate, start.astype(np.result_type(start, torques)), torques)[3])


def main():
    by_torque = []
    for knot in range(len(KNOTS)):
        torques = TORQUES.astype(complex)
        torques[knot] += STEP * 1j
        by_torque.append(value(torques, COUPLER).imag / STEP)
    by_length = value(TORQUES, COUPLER + STEP * 1j).imag / STEP
    nominal = value(TORQUES, COUPLER)
    other = task.cost(end_state(*absolute(COUPLER), TORQUES)[8])
    quotient = (value(TORQUES, COUPLER + 1e-5) - value(TORQUES, COUPLER - 1e-5)) / 2e-5
    found = {"J": nominal, "dJ/dtorque": by_torque, "dJ/dlength": by_length,
             "J in absolute coordinates": other, "dJ/dlength as a difference quotient": quotient}
    task.REFERENCE.write_text(json.dumps(found, indent=1) + "\n")
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
