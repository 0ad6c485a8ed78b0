"""The paper's example, bit for bit as in Rust."""

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from scenes import PAPER, cart_with_links, pushed


def built_in_rust():
    """The gradient of the example as the Rust library builds it."""
    system = ha.cart_pendulum(3).compile()
    return ha.gradient(system, pushed(system))


def assert_same(a, b):
    assert a.value == b.value
    for part in ("controls", "design", "q", "v", "steps"):
        assert np.array_equal(getattr(a, part), getattr(b, part)), part


@pytest.mark.parametrize("cost", ["formula", "function"])
def test_value_is_that_of_rust(cost):
    scene, force, _ = cart_with_links(cost=cost)
    system = scene.compile()
    assert (system.n, system.m, system.k) == (12, 8, 1)
    assert system.without_programs == []
    gradient = ha.gradient(system, pushed(system))
    assert gradient.value == pytest.approx(PAPER, rel=1e-13)
    assert_same(gradient, built_in_rust())
    assert gradient.controls.shape == (1, 101) and gradient[force].shape == (101,)
    assert gradient.q.shape == gradient.v.shape == (12,) and gradient.steps.shape == (100,)


def test_gradient_is_that_of_differences():
    scene, force, _ = cart_with_links()
    system = scene.compile()
    solver = ha.Solver(system)
    inputs = pushed(system)
    gradient = solver.gradient(inputs)

    def value(change):
        moved = inputs.copy()
        moved[force] += change
        return solver.gradient(moved).value

    # The rounding error of J, some 1e-13, is divided by h.
    h = 1e-2
    difference = (8 * (value(h) - value(-h)) - (value(2 * h) - value(-2 * h))) / (12 * h)
    assert difference == pytest.approx(gradient[force].sum(), rel=1e-8)


def test_all_ways_agree_to_the_last_bit():
    system = cart_with_links()[0].compile()
    inputs = pushed(system)
    solver = ha.Solver(system)
    motion = solver.simulate(inputs)
    first = solver.gradient()
    others = [solver.gradient(inputs), ha.gradient(system, inputs), *ha.gradients(system, [inputs] * 5)]
    others.append(ha.LongSolver(system, bytes=400_000).gradient(inputs))
    for other in others:
        assert_same(other, first)
    assert motion.q[0, -1] == pytest.approx(8.5233060709473052, rel=1e-14)


def test_a_motion_has_the_names_of_its_scene():
    scene, force, angles = cart_with_links()
    system = scene.compile()
    motion = ha.simulate(system, pushed(system))
    assert motion.times[-1] == pytest.approx(2.0, abs=1e-14) and motion.computed == 101
    assert np.array_equal(motion[angles[1]], motion.q[8])
    assert np.array_equal(motion[angles[1].v], motion.v[8])
    assert np.array_equal(motion[force], np.full(101, 10.0))
    assert np.array_equal(motion[scene["hinge 1"][1].sigma], motion.sigma[3])
    assert np.abs(motion.phi_dot).max() < 1e-12
