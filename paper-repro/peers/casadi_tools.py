"""Timing of CasADi functions, interpreted or compiled."""

import shutil
import subprocess

import casadi as ca
import numpy as np

from common import FORCE, REFERENCE_GRADIENT, REFERENCE_VALUE, STEPS, row, time_ms

PAPER = (REFERENCE_VALUE, REFERENCE_GRADIENT)


def report(tool, scheme, value, both, remark, reference=PAPER):
    controls = ca.DM(np.full((1, STEPS + 1), FORCE))
    j, dj = both(controls)
    times = time_ms(lambda: value(controls)), time_ms(lambda: both(controls))
    row(tool, scheme, *times, float(j), np.array(dj), remark, reference)


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
