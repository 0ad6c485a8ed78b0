"""Timing of CasADi functions, interpreted or compiled."""

import shutil
import subprocess

import casadi as ca
import numpy as np

from common import FORCE, GRAVITY, REFERENCE_GRADIENT, REFERENCE_VALUE, STEPS, row, time_ms

PAPER = (REFERENCE_VALUE, REFERENCE_GRADIENT)


def report(tool, scheme, value, both, remark, reference=PAPER):
    controls = ca.DM(np.full((1, STEPS + 1), FORCE))
    j, dj = both(controls)
    times = time_ms(lambda: value(controls)), time_ms(lambda: both(controls))
    row(tool, scheme, *times, float(j), np.array(dj), remark, reference)


def chain(q, v, links, cart=0.0):
    """T - V of rods (mass, half length, moment of inertia) in absolute angles, on a cart if it has a mass; the cart's place is q[0]."""
    first = 1 if cart else 0
    energy = 0.5 * cart * v[0] ** 2
    velocity, height = ca.vertcat(v[0] if cart else 0.0, 0.0), 0.0
    for k, (mass, half, inertia) in enumerate(links, first):
        along = half * ca.vertcat(-ca.sin(q[k]), ca.cos(q[k])) * v[k]
        centre = velocity + along
        energy += 0.5 * mass * ca.dot(centre, centre) + 0.5 * inertia * v[k] ** 2
        energy -= mass * GRAVITY * (height + half * ca.sin(q[k]))
        velocity, height = velocity + 2 * along, height + 2 * half * ca.sin(q[k])
    return energy


def has_compiler():
    return bool(shutil.which("gcc") or shutil.which("g++"))


def compiled(function):
    """The function as C code in a shared library, in the current folder."""
    name = f"{function.name()}_c"
    function.generate(f"{name}.c")
    compiler = shutil.which("gcc") or shutil.which("g++")
    flags = ["-O3", "-march=native", "-shared", "-fPIC"]
    subprocess.run([compiler, *flags, f"{name}.c", "-o", f"{name}.so"], check=True, timeout=900)
    return ca.external(function.name(), f"./{name}.so")
