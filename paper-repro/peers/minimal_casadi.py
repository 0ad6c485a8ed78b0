"""CasADi in minimal coordinates (x, phi_1, phi_2, phi_3): the trapezoidal rule on (q, p) with p = T_v, as generated C and interpreted."""

import casadi as ca

from casadi_tools import chain, compiled, has_compiler, report
from common import (CART_MASS, FORCE, HALF_LENGTH, HALF_STEP as h, HINGE_FRICTION, LINK_INERTIA, LINK_MASS, LINKS,
                    RAIL_FRICTION, START_ANGLE, STEPS, TARGET_ANGLE)
from minimal_reference import reference

n = LINKS + 1
SCHEME = "minimal, trapezoidal on (q, p)"


def lagrangian(q, v):
    """T - V."""
    return chain(q, v, [(LINK_MASS, HALF_LENGTH, LINK_INERTIA)] * LINKS, CART_MASS)


def step_function(rootfinder, options):
    """(q, p, v, older v, g_{i-1}), u_i -> the same one step later (g = dp/dt)."""
    q, v, u = ca.SX.sym("q", n), ca.SX.sym("v", n), ca.SX.sym("u")
    energy = lagrangian(q, v)
    friction = ca.vertcat(RAIL_FRICTION * v[0], HINGE_FRICTION * v[1], ca.DM.zeros(n - 2))
    rate = ca.gradient(energy, q) - friction + ca.vertcat(u, ca.DM.zeros(n - 1))
    momentum = ca.gradient(energy, v)
    rates = ca.Function("rates", [q, v, u], [rate])

    q_start, p_start = ca.SX.sym("q_start", n), ca.SX.sym("p_start", n)
    residual = ca.substitute(momentum - h * rate, q, q_start + h * v) - p_start
    solve = ca.rootfinder("solve", rootfinder, {"x": v, "p": ca.vertcat(q_start, p_start, u), "g": residual}, options)

    state, u = ca.MX.sym("state", 5 * n), ca.MX.sym("u")
    q, p, now, before, g = ca.vertsplit(state, n)
    q_start, p_start = q + h * now, p + h * g
    root = solve(x0=2 * now - before, p=ca.vertcat(q_start, p_start, u))["x"]
    q_next = q_start + h * root
    g_next = rates(q_next, root, u)
    step = ca.Function("step", [state, u], [ca.vertcat(q_next, p_start + h * g_next, root, now, g_next)])
    return step, rates


def functions(rootfinder, options):
    step, rates = step_function(rootfinder, options)
    u = ca.MX.sym("u", 1, STEPS + 1)
    q = ca.DM([0.0] + [START_ANGLE] * LINKS)
    start = ca.vertcat(q, ca.DM.zeros(3 * n), rates(q, ca.DM.zeros(n), u[0]))
    error = step.mapaccum(STEPS)(start, u[1:])[1:n, -1] - TARGET_ANGLE
    cost = 0.5 * ca.dot(error, error)
    return ca.Function("value", [u], [cost]), ca.Function("both", [u], [cost, ca.gradient(cost, u)])


expected = reference()
value, both = functions("newton", {"abstol": 1e-12, "abstolStep": 1e-9})
report("CasADi", SCHEME, value, both, "derivatives, Newton and adjoint automatic", expected)
if has_compiler():
    value, both = functions("fast_newton", {"abstol": 1e-12, "abstolStep": 1e-9})
    report("CasADi, generated C", SCHEME, compiled(value), compiled(both), "the same, compiled", expected)
