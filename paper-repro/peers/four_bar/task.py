"""The task of the comparison: a four-bar linkage under gravity with a history of the crank's torque, in SI units.

A = (0, 0) and D = (0.8, 0) are fixed; the crank AB turns about A, the coupler BC connects it with the rocker DC, which turns about D. All rods are
uniform, 1 kg per metre: the mass l and the moment of inertia l^3/12 follow from a length l. The torque on the crank is given at 21 knots and is
linear between them. The motion starts at rest with the crank at 1 rad, in the pose that closes the loop with C above BD, and takes 1 s.

J = 1/2 (angle of the rocker at the end - 2)^2. Wanted: J, dJ/dtorque at the knots, and dJ/d(length of the coupler); the crank's angle at the
start is the same for all lengths, so that the pose at the start depends on the length.
"""

import functools
import json
import os
import pathlib
import statistics
import time

import numpy as np

CRANK, COUPLER, ROCKER, GROUND = 0.2, 0.6, 0.5, 0.8  # m
DENSITY = 1.0  # kg/m
GRAVITY = 9.81  # m/s^2, along -y
START = 1.0  # rad
TARGET = 2.0  # rad
DURATION = 1.0  # s
KNOTS = np.linspace(0.0, DURATION, 21)  # s
TORQUES = 1.3 * np.cos(2 * np.pi * KNOTS)  # N m


def closure(crank, coupler, math=np):
    """Angles of the coupler and the rocker that close the loop; `math` has the functions of the library that differentiates them.

    With r from B to D, the law of cosines gives the angles between r and the coupler, and between -r and the rocker.
    """
    x, y = GROUND - CRANK * math.cos(crank), -CRANK * math.sin(crank)
    square = x * x + y * y
    distance, direction = math.sqrt(square), math.arctan2(y, x)
    at_b = math.arccos((square + coupler**2 - ROCKER**2) / (2 * coupler * distance))
    at_d = math.arccos((square + ROCKER**2 - coupler**2) / (2 * ROCKER * distance))
    return direction + at_b, direction + np.pi - at_d


def cost(rocker):
    """J as a function of the rocker's angle at the end."""
    return 0.5 * (rocker - TARGET) ** 2


def interpolation(times):
    """Linear interpolation as a matrix: the torques at these times are `interpolation(times) @ torques`."""
    return np.array([np.interp(times, KNOTS, knot) for knot in np.eye(len(KNOTS))]).T


def stage_torques(torques, steps):
    """The torques at the beginning, in the middle and at the end of each step."""
    times = np.linspace(0.0, DURATION, 2 * steps + 1)
    at = interpolation(times) @ torques
    return np.column_stack([at[:-1:2], at[1::2], at[2::2]])


def to_knots(by_stage):
    """Derivatives with respect to the torques at the knots, from those with respect to `stage_torques`."""
    at = np.zeros(2 * len(by_stage) + 1)
    at[:-1:2] += by_stage[:, 0]
    at[1::2] += by_stage[:, 1]
    at[2::2] += by_stage[:, 2]
    return at @ interpolation(np.linspace(0.0, DURATION, len(at)))


def middle_torques(torques, steps):
    """The torques in the middle of each step."""
    return _middles(steps) @ torques


def middles_to_knots(by_middle):
    """Derivatives with respect to the torques at the knots, from those with respect to `middle_torques`."""
    return by_middle @ _middles(len(by_middle))


@functools.cache
def _middles(steps):
    return interpolation((np.arange(steps) + 0.5) * DURATION / steps)


REFERENCE = pathlib.Path(__file__).with_name("reference.json")


def main(ways):
    """Measures one library and prints a list of results; `ways`: (scheme, steps, function that returns value and gradient as functions)."""
    print(json.dumps([_measure(*way) for way in ways]))


def _measure(scheme, steps, prepare):
    start = _cpu_time()
    value, gradient = prepare()
    value(TORQUES, COUPLER)
    gradient(TORQUES, COUPLER)
    first = _cpu_time() - start
    times = [_time(function) for function in (value, gradient)]
    J, by_torque, by_length = gradient(TORQUES, COUPLER)
    return {"scheme": scheme, "steps": steps, "value": J, "by_torque": list(map(float, by_torque)), "by_length": by_length,
            "times": times, "preparation": max(first - sum(times), 0.0)}


def _time(function, budget=2.0):
    """Median of the CPU times of calls, s: other programs on the machine prolong the wall time, but hardly the CPU time."""
    times = []
    while len(times) < 3 or sum(times) < budget:
        start = time.process_time()
        function(TORQUES, COUPLER)
        times.append(time.process_time() - start)
    return statistics.median(times)


def _cpu_time():
    """CPU time of this process and of compilers that it has called, s."""
    of = os.times()
    return of.user + of.system + of.children_user + of.children_system
