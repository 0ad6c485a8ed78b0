"""The task, its reference values, and how a peer is timed and reported.

Cart with three hanging links, N = 100 steps of 0.02 s, u = 10 N: J = 1/2 sum (phi_j - pi/2)^2 at the end, dJ/du_i.
"""

import importlib.metadata
import json
import pathlib
import platform
import statistics
import time

import numpy as np

LINKS = 3
STEPS = 100
DT = 0.02
HALF_STEP = DT / 2
FORCE = 10.0

CART_MASS = 0.8
CART_INERTIA = 0.034
LINK_MASS = 0.4
LINK_INERTIA = 0.083
HALF_LENGTH = 0.5
RAIL_FRICTION = 0.5
HINGE_FRICTION = 0.2  # cart and first link
GRAVITY = 9.81
START_ANGLE = -np.pi / 2
TARGET_ANGLE = np.pi / 2

# The paper's discretisation solved in 128-bit floats.
_DATA = pathlib.Path(__file__).resolve().parents[2] / "tests" / "data" / "truth_k3_cr0_const10.json"
REFERENCE = json.loads(_DATA.read_text())
REFERENCE_VALUE = REFERENCE["J"]
REFERENCE_GRADIENT = np.array(REFERENCE["grad"])


class Maximal:
    """(x, y, phi) of the cart and of every link. Phi is linear in x, y, sin phi, cos phi:

    Phi = A q + C cos q + S sin q,  so  Phi_q = A - C diag(sin q) + S diag(cos q).
    """

    n = 3 * (LINKS + 1)
    m = 2 * (LINKS + 1)

    def __init__(self):
        self.mass = np.array([CART_MASS, CART_MASS, CART_INERTIA] + [LINK_MASS, LINK_MASS, LINK_INERTIA] * LINKS)
        self.weight = np.zeros(self.n)
        self.weight[1::3] = -GRAVITY * self.mass[1::3]
        self.damping = np.zeros((self.n, self.n))
        self.damping[0, 0] = RAIL_FRICTION
        self.damping[np.ix_([2, 5], [2, 5])] = HINGE_FRICTION * np.array([[1.0, -1.0], [-1.0, 1.0]])
        self.a, self.c, self.s = (np.zeros((self.m, self.n)) for _ in range(3))
        self.a[0, 1] = self.a[1, 2] = 1.0
        for link in range(1, LINKS + 1):
            row, own, other = 2 * link, 3 * link, 3 * link - 3
            self.a[[row, row + 1], [own, own + 1]] = 1.0
            self.a[[row, row + 1], [other, other + 1]] = -1.0
            # The inner end of this link is at the outer end of the preceding one, or at the cart's centre.
            angles = [own + 2] + ([other + 2] if link > 1 else [])
            self.c[row, angles] = -HALF_LENGTH
            self.s[row + 1, angles] = -HALF_LENGTH
        self.start = np.zeros(self.n)
        for link in range(1, LINKS + 1):
            along = (2 * link - 1) * HALF_LENGTH
            self.start[3 * link : 3 * link + 3] = [0.0, -along, START_ANGLE]
        self.angles = np.arange(5, self.n, 3)


def time_ms(function, budget=2.0):
    """The median time of a call, after one call that is not timed."""
    function()
    times, end = [], time.perf_counter() + budget
    while len(times) < 5 or time.perf_counter() < end:
        start = time.perf_counter()
        function()
        times.append(time.perf_counter() - start)
    return 1e3 * statistics.median(times)


def row(tool, scheme, value_ms, both_ms, value, gradient, remark="", reference=(REFERENCE_VALUE, REFERENCE_GRADIENT)):
    """One line of the table; `reference` is None if another scheme makes the numbers incomparable."""
    errors = ["", ""]
    if reference is not None:
        expected = np.asarray(reference[1])
        gradient = np.asarray(gradient).ravel()[: len(expected)]
        size = np.abs(expected).max()
        errors = [f"{abs(value - reference[0]) / reference[0]:.0e}", f"{np.abs(gradient - expected).max() / size:.0e}"]
    number = lambda x: "" if x is None else f"{x:.3g}"
    cells = [tool, scheme, number(value_ms), number(both_ms), *errors, remark]
    print("| " + " | ".join(cells) + " |", flush=True)


def version(package):
    return importlib.metadata.version(package)


def versions(packages):
    """The versions of Python and of packages."""
    found = []
    for package in packages:
        try:
            found.append(f"{package} {version(package)}")
        except importlib.metadata.PackageNotFoundError:
            found.append(f"{package} not installed")
    return f"Python {platform.python_version()}: " + ", ".join(found)


if __name__ == "__main__":
    print(versions(["numpy", "casadi", "jax", "crocoddyl", "pin"]))
