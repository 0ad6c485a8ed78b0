"""Applies scipy's methods to the problems that `compare` serves through a pipe; needs scipy.

python3 optimisers/scipy_compare.py [path of the program `compare`]
"""

import json
import subprocess
import sys
import time

import numpy as np
from scipy.optimize import Bounds, NonlinearConstraint, minimize

PROGRAM = sys.argv[1] if len(sys.argv) > 1 else "target/release/examples/compare"


class Served:
    """A problem behind a pipe; the last answer is cached."""

    def __init__(self, name):
        self.pipe = subprocess.Popen([PROGRAM, "--serve", name], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.head = json.loads(self.pipe.stdout.readline())
        self.x, self.answer, self.count, self.sizes = None, None, 0, {}

    def ask(self, x, key):
        if self.x is None or not np.array_equal(self.x, x):
            self.pipe.stdin.write(json.dumps(list(x)) + "\n")
            self.pipe.stdin.flush()
            self.x, self.answer = np.array(x), json.loads(self.pipe.stdout.readline())
            self.count += 1
        if key in self.answer:
            self.sizes[key] = np.shape(self.answer[key])
            return np.array(self.answer[key])
        # A point without a value is infinitely costly.
        return np.full(self.sizes[key], np.inf if key == "value" else 0.0)


def interval(pairs):
    ends = np.array([[-np.inf if a is None else a, np.inf if b is None else b] for a, b in pairs])
    return ends[:, 0], ends[:, 1]


def solve(name, method, options):
    of = Served(name)
    start, constraints = np.array(of.head["start"]), []
    if of.head["constraints"]:
        least, most = interval(of.head["constraints"])
        c, jacobian = (lambda x: of.ask(x, "constraints")), (lambda x: of.ask(x, "jacobian"))
        constraints = [NonlinearConstraint(c, least, most, jac=jacobian)]
    begin = time.perf_counter()
    found = minimize(
        lambda x: float(of.ask(x, "value")),
        start,
        jac=lambda x: of.ask(x, "gradient"),
        method=method,
        bounds=Bounds(*interval(of.head["bounds"])),
        constraints=constraints,
        options=options,
    )
    milliseconds = 1e3 * (time.perf_counter() - begin)
    violation = 0.0
    if constraints:
        c = of.ask(found.x, "constraints")
        violation = float(np.max(np.maximum(np.maximum(least - c, c - most), 0.0)))
    end = "converged" if found.success else str(found.message)[:60]
    print(f"| {name} | scipy {method} | {found.nit} | {of.count} | {milliseconds:.0f} | {found.fun:.6f} | {violation:.0e} | {end} |")
    of.pipe.stdin.close()


print("| Problem | Method | Iterations | Values with all derivatives | ms | Value | Violation | End |")
print("|---|---|---|---|---|---|---|---|")
solve("paper", "L-BFGS-B", {"maxiter": 2000, "ftol": 1e-16})
for name in ["effort", "rest", "time", "time-rest"]:
    solve(name, "SLSQP", {"maxiter": 500, "ftol": 1e-9})
    solve(name, "trust-constr", {"maxiter": 500, "gtol": 1e-6})
