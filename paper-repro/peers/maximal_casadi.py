"""CasADi, the same scheme reduced to (v, sigma): Newton and adjoint by CasADi, interpreted and as generated C."""

import casadi as ca

from casadi_tools import compiled, has_compiler, report
from common import HALF_STEP as h, STEPS, TARGET_ANGLE, Maximal

x = Maximal()
n, m = x.n, x.m


def sparse(matrix):
    """The sparse matrix without zeros, which CasADi would otherwise store as entries."""
    return ca.sparsify(ca.DM(matrix))


def phi_q(q):
    return sparse(x.a) - ca.mtimes(sparse(x.c), ca.diag(ca.sin(q))) + ca.mtimes(sparse(x.s), ca.diag(ca.cos(q)))


def force(q, v, sigma, u):
    """L_q + Q."""
    bend = -ca.mtimes((sparse(x.c) @ ca.diag(ca.cos(q)) + sparse(x.s) @ ca.diag(ca.sin(q))).T, sigma)
    push = ca.vertcat(u, ca.DM(n - 1, 1))
    return ca.DM(x.weight) + push - ca.mtimes(sparse(x.damping), v) + v * bend


def step_function(rootfinder, options):
    """(q, p, v, sigma, older v and sigma, u_{i-1}), u_i -> the same one step later."""
    unknown, given = ca.SX.sym("x", n + m), ca.SX.sym("given", 2 * n + 1)
    q0, p0, u = ca.vertsplit(given, [0, n, 2 * n, 2 * n + 1])
    v, sigma = unknown[:n], unknown[n:]
    q = q0 + h * v
    residual = ca.vertcat(
        ca.DM(x.mass) * v + phi_q(q).T @ sigma - p0 - h * force(q, v, sigma, u),
        phi_q(q) @ v,
    )
    solve = ca.rootfinder("solve", rootfinder, {"x": unknown, "p": given, "g": residual}, options)

    state = ca.MX.sym("state", 4 * n + 2 * m + 1)
    u = ca.MX.sym("u")
    q, p, now, before, u_before = ca.vertsplit(state, [0, n, 2 * n, 3 * n + m, 4 * n + 2 * m, 4 * n + 2 * m + 1])
    rate = rate_function()
    g = rate(q, now[:n], now[n:], u_before)
    q_start, p_start = q + h * now[:n], p + h * g
    root = solve(x0=2 * now - before, p=ca.vertcat(q_start, p_start, u))["x"]
    q_next = q_start + h * root[:n]
    g_next = rate(q_next, root[:n], root[n:], u)
    return ca.Function("step", [state, u], [ca.vertcat(q_next, p_start + h * g_next, root, now, u)])


def rate_function():
    q, v, sigma, u = ca.SX.sym("q", n), ca.SX.sym("v", n), ca.SX.sym("sigma", m), ca.SX.sym("u")
    return ca.Function("rate", [q, v, sigma, u], [force(q, v, sigma, u)])


def functions(rootfinder, options):
    u = ca.MX.sym("u", 1, STEPS + 1)
    start = ca.vertcat(x.start, ca.DM.zeros(3 * n + 2 * m), u[0])
    end = step_function(rootfinder, options).mapaccum(STEPS)(start, u[1:])[:n, -1]
    error = end[x.angles.tolist()] - TARGET_ANGLE
    cost = 0.5 * ca.dot(error, error)
    return ca.Function("value", [u], [cost]), ca.Function("both", [u], [cost, ca.gradient(cost, u)])


SCHEME = "maximal, n + m, the same scheme"
value, both = functions("newton", {"abstol": 1e-11, "abstolStep": 1e-9})
report("CasADi", SCHEME, value, both, "derivatives, Newton and adjoint automatic")
if has_compiler():
    value, both = functions("fast_newton", {"abstol": 1e-11, "abstolStep": 1e-9})
    report("CasADi, generated C", SCHEME, compiled(value), compiled(both), "the same, compiled")
