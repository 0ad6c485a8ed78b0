"""Optimal motions by `solve` of the crate and by IPOPT, from the same numbers of random starts.

IPOPT (through CasADi, with exact Hessians, interpreted) has the states at all nodes as variables: minimal coordinates q, velocities v, and the controls, with
the trapezoidal rule on q and the momenta p = T_v. Its guess of the states is a straight line, as in `solve`; its controls are random sines, not those of the
crate. The crate has absolute coordinates, or for `rail` minimal ones and the scheme ESDIRK4, so that optima differ by the errors of the schemes; for
`rail` the optima of the trapezoidal rule with 35 steps are shorter than any motion.

Usage: optima.py PROGRAM [STARTS [PROBLEM ...]], with the program paper-repro.
"""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import casadi as ca
import numpy as np

from casadi_tools import chain
from common import (CART_MASS, GRAVITY, HALF_LENGTH, HINGE_FRICTION, LINK_INERTIA, LINK_MASS, LINKS, RAIL_FRICTION, START_ANGLE, TARGET_ANGLE,
                    versions)

ARM = [(0.5, 2.0), (0.5, 1.5), (0.4, 1.0)]  # lengths in m, masses in kg
CENTRE, INERTIA = (0.0688, -0.9542), 0.0391  # of the pendulum on the rail
COUNT, LENGTH, MASS, FRICTION = 10, 0.2, 0.4, 0.5  # of the links of the chain
ALIKE = 1e-3


def cart(q, v, u):
    energy = chain(q, v, [(LINK_MASS, HALF_LENGTH, LINK_INERTIA)] * LINKS, CART_MASS)
    return energy, ca.vertcat(u[0] - RAIL_FRICTION * v[0], -HINGE_FRICTION * v[1], ca.DM.zeros(LINKS - 1))


def arm(q, v, u):
    energy = chain(q, v, [(mass, length / 2, mass * length**2 / 12) for length, mass in ARM])
    # A motor turns its link and, in the opposite direction, the link before.
    return energy, ca.vertcat(u[0] - u[1], u[1] - u[2], u[2])


def links(q, v, u):
    energy = chain(q, v, [(MASS, LENGTH / 2, MASS * LENGTH**2 / 12)] * COUNT)
    torque = u - FRICTION * (v - ca.vertcat(0.0, v[:-1]))
    return energy, torque - ca.vertcat(torque[1:], 0.0)


def acrobot(q, v, u):
    energy = chain(q, v, [(1.0, 0.5, 1.0 / 12.0)] * 2)
    return energy, ca.vertcat(-u[0], u[0])


def rail(q, v, u):
    cos, sin = ca.cos(q[1]), ca.sin(q[1])
    x = v[0] - (sin * CENTRE[0] + cos * CENTRE[1]) * v[1]
    y = (cos * CENTRE[0] - sin * CENTRE[1]) * v[1]
    energy = 0.5 * (x**2 + y**2 + INERTIA * v[1] ** 2) - GRAVITY * (sin * CENTRE[0] + cos * CENTRE[1])
    return energy, ca.vertcat(u[0], 0.0)


def limits(q):
    """Elbow and tip of the arm at a node, with their largest and least values."""
    tip = sum(length * ca.cos(q[k]) for k, (length, _) in enumerate(ARM))
    return [(q[2] - q[1], -0.4, 0.4), (tip, -np.inf, 0.9)]


def stays(q):
    return [(q[0], -1.0, 5.0)]


FREE = None
CONTROLS = {arm: 3, links: COUNT}  # one for the others
HANGING, UPRIGHT = [0.0] + [START_ANGLE] * LINKS, [FREE] + [TARGET_ANGLE] * LINKS
CURVED = [np.pi / 2 * ((k + 1) / COUNT - 1.0) for k in range(COUNT)]
# The mechanism, steps, start, end, whether it comes to rest, weight of the effort (none: the shortest time), largest control, duration with bounds, limits.
PROBLEMS = {
    "rest-2": (cart, 100, HANGING, UPRIGHT, True, 1e-4, np.inf, (2.0, 2.0, 2.0), None),
    "time": (cart, 100, HANGING, UPRIGHT, False, None, 50.0, (2.0, 0.5, 5.0), None),
    "time-rest": (cart, 100, HANGING, UPRIGHT, True, None, 50.0, (2.5, 0.5, 5.0), None),
    "rail": (rail, 35, [0.0, 0.0], [0.0, 3.14], True, None, 100.0, (2.0, 0.05, 5.0), stays),
    "arm": (arm, 100, [START_ANGLE] * 3, [TARGET_ANGLE] * 3, True, 1e-2, np.inf, (1.5, 1.5, 1.5), None),
    "acrobot": (acrobot, 100, [START_ANGLE] * 2, [TARGET_ANGLE] * 2, True, 1.0, 20.0, (3.0, 3.0, 3.0), None),
    "chain": (links, 100, [START_ANGLE] * COUNT, CURVED, True, 1e-2, np.inf, (2.0, 2.0, 2.0), None),
    "chain-500": (links, 500, [START_ANGLE] * COUNT, CURVED, True, 1e-2, np.inf, (2.0, 2.0, 2.0), None),
    "chain-2000": (links, 2000, [START_ANGLE] * COUNT, CURVED, True, 1e-2, np.inf, (2.0, 2.0, 2.0), None),
    "arm-limits": (arm, 200, [START_ANGLE] * 3, [TARGET_ANGLE] * 3, True, 1e-2, np.inf, (1.5, 1.5, 1.5), limits),
}


def transcribed(problem):
    """A function from the index of a start to (converged, J, s)."""
    mechanism, steps, start, end, rests, effort, largest, (duration, shortest, longest), path = problem
    n, k = len(start), CONTROLS.get(mechanism, 1)
    q, v, u = ca.SX.sym("q", n), ca.SX.sym("v", n), ca.SX.sym("u", k)
    energy, force = mechanism(q, v, u)
    rates = ca.Function("rates", [q, v, u], [ca.gradient(energy, v), ca.gradient(energy, q) + force])
    qs, vs, us, total = ca.MX.sym("q", n, steps + 1), ca.MX.sym("v", n, steps + 1), ca.MX.sym("u", k, steps + 1), ca.MX.sym("T")
    h = total / steps
    p, g = rates.map(steps + 1)(qs, vs, us)
    trapezoid = lambda x: x[:, 1:] + x[:, :-1]
    rows = [ca.vec(qs[:, 1:] - qs[:, :-1] - h / 2 * trapezoid(vs)), ca.vec(p[:, 1:] - p[:, :-1] - h / 2 * trapezoid(g))]
    least = [np.zeros(2 * n * steps)]
    most = [np.zeros(2 * n * steps)]
    if path is not None:
        nodes = range(steps + 1) if mechanism is arm else range(1, steps)
        for row, low, high in (of for node in nodes for of in path(qs[:, node])):
            rows.append(row)
            least.append([low])
            most.append([high])
    cost = total if effort is None else effort * h / 2 * ca.sum1(ca.sum2(trapezoid(us**2)))
    x = ca.vertcat(ca.vec(qs), ca.vec(vs), ca.vec(us), total)
    options = {"ipopt.print_level": 0, "print_time": False, "ipopt.sb": "yes", "ipopt.tol": 1e-7, "ipopt.max_iter": 1000}
    solver = ca.nlpsol("solver", "ipopt", {"x": x, "f": cost, "g": ca.vertcat(*rows)}, options)
    size = n * (steps + 1)
    low, high = np.full(x.shape[0], -np.inf), np.full(x.shape[0], np.inf)
    low[2 * size : -1], high[2 * size : -1] = -largest, largest
    low[-1], high[-1] = shortest, longest
    fixed = lambda at, value: (low.__setitem__(at, value), high.__setitem__(at, value))
    for i in range(n):
        fixed(i, start[i])
        fixed(size + i, 0.0)
        if end[i] is not FREE:
            fixed(size - n + i, end[i])
        if rests:
            fixed(2 * size - n + i, 0.0)
    change = np.array([0.0 if to is FREE else to - of for of, to in zip(start, end)])
    share = np.linspace(0.0, 1.0, steps + 1)
    states = np.array(start)[:, None] + change[:, None] * share
    random = np.random.default_rng(1)

    def solve(which):
        sines = np.sin(np.pi * np.outer(np.arange(1, 7), share))
        controls = random.uniform(-10.0, 10.0, (k, 6)) @ sines if which else np.zeros((k, steps + 1))
        speeds = np.repeat(change[:, None] / duration, steps + 1, axis=1)
        guess = np.concatenate([states.T.ravel(), speeds.T.ravel(), controls.T.ravel(), [duration]])
        begin = time.perf_counter()
        found = solver(x0=guess, lbx=low, ubx=high, lbg=np.concatenate(least), ubg=np.concatenate(most))
        seconds = time.perf_counter() - begin
        return solver.stats()["success"], float(found["f"]), seconds

    return solve


def row(name, tool, outcomes):
    values = [value for converged, value, _ in outcomes if converged]
    best = min(values, default=float("nan"))
    alike = sum(value <= best * (1 + ALIKE) for value in values)
    seconds = statistics.median(of[2] for of in outcomes)
    print(f"| {name} | {tool} | {len(values)} of {len(outcomes)} | {best:.5g} ({alike}) | {1e3 * seconds:.0f} |", flush=True)


def main(program, starts=20, *names):
    print(versions(["casadi", "numpy"]))
    print("\n| problem | tool | converge | best value (how often) | median time, ms |\n|---|---|---|---|---|")
    for name in names or PROBLEMS:
        with tempfile.TemporaryDirectory() as folder:
            command = [program, "optimise", "--problem", name, "--starts", str(starts), "--out", folder]
            subprocess.run(command, check=True, capture_output=True)
            outcomes = json.loads((Path(folder) / "optimise_starts.json").read_text())
        row(name, "solve", [(of["converged"], of["value"], 1e-3 * of["milliseconds"]) for of in outcomes])
        solve = transcribed(PROBLEMS[name])
        row(name, "IPOPT", [solve(which) for which in range(int(starts))])


if __name__ == "__main__":
    main(*sys.argv[1:])
