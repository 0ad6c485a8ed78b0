"""Crocoddyl (C++) in minimal coordinates, relative joint angles, explicit schemes, no friction (its forward dynamics has none).

The state goes forward by `rollout`, the derivatives of all steps come from `calcDiff`; the terminal cost and the backward sweep
lambda_i = Fx^T lambda_{i+1}, dJ/du_i = Fu^T lambda_{i+1} are added in numpy, and their time is given apart.
"""

import crocoddyl
import numpy as np
import pinocchio

from common import (CART_INERTIA, CART_MASS, DT, FORCE, GRAVITY, HALF_LENGTH, LINK_INERTIA, LINK_MASS, LINKS, START_ANGLE, STEPS,
                    TARGET_ANGLE, row, time_ms)


def mechanism():
    """A cart along x and links that turn from x towards z; gravity along -z."""
    model = pinocchio.Model()
    model.gravity.linear = np.array([0.0, 0.0, -GRAVITY])
    inertia = lambda mass, moment, centre: pinocchio.Inertia(mass, np.array([centre, 0.0, 0.0]), np.diag([moment] * 3))
    at = lambda along: pinocchio.SE3(np.eye(3), np.array([along, 0.0, 0.0]))
    last = model.addJoint(0, pinocchio.JointModelPX(), at(0.0), "cart")
    model.appendBodyToJoint(last, inertia(CART_MASS, CART_INERTIA, 0.0), at(0.0))
    for link in range(LINKS):
        hinge = pinocchio.JointModelRevoluteUnaligned(np.array([0.0, -1.0, 0.0]))
        last = model.addJoint(last, hinge, at(0.0 if link == 0 else 2 * HALF_LENGTH), f"hinge {link}")
        model.appendBodyToJoint(last, inertia(LINK_MASS, LINK_INERTIA, HALF_LENGTH), at(0.0))
    return model


def problem(integrate):
    state = crocoddyl.StateMultibody(mechanism())
    actuation = crocoddyl.ActuationModelFull(state)
    costs = crocoddyl.CostModelSum(state, actuation.nu)
    dynamics = crocoddyl.DifferentialActionModelFreeFwdDynamics(state, actuation, costs)
    # Without this, crocoddyl 3.2.1 with pinocchio 4.1.0 computes accelerations without gravity, and derivatives with it.
    dynamics.armature = np.zeros(state.nv)
    step, end = integrate(dynamics, DT), integrate(dynamics, 0.0)
    start = np.zeros(state.nx)
    start[1] = START_ANGLE
    shooting = crocoddyl.ShootingProblem(start, [step] * STEPS, end)
    shooting.nthreads = 1
    return shooting


def terminal(x):
    """J and its derivative; phi_j is the sum of the relative angles up to j."""
    error = np.cumsum(x[1 : LINKS + 1]) - TARGET_ANGLE
    slope = np.zeros(len(x))
    slope[1 : LINKS + 1] = np.cumsum(error[::-1])[::-1]
    return 0.5 * error @ error, slope


def backward(shooting, slope):
    gradient = np.zeros(STEPS)
    for i in reversed(range(STEPS)):
        data = shooting.runningDatas[i]
        gradient[i] = data.Fu[:, 0] @ slope
        slope = data.Fx.T @ slope
    return gradient


def report(name, integrate):
    shooting = problem(integrate)
    controls = [np.array([FORCE, 0.0, 0.0, 0.0])] * STEPS

    def derivatives():
        states = shooting.rollout(controls)
        shooting.calc(states, controls)
        shooting.calcDiff(states, controls)
        return states

    states = derivatives()
    value, slope = terminal(states[-1])
    gradient = backward(shooting, slope)
    node, change = 50, 1e-6
    shifted = []
    for sign in (1, -1):
        moved = [u.copy() for u in controls]
        moved[node][0] += sign * change
        shifted.append(terminal(shooting.rollout(moved)[-1])[0])
    error = abs((shifted[0] - shifted[1]) / (2 * change) - gradient[node]) / abs(gradient).max()
    sweep = time_ms(lambda: backward(shooting, slope))
    remark = (f"J = {value:.4f}: another scheme, no friction; dJ/du_50 agrees with a central difference to {error:.0e}; "
              f"+ {sweep:.2g} ms for the backward sweep in numpy")
    row("Crocoddyl, C++", f"minimal, {name}", time_ms(lambda: shooting.rollout(controls)), time_ms(derivatives), value, gradient,
        remark, reference=None)


report("Euler", lambda model, dt: crocoddyl.IntegratedActionModelEuler(model, dt))
report("RK4", lambda model, dt: crocoddyl.IntegratedActionModelRK(model, crocoddyl.RKType.four, dt))
