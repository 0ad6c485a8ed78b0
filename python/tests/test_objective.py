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


def test_second_derivatives(objective):
    x, weights = objective.x, [0.3, -0.7]
    step = 1e-3 * np.cos(np.arange(len(x)))

    def slope(x):
        return 0.5 * objective(x)[1] + objective.jacobian(x).T @ weights

    change = (8 * (slope(x + step) - slope(x - step)) - (slope(x + 2 * step) - slope(x - 2 * step))) / 12
    hessian = objective.hessian(x, 0.5, weights)
    assert np.allclose(hessian, hessian.T, rtol=1e-12, atol=1e-15) and np.allclose(hessian @ step, change, rtol=1e-8, atol=1e-13)
    assert np.allclose(objective.hessian_product(x, step), objective.hessian(x) @ step, rtol=1e-12, atol=1e-15)
    assert np.allclose(objective.pull_back(x, 0.5, weights), slope(x), rtol=1e-12)


def test_products_are_those_of_j_after_other_sweeps(objective):
    x, direction = objective.x, np.linspace(-1.0, 1.0, len(objective.x))
    product = objective.hessian_product(x, direction)
    assert np.abs(product).max() > 0.0
    for other in (objective.jacobian, objective.outputs, objective.hessian, lambda x: objective.pull_back(x, 0.0, [1.0] * len(objective.outputs(x)))):
        other(x)
        assert objective.hessian_product(x, direction) == pytest.approx(product, rel=1e-12, abs=1e-12 * np.abs(product).max())
        other(x)
        assert objective(x)[1] == pytest.approx(objective.pull_back(x, 1.0, [0.0] * len(objective.outputs(x))))
    assert objective.hessian_product(x + 0.1, direction) != pytest.approx(product)


def test_all_free_quantities_of_minimise():
    system, inputs, force, mass = slider()
    inputs[force] = 0.5 + np.sin(inputs.times)
    free = [ha.free(force, spline=5, scale=2.0), ha.free(mass, logarithm=True), ha.free("duration", logarithm=True)]
    objective = ha.Objective(system, inputs, free)
    problem = ha.Problem(system, inputs, free)
    assert np.array_equal(objective.x, problem.start) and objective.names == problem.names and len(objective.x) == 7
    x, step = objective.x, 1e-3 * np.cos(np.arange(7.0))
    assert objective.inputs(x + 0.1)[mass] == pytest.approx(2.0 * np.exp(0.1)) and objective.inputs(x).times[-1] == pytest.approx(1.0)

    def difference(of):
        return (8 * (of(x + step) - of(x - step)) - (of(x + 2 * step) - of(x - 2 * step))) / 12

    assert objective(x)[1] @ step == pytest.approx(difference(objective.value), rel=1e-8)
    assert objective.jacobian(x) @ step == pytest.approx(difference(objective.outputs), rel=1e-8)
    assert objective.hessian_product(x, step) == pytest.approx(difference(lambda x: objective(x)[1]), rel=1e-7)
    assert objective.hessian(x) @ step == pytest.approx(objective.hessian_product(x, step), rel=1e-12)
    inner = ha.Objective(system, inputs, [ha.step_length(3)])
    assert inner.x.tolist() == [0.05] and inner(inner.x)[1][0] == ha.gradient(system, inputs).steps[2]


def test_scipy_uses_products_with_the_hessian(objective):
    optimize = pytest.importorskip("scipy.optimize")
    system, inputs, force, _ = slider()
    objective = ha.Objective(system, inputs, [force])
    newton = {"jac": True, "hessp": objective.hessian_product, "method": "trust-krylov", "options": {"gtol": 1e-10}}
    found = optimize.minimize(objective, objective.x, **newton)
    # J is a square function of the force: Newton's method needs few iterations.
    assert found.success and found.nit < 10 and np.abs(objective(found.x)[1]).max() < 1e-10


def optimum():
    """An optimum with the outputs equal to zero, by the library, and its problem."""
    system, inputs, force, mass = slider()
    found = ha.minimise(system, inputs, [force, mass], bounds={mass: (1.5, 3.0)}, stationarity=1e-9)
    objective = ha.Objective(system, inputs, [force, mass])
    low, high = np.full(len(objective.x), -np.inf), np.full(len(objective.x), np.inf)
    low[-1], high[-1] = 1.5, 3.0
    assert found.converged and np.abs(found.constraints).max() < 1e-9
    return objective, found, (low, high)


@pytest.mark.parametrize("hessian", ["exact", "limited-memory"])
def test_ipopt_finds_the_same_optimum(hessian):
    cyipopt = pytest.importorskip("cyipopt")
    objective, expected, (low, high) = optimum()
    problem = cyipopt.Problem(len(low), 2, objective.for_ipopt(), low, high, np.zeros(2), np.zeros(2))
    for name, value in {"print_level": 0, "sb": "yes", "tol": 1e-9, "hessian_approximation": hessian}.items():
        problem.add_option(name, value)
    x, info = problem.solve(objective.x)
    assert info["status"] == 0
    assert np.isclose(info["obj_val"], expected.value, rtol=1e-7) and np.allclose(x, expected.x, atol=1e-4)


def test_ipopt_has_the_hessian_of_the_lagrangian(objective):
    pytest.importorskip("cyipopt")
    lower = objective.for_ipopt().hessian(objective.x, [0.3, -0.7], 0.5)
    full = objective.hessian(objective.x, 0.5, [0.3, -0.7])
    assert np.array_equal(lower, [full[i, j] for i in range(len(full)) for j in range(i + 1)])


def test_ipopt_shortens_steps_that_fail(objective):
    cyipopt = pytest.importorskip("cyipopt")
    with pytest.raises(cyipopt.CyIpoptEvaluationError, match="finite"):
        objective.for_ipopt().objective(1e200 + objective.x)


@pytest.mark.parametrize("hessian", ["exact", "limited-memory"])
def test_casadi_finds_the_same_optimum(hessian):
    casadi = pytest.importorskip("casadi")
    objective, expected, (low, high) = optimum()
    function = objective.for_casadi()
    x = casadi.MX.sym("x", len(objective.x))
    value, outputs = function(x)
    options = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-9, "hessian_approximation": hessian}}
    solver = casadi.nlpsol("solver", "ipopt", {"x": x, "f": value, "g": outputs}, options)
    found = solver(x0=objective.x, lbx=low, ubx=high, lbg=0.0, ubg=0.0)
    assert solver.stats()["success"]
    assert np.isclose(float(found["f"]), expected.value, rtol=1e-7) and np.allclose(found["x"].full().ravel(), expected.x, atol=1e-4)


def test_casadi_differentiates(objective):
    casadi = pytest.importorskip("casadi")
    function = objective.for_casadi()
    x = casadi.MX.sym("x", len(objective.x))
    value, outputs = function(2.0 * x)
    total = value**2 + casadi.sum1(casadi.sin(outputs))
    derivatives = casadi.Function("derivatives", [x], [total, casadi.gradient(total, x), casadi.jacobian(outputs, x)])
    found = [of.full() for of in derivatives(objective.x / 2.0)]
    (expected, slope), results, rows = objective(objective.x), objective.outputs(objective.x), objective.jacobian(objective.x)
    assert np.isclose(found[0].item(), expected**2 + np.sin(results).sum(), rtol=1e-14)
    assert np.allclose(found[1].ravel(), 4.0 * expected * slope + 2.0 * rows.T @ np.cos(results), rtol=1e-12)
    assert np.allclose(found[2], 2.0 * rows, rtol=1e-12)
    # Second derivatives are compared with differences of first ones.
    second = casadi.Function("second", [x], casadi.hessian(total, x))
    half, step = objective.x / 2.0, 1e-3 * np.cos(np.arange(len(slope)))
    slopes = [second(half + of * step)[1].full().ravel() for of in (1.0, -1.0, 2.0, -2.0)]
    change = (8 * (slopes[0] - slopes[1]) - (slopes[2] - slopes[3])) / 12
    assert np.allclose(second(half)[0].full() @ step, change, rtol=1e-7, atol=1e-11)


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


def test_mistakes_in_variables():
    system, inputs, force, mass = slider()
    assert np.array_equal(ha.Objective(system, inputs, ["force", "mass"]).x, ha.Objective(system, inputs, [force, mass]).x)
    with pytest.raises(ha.Error, match="force"):
        ha.Objective(system, inputs, [force, mass, "force"])
    with pytest.raises(KeyError, match="forse"):
        ha.Objective(system, inputs, ["forse"])
    with pytest.raises(TypeError, match="can be free"):
        ha.Objective(system, inputs, [force.rate])


def test_casadi_goes_on_after_motions_that_fail(capfd):
    casadi = pytest.importorskip("casadi")
    scene = ha.Scene()
    (x,) = scene.coordinates("block", ["x"], [1.0])
    force = scene.control("force")
    scene.kinetic_energy("motion", 0.5 * x.v**2)
    scene.force("push", {x: force - np.sqrt(x)})  # no motion passes x = 0
    scene.cost("effort", 0.01 * force**2, sum="integral")
    scene.output("end", x - 0.1, sum="terminal")
    system = scene.compile()
    objective = ha.Objective(system, system.at_rest(20, 0.1), [force])
    function = objective.for_casadi()
    failing = np.full(21, -30.0)
    with pytest.raises(ha.MotionError):
        objective(failing)
    assert all(np.isnan(float(of)) for of in function(failing))
    u = casadi.MX.sym("u", 21)
    value, outputs = function(u)
    failed = []

    class Watch(type(objective)):
        def value(self, x):
            try:
                return super().value(x)
            except ha.MotionError:
                failed.append(x)
                raise

    objective.__class__ = Watch
    options = {"print_time": False, "show_eval_warnings": False, "ipopt": {"print_level": 0, "sb": "yes", "hessian_approximation": "limited-memory"}}
    solver = casadi.nlpsol("solver", "ipopt", {"x": u, "f": value, "g": outputs}, options)
    found = solver(x0=np.full(21, 4.0), lbg=0.0, ubg=0.0)
    assert solver.stats()["success"] and failed and abs(float(found["g"])) < 1e-8
    assert "Traceback" not in "".join(capfd.readouterr())
