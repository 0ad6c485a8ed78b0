"""CasADi: the crank's angle as the only coordinate, the loop closed by a formula, RK4 unrolled with `mapaccum`, reverse mode.

The equation of motion is M w' = torque - V_a - M_a w^2 / 2; CasADi differentiates M and V. The functions are interpreted, or
generated as C and compiled.
"""

import os
import tempfile

import casadi as ca
import numpy as np

import task
from casadi_tools import compiled, has_compiler

STEPS = 200


# begin
def rates():
    """(a, w), torque, length -> (w, w'); and the rocker's angle."""
    crank, speed, torque, coupler = (ca.SX.sym(name) for name in ("crank", "speed", "torque", "coupler"))
    angle, rocker = task.closure(crank, coupler, ca)
    along = lambda length, angle: length * ca.vertcat(ca.cos(angle), ca.sin(angle))
    rods = [
        (task.CRANK, crank, along(task.CRANK / 2, crank)),
        (coupler, angle, along(task.CRANK, crank) + along(coupler / 2, angle)),
        (task.ROCKER, rocker, along(task.ROCKER / 2, rocker)),
    ]
    mass, potential = 0.0, 0.0
    for length, turn, centre in rods:
        by_crank, turns = ca.jacobian(centre, crank), ca.jacobian(turn, crank)
        mass += task.DENSITY * length * (ca.dot(by_crank, by_crank) + length**2 / 12 * turns**2)
        potential += task.DENSITY * length * task.GRAVITY * centre[1]
    force = torque - ca.gradient(potential, crank) - 0.5 * ca.gradient(mass, crank) * speed**2
    rate = ca.Function("rate", [ca.vertcat(crank, speed), torque, coupler], [ca.vertcat(speed, force / mass)])
    return rate, ca.Function("rocker", [crank, coupler], [rocker])


def functions(is_compiled):
    rate, rocker = rates()
    x, at, coupler, h = ca.SX.sym("x", 2), ca.SX.sym("torques", 3), ca.SX.sym("coupler"), task.DURATION / STEPS
    k1 = rate(x, at[0], coupler)
    k2 = rate(x + h / 2 * k1, at[1], coupler)
    k3 = rate(x + h / 2 * k2, at[1], coupler)
    k4 = rate(x + h * k3, at[2], coupler)
    step = ca.Function("step", [x, at, coupler], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)])

    torques, coupler = ca.MX.sym("torques", len(task.KNOTS)), ca.MX.sym("coupler")
    at = ca.mtimes(ca.DM(task.interpolation(np.linspace(0.0, task.DURATION, 2 * STEPS + 1))), torques).T
    stages = ca.vertcat(at[0:-1:2], at[1::2], at[2::2])
    states = step.mapaccum(STEPS)(ca.DM([task.START, 0.0]), stages, ca.repmat(coupler, 1, STEPS))
    cost = task.cost(rocker(states[0, -1], coupler))
    value = ca.Function("value", [torques, coupler], [cost])
    both = ca.Function("both", [torques, coupler], [cost, *(ca.gradient(cost, x) for x in (torques, coupler))])
    if is_compiled:
        value, both = compiled(value), compiled(both)

    def gradient(torques, coupler):
        cost, by_torque, by_length = both(torques, coupler)
        return float(cost), np.array(by_torque).ravel(), float(by_length)

    return lambda torques, coupler: float(value(torques, coupler)), gradient
# end


if __name__ == "__main__":
    ways = [("RK4, interpreted", STEPS, lambda: functions(False))]
    if has_compiler():
        ways.append(("RK4, generated C", STEPS, lambda: functions(True)))
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)  # of the generated C
        task.main(ways)
