"""Solvers: threads, signals, batches, grids, outputs, second derivatives."""

import signal
import threading
import time

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from scenes import cart_with_links, pushed
from test_paper import assert_same


def long_run(links=12):
    """A system and inputs whose motion takes many seconds."""
    system = cart_with_links(links)[0].compile()
    return system, pushed(system, force=0.1, steps=300_000, dt=1e-4)


# Calls, and how many times as long as a simulation they take at least; a gradient takes longer than its motion.
LONG_CALLS = [
    (ha.simulate, 1),
    (ha.gradient, 2),
    (lambda system, inputs: ha.gradients(system, [inputs] * 4), 2),
    (lambda system, inputs: ha.LongSolver(system, 10**8).gradient(inputs), 2),
    (lambda system, inputs: ha.check_gradient(system, inputs), 2),
    (lambda system, inputs: ha.estimate(system, inputs), 2),
    (lambda system, inputs: ha.Solver(system).adapt(inputs, 1e-12), 1),
    (lambda system, inputs: ha.Solver(system).find_phases(inputs, 10), 1),
]


@pytest.mark.parametrize("compute, times", LONG_CALLS)
def test_control_c_stops_a_long_call(compute, times):
    system, inputs = long_run()
    start = time.monotonic()
    ha.simulate(system, pushed(system, force=0.1, steps=3_000, dt=1e-4))
    # A simulation with a hundred times as many steps.
    least = 100 * times * (time.monotonic() - start)
    threading.Timer(0.3, lambda: signal.raise_signal(signal.SIGINT)).start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        compute(system, inputs)
    assert time.monotonic() - start < 0.3 + 0.5 * least
    # No thread goes on.
    begun = time.process_time()
    time.sleep(0.2)
    assert time.process_time() - begun < 0.1


def test_control_c_stops_the_compilation_of_a_large_scene():
    scene = ha.Scene()
    count = 20_000
    chain = scene.coordinates("chain", [f"x{i}" for i in range(count)])
    for i in range(count):
        scene.kinetic_energy(f"mass {i}", 0.5 * chain[i].v ** 2)
        scene.force(f"spring {i}", {chain[i]: chain[i - 1] - chain[i]})
    start = time.monotonic()
    scene.compile()
    took = time.monotonic() - start
    threading.Timer(0.1 * took, lambda: signal.raise_signal(signal.SIGINT)).start()
    start = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        scene.compile()
    assert time.monotonic() - start < 0.9 * took
    assert len(repr(chain)) < 500 and "and 19980 more" in repr(chain)
    with pytest.raises(AttributeError, match="and 19980 more"):
        chain.y


def test_a_solver_works_after_control_c():
    system, inputs = long_run(3)
    solver = ha.Solver(system)
    threading.Timer(0.2, lambda: signal.raise_signal(signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        solver.gradient(inputs)
    assert 0 < solver.motion.computed < 300_001
    assert_same(solver.gradient(pushed(system)), ha.gradient(system, pushed(system)))


def test_a_solver_refuses_a_second_thread():
    system, inputs = long_run(3)
    inputs = pushed(system, steps=20_000, dt=1e-4)
    solver = ha.Solver(system)
    done = []
    thread = threading.Thread(target=lambda: done.append(solver.gradient(inputs)))
    thread.start()
    deadline, refused = time.monotonic() + 10.0, None
    while refused is None and thread.is_alive() and time.monotonic() < deadline:
        try:
            solver.cost()
        except ha.Error as error:
            refused = str(error) if "another thread" in str(error) else None
    thread.join()
    assert refused is not None and "one solver in each thread" in refused
    assert_same(done[0], ha.gradient(system, inputs))


def test_the_lock_of_the_interpreter_is_released():
    """This thread goes on while another one computes: it is never held up for most of the computation."""
    system, _ = long_run(3)
    inputs = pushed(system, steps=40_000, dt=1e-4)
    solver = ha.Solver(system)
    thread = threading.Thread(target=lambda: solver.gradient(inputs))
    start = last = time.monotonic()
    longest = 0.0
    thread.start()
    while thread.is_alive():
        now = time.monotonic()
        longest, last = max(longest, now - last), now
    assert longest < 0.5 * (time.monotonic() - start)


def test_threads_have_solvers_of_their_own():
    system = cart_with_links()[0].compile()
    expected = ha.gradient(system, pushed(system))
    found = []
    threads = [threading.Thread(target=lambda: found.append(ha.Solver(system).gradient(pushed(system)))) for _ in range(8)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert len(found) == 8
    [assert_same(of, expected) for of in found]


def test_batches():
    system = cart_with_links()[0].compile()
    all = [pushed(system, force) for force in np.linspace(5.0, 12.0, 20)]
    for of, inputs in zip(ha.gradients(system, all), all):
        assert_same(of, ha.gradient(system, inputs))
    assert ha.gradients(system, []) == []


def test_products_with_the_hessian():
    scene, force, _ = cart_with_links()
    system = scene.compile()
    solver, inputs, direction = ha.Solver(system), pushed(system), pushed(system).no_change()
    solver.gradient(inputs)
    direction[force] = np.sin(inputs.times)
    product = solver.hessian_product(direction)[force]
    h = 1e-4
    moved = [inputs.copy() for _ in range(2)]
    for of, sign in zip(moved, (1, -1)):
        of[force] += sign * h * direction[force]
    difference = (solver.gradient(moved[0])[force] - solver.gradient(moved[1])[force]) / (2 * h)
    assert product == pytest.approx(difference, rel=1e-5, abs=1e-7)


def test_grids_starts_and_schemes():
    scene, force, angles = cart_with_links()
    system = scene.compile()
    solver = ha.Solver(system, scheme="ESDIRK5")
    adapted = solver.adapt(pushed(system), 1e-8)
    assert solver.simulate(adapted).q[0, -1] == pytest.approx(8.5244826, abs=1e-3)
    lengths = system.at_rest(np.full(10, 0.1))
    assert lengths.times[-1] == pytest.approx(1.0)
    guess = pushed(system)
    guess[angles[0]] = -1.2
    with pytest.raises(ha.MotionError):
        ha.simulate(system, guess)
    assembled = ha.Solver(system).assemble(guess.assemble(angles[0]))
    assert assembled[angles[0]] == -1.2
    assert np.abs(ha.simulate(system, assembled).phi[:, 0]).max() < 1e-12


def test_reports():
    system = cart_with_links()[0].compile()
    solver = ha.Solver(system)
    solver.gradient(pushed(system))
    assert "Newton iterations" in solver.report() and "gradient:" in solver.report()


def test_events():
    scene = ha.Scene()
    scene.gravity(0.0, -10.0)
    ball = scene.particle("ball", 1.0, (0.0, 0.8))
    landing = scene.event("landing", ball.y)
    scene.cost("speed", ball.y.v, sum=ha.at_event(0))
    system = scene.compile()
    inputs = system.at_rest(50, 0.01)
    inputs.at(landing, 30)
    motion = ha.simulate(system, inputs)
    assert motion.times[30] == pytest.approx(0.4, abs=1e-10)
    gradient = ha.gradient(system, inputs)
    assert gradient.value == pytest.approx(-4.0) and gradient[ball.y] == pytest.approx(-10.0 / 4.0, rel=1e-8)
