"""Times of J and all of its derivatives for the paper's example, called from Python, in ms: medians of many calls of one solver.

The same from Rust: `cargo run --release --example cart_pendulum -- --links 3 --repeat 2000`, also with `--links 10 --dt 0.01` and `--links 30 --dt 0.01`.
"""

import statistics
import time

import hamiltonian_adjoint as ha


def milliseconds(links: int, dt: float, calls: int = 2000) -> float:
    scene = ha.cart_pendulum(links)
    system = scene.compile()
    inputs = system.at_rest(100, dt)
    inputs.controls[:] = 10.0
    solver = ha.Solver(system)
    times = []
    for _ in range(calls):
        start = time.perf_counter()
        solver.gradient(inputs)
        times.append(time.perf_counter() - start)
    return 1e3 * statistics.median(times)


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
        print(f"{links:3} links: {milliseconds(links, dt):.3f} ms")
    print(f"2,000 own formulas recorded and compiled: {recording():.2f} s")
