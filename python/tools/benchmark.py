"""Times of J and all of its derivatives, called from Python and from Rust, in ms, and both values of J.

The problems are those of two examples: `cart_pendulum`, a scene of ready-made parts, and `arm`, whose energies, force and costs are formulas of its own,
written here in Python and there in Rust. Each time is the median over several rounds, in which Python and Rust take turns, of the medians of many calls.

`cargo build --release --example cart_pendulum --example arm && python python/tools/benchmark.py`
"""

import json
import statistics
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import hamiltonian_adjoint as ha

EXAMPLES = Path(__file__).parents[2] / "target/release/examples"
ROUNDS = 7
LINKS = 7


def arm() -> ha.Scene:
    """Links of length 1 m with their centres in the middle, in angles from the horizontal."""
    scene = ha.Scene()
    angles = scene.coordinates("arm", [f"{k + 1}" for k in range(LINKS)], start=[0.3 - np.pi / 2] * LINKS)
    mass, inertia = 0.4, 0.083
    energy, height = 0.0, 0.0
    hinge, velocity = 0.0, np.zeros(2)  # the height of the hinge at which the link begins, and its velocity
    for q in angles:
        link = np.array([-np.sin(q) * q.v, np.cos(q) * q.v])
        centre = velocity + link * 0.5
        energy += (mass * np.sum(centre**2) + inertia * q.v**2) * 0.5
        velocity = velocity + link
        height += hinge + np.sin(q) * 0.5
        hinge += np.sin(q)
    scene.kinetic_energy("arm", energy)
    scene.potential_energy("weight", mass * height * 9.81)
    torque = scene.control("torque")
    scene.force("shoulder", {angles[0]: torque - 0.2 * angles[0].v})
    for k, q in enumerate(angles):
        scene.cost(f"link {k + 1}", 0.5 * (q - np.pi / 2) ** 2, sum="terminal")
    return scene


def calls(scene: ha.Scene, steps: int, dt: float) -> Callable[[int], tuple[float, float]]:
    """A function that returns the time of one of many calls, and J."""
    system = scene.compile()
    inputs = system.at_rest(steps, dt)
    inputs.controls[:] = 10.0
    solver = ha.Solver(system)

    def run(repeat: int) -> tuple[float, float]:
        times = []
        for _ in range(repeat):
            start = time.perf_counter()
            gradient = solver.gradient(inputs)
            times.append(time.perf_counter() - start)
        return statistics.median(times), gradient.value

    return run


def from_rust(example: str, repeat: int, arguments: list[str]) -> tuple[float, float]:
    """The same from Rust."""
    command = [EXAMPLES / example, "--repeat", str(repeat), *arguments]
    answer = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    return answer["value_and_gradient_s"], answer["cost"]


def compare(title: str, python: Callable[[int], tuple[float, float]], example: str, *arguments: str) -> None:
    repeat = max(20, int(0.5 / python(20)[0]))
    rounds = [(python(repeat), from_rust(example, repeat, list(arguments))) for _ in range(ROUNDS)]
    here, there = (1e3 * statistics.median(of[side][0] for of in rounds) for side in (0, 1))
    values = [rounds[0][side][1] for side in (0, 1)]
    print(f"{title}: Python {here:.4f}, Rust {there:.4f} ms, {100 * (here / there - 1):+.1f} %; J = {values[0]!r}, {values[1]!r}")


def recording(count: int = 1000) -> float:
    """Seconds to add forces of their own formulas, and to compile them."""
    scene = ha.Scene()
    x = scene.coordinates("chain", [f"x{i}" for i in range(count)])
    start = time.perf_counter()
    for i, one in enumerate(x):
        scene.kinetic_energy(f"mass {i}", 0.5 * (1.0 + i) * one.v**2)
        scene.force(f"drag {i}", {one: -0.1 * one.v - one**3})
    scene.compile()
    return time.perf_counter() - start


if __name__ == "__main__":
    for links, dt in ((3, 0.02), (10, 0.01), (30, 0.01)):
        python = calls(ha.cart_pendulum(links), 100, dt)
        compare(f"cart with {links} links", python, "cart_pendulum", "--links", f"{links}", "--dt", f"{dt}")
    for steps in (30, 100, 1000):
        compare(f"own formulas, {steps} steps", calls(arm(), steps, 0.01), "arm", "--steps", f"{steps}")
    print(f"2,000 own formulas recorded and compiled: {recording():.2f} s")
