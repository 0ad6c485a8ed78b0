"""Derivatives of a rod between two points of two bodies, by hand, for `check::Pipe`.

Phi = (|d|^2 - l^2) / (2 l) with d = r_b + R_b s_b - r_a - R_a s_a and b = [s_a, s_b, l].
"""

import json
import math
import sys


def phi_q(q, b):
    xa, ya, fa, xb, yb, fb = q
    ax, ay, bx, by, length = b

    def arm(angle, x, y):
        c, s = math.cos(angle), math.sin(angle)
        return (c * x - s * y, s * x + c * y)

    ra, rb = arm(fa, ax, ay), arm(fb, bx, by)
    d = (xb + rb[0] - xa - ra[0], yb + rb[1] - ya - ra[1])
    turn_a, turn_b = (-ra[1], ra[0]), (-rb[1], rb[0])
    dot = lambda x, y: x[0] * y[0] + x[1] * y[1]
    row = [-d[0], -d[1], -dot(d, turn_a), d[0], d[1], dot(d, turn_b)]
    return [[x / length for x in row]]


if __name__ == "__main__":
    for line in sys.stdin:
        at = json.loads(line)
        if at["ask"] == "phi_q":
            answer = phi_q(at["q"], at["b"])
        else:
            answer = {"error": "there is no " + at["ask"]}
        print(json.dumps(answer), flush=True)
