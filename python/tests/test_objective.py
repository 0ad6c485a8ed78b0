"""J and outputs as functions of an array, in other libraries."""

import numpy as np
import pytest

import hamiltonian_adjoint as ha


def slider():
    """A mass that is pushed, with its place and speed at the end as outputs."""
    scene = ha.Scene()
    (x,) = scene.coordinates("cart", ["x"])
    mass = scene.design("mass", 2.0)
    force = scene.control("force")
    scene.kinetic_energy("motion", 0.5 * mass * x.v**2)
    scene.force("push", {x: force - 0.1 * x.v})
    scene.cost("miss", 10.0 * (x - 1.0) ** 2 + x.v**2, sum="terminal")
    scene.cost("effort", 0.1 * force**2, sum="integral")
    scene.output("place", x - 1.0, sum="terminal")
    scene.output("speed", 2.0 * x.v, sum="terminal")
    system = scene.compile()
    inputs = system.at_rest(20, 0.05)
    inputs[force] = 0.5
    return system, inputs, force, mass


@pytest.fixture
def objective():
    system, inputs, force, mass = slider()
    return ha.Objective(system, inputs, [force, mass])


def test_values_and_derivatives_are_those_of_the_solver(objective):
    system, inputs, force, mass = slider()
    gradient = ha.gradient(system, inputs)
    value, slope = objective(objective.x)
    assert value == gradient.value and np.isclose(objective.value(objective.x), value, rtol=1e-14)
    assert np.array_equal(slope, [*gradient[force], gradient[mass]])
    step = 1e-6 * np.cos(np.arange(len(slope)))
    change = (objective.outputs(objective.x + step) - objective.outputs(objective.x - step)) / 2
    assert np.allclose(objective.jacobian(objective.x) @ step, change, rtol=1e-8)
    with pytest.raises(ValueError, match="the free inputs have"):
        objective([1.0])


def test_scipy_minimises(objective):
    optimize = pytest.importorskip("scipy.optimize")
    system, inputs, force, _ = slider()
    objective = ha.Objective(system, inputs, [force])
    found = optimize.minimize(objective, objective.x, jac=True, method="L-BFGS-B", options={"ftol": 1e-15, "gtol": 1e-9})
    value, slope = objective(found.x)
    assert found.success and np.isclose(value, found.fun, rtol=1e-14) and np.abs(slope).max() < 1e-4
    # J is a square function of the force: a Newton step from the optimum does not change it.
    direction = inputs.no_change()
    direction[force] = 1.0
    solver = ha.Solver(system)
    solver.gradient(objective.inputs(found.x))
    curvature = solver.hessian_product(direction)[force].sum()
    assert curvature > 0.0 and slope.sum() ** 2 / curvature < 1e-8 * value


def test_scipy_fits_outputs():
    optimize = pytest.importorskip("scipy.optimize")
    system, inputs, force, _ = slider()
    objective = ha.Objective(system, inputs, [force])
    found = optimize.least_squares(objective.outputs, objective.x, objective.jacobian, gtol=1e-14)
    assert found.success and np.abs(objective.outputs(found.x)).max() < 1e-6


def test_jax_differentiates(objective):
    jax = pytest.importorskip("jax")
    jax.config.update("jax_enable_x64", False)
    with pytest.raises(TypeError, match="jax_enable_x64"):
        objective.for_jax()
    jax.config.update("jax_enable_x64", True)
    function = objective.for_jax()
    value, slope = jax.jit(jax.value_and_grad(lambda x: function(x * 2.0) ** 2))(objective.x / 2.0)
    expected, by_x = objective(objective.x)
    assert np.isclose(value, expected**2, rtol=1e-14) and np.allclose(slope, 4.0 * expected * by_x, rtol=1e-13)


def test_torch_differentiates(objective):
    torch = pytest.importorskip("torch")
    x = torch.tensor(objective.x / 2.0, dtype=torch.float64, requires_grad=True)
    value = objective.for_torch()(x * 2.0) ** 2
    value.backward()
    expected, by_x = objective(objective.x)
    assert np.isclose(value.item(), expected**2, rtol=1e-14) and np.allclose(x.grad.numpy(), 4.0 * expected * by_x, rtol=1e-13)
