"""Expressions: their text, their values and their derivatives."""

import math

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from hamiltonian_adjoint._expression import write
from scenes import differences

X, Y, T = 0.7, 0.4, 0.3


def value_and_slope(formula):
    """A formula of x, y and t at the start of a motion, and its derivatives by x and y, by the adjoint."""
    scene = ha.Scene()
    point = scene.coordinates("point", "x y", start=[X, Y])
    scene.kinetic_energy("motion", 0.5 * (point.x.v**2 + point.y.v**2))
    scene.cost("formula", formula(point.x, point.y, ha.t), sum=ha.node(0))
    inputs = scene.compile().at_rest(2, 0.1)
    inputs.t0 = T
    gradient = ha.gradient(inputs.system, inputs)
    return gradient.value, gradient.q


FORMULAS = {
    "add": lambda x, y, t: x + y + t + 1,
    "subtract": lambda x, y, t: 2 - x - (y - t),
    "multiply": lambda x, y, t: 3 * x * (y * t),
    "divide": lambda x, y, t: 2 / x / (y / t),
    "negative": lambda x, y, t: -(x**2) + -x + +y,
    "negative numbers": lambda x, y, t: -1.5 - x * -2.0 - (y - -0.5) / -3.0,
    "powers": lambda x, y, t: x**3 + x**-2 + y**0.5 + x**2.5 + x**2.0 + x**-0.3 + 1.7**x + x**y,
    "roots": lambda x, y, t: np.sqrt(x) + np.hypot(x, y) + np.square(y) + np.reciprocal(x),
    "logarithms": lambda x, y, t: np.exp(x) + np.expm1(y) + np.log(x) + np.log1p(y),
    "angles": lambda x, y, t: np.sin(x) + np.cos(y) + np.tan(t + x) + np.arcsin(x) + np.arccos(y) + np.arctan(x * y),
    "hyperbolic": lambda x, y, t: np.sinh(x) + np.cosh(y) + np.tanh(x - y),
    "two": lambda x, y, t: np.arctan2(y, x) + np.arctan2(1.0, x) + np.maximum(x, y) + np.minimum(0.5, x) + np.fmax(y, 0.1) + np.fmin(y, 0.1),
    "abs": lambda x, y, t: np.abs(y - x) + abs(y - 1) + np.sign(y - x) * x,
    "where": lambda x, y, t: ha.where(x < y, x * x, y * y) + ha.where(x >= y, x, t) + ha.where(0.5 > y, 1.0, x) + ha.where(y <= x, -1.0, 2.0),
    "clip": lambda x, y, t: np.clip(x, 0.0, 0.5) + x.clip(y, 1.0),
    "scalars": lambda x, y, t: np.float64(2.0) * x + np.int64(3) * y + np.float32(0.5) / x + x / np.array(2.0),
    "arrays": lambda x, y, t: np.array([1.0, 2.0]) @ np.array([x, y]) + np.sum(np.array([x, y]) ** 2) + (np.array([3.0, 4.0]) * x)[1],
    "matrices": lambda x, y, t: (np.array([[1.0, 2.0], [3.0, x]]) @ np.array([x, y]))[1] + np.dot([x, y], [y, x]) + np.cross([x, y, 0.1], [1.0, 2.0, y])[2],
    "object ufuncs": lambda x, y, t: np.sum(np.sin(np.array([x, y])) + np.sqrt(np.array([y, x]))) + np.arctan2(np.array([x]), np.array([y]))[0],
    "arrays of maxima": lambda x, y, t: np.sum(ha.maximum(np.array([x, y]), 0.5) * ha.where(np.array([x < y, x > y]), x, [y, 3.0])) + ha.minimum(x, y),
    "constant": lambda x, y, t: 3.5,
    "shared": lambda x, y, t: (lambda s: s * s + np.sin(s) * s)(x * y + 1),
}


def plain(formula):
    """The formula for numbers."""
    return lambda x: float(formula(np.float64(x[0]), np.float64(x[1]), T))


@pytest.mark.parametrize("name", FORMULAS)
def test_values_and_derivatives(name, monkeypatch):
    formula = FORMULAS[name]
    value, slope = value_and_slope(formula)
    monkeypatch.setattr(ha, "where", lambda condition, a, b: np.where(condition, a, b))
    monkeypatch.setattr(ha, "maximum", np.maximum)
    monkeypatch.setattr(ha, "minimum", np.minimum)
    number = plain(formula)
    assert value == pytest.approx(number([X, Y]), rel=1e-14)
    assert slope == pytest.approx(differences(number, [X, Y], 1e-4), rel=1e-8, abs=1e-9)


def test_deep_and_shared_expressions():
    scene = ha.Scene()
    x = scene.coordinates("point", ["x"], [0.1]).x
    deep = x
    for _ in range(20_000):
        deep = deep * 0.5 + x
    wide = x
    for _ in range(200):
        wide = 0.5 * (wide + wide)  # 2²⁰⁰ terms if it were written out
    parts, _ = write([deep], lambda symbol: "x")
    assert len(parts) == 2 * 20_000 - 1
    scene.kinetic_energy("motion", 0.5 * x.v**2)
    scene.cost("deep", deep - 2 * x + wide, sum=ha.node(0))
    inputs = scene.compile().at_rest(1, 0.1)
    assert ha.simulate(inputs.system, inputs).computed == 2
    assert ha.gradient(inputs.system, inputs).value == pytest.approx(0.1, rel=1e-12)
    del deep, wide


def test_elements_with_other_lists_are_not_alike():
    scene = ha.Scene()
    x, y = scene.coordinates("point", "x y")
    scene.kinetic_energy("x", lambda at: 0.5 * at.v[0] ** 2, q=[x])
    scene.kinetic_energy("y", lambda at: 0.5 * at.v[0] ** 2, q=[y, x])
    scene.kinetic_energy("again", lambda at: 0.5 * at.v[0] ** 2, q=[y])
    scene.force("push", {x: 1.0, y: 1.0})
    text = scene.to_json()
    assert text.count('"like"') == 1 and text.count('"like": "x"') == 1
    system = scene.compile()
    motion = ha.simulate(system, system.at_rest(10, 0.1))
    assert motion[x][-1] == pytest.approx(0.5) and motion[y][-1] == pytest.approx(0.25)


def test_text_of_expressions():
    scene = ha.Scene()
    cart, m = scene.coordinates("cart", ["x"]), scene.design("m", 1.0)
    force = scene.control("force")
    formula = 0.5 * m * cart.x.v**2 + np.sin(cart.x) * (force - 1)
    assert repr(formula) == "((0.5 * m) * (cart.x.v ^ 2)) + (sin(cart.x) * (force - 1))"
    assert repr(ha.where(cart.x < 1, ha.t, force.rate)) == "if(cart.x < 1, t, force.rate)"
    assert repr(cart.x < m) == "cart.x < m"
    assert {cart.x: 1}[scene.find("cart.x")] == 1
    assert cart.x == scene["cart.x"] and cart.x != cart.x.v and hash(cart.x) == hash(scene["cart.x"])


def test_own_parts_are_the_ready_made_ones():
    """A pendulum on a spring by formulas, and by ready-made parts."""

    def results(build):
        scene = ha.Scene()
        scene.gravity(0.0, -9.81)
        mass = scene.design("mass", 0.8)
        torque = scene.control("torque")
        rod = scene.body("rod", mass, mass * 0.1, (0.0, -0.5, -math.pi / 2))
        build(scene, rod, torque)
        scene.effort("effort", torque, 0.01)
        system = scene.compile()
        inputs = pushed_by_sine(system)
        inputs[rod.phi.v], inputs[rod.x.v] = 0.4, 0.2
        gradient = ha.gradient(system, inputs)
        return gradient

    def pushed_by_sine(system):
        inputs = system.at_rest(60, 0.02)
        inputs["torque"] = np.sin(inputs.times)
        return inputs

    def ready(scene, rod, torque):
        scene.revolute("pivot", ha.GROUND.at(0.0, 0.0), rod.at(-0.5, 0.0))
        scene.joint_friction("friction", ha.GROUND, rod, damping=0.3)
        scene.torsional_spring_damper("spring", ha.GROUND, rod, stiffness=2.0, free_angle=-1.0, damping=0.1)
        scene.torque_actuator("motor", ha.GROUND, rod, torque=torque)
        scene.cost("end", 0.5 * (rod.phi - 0.3) ** 2, sum="terminal")

    def own(scene, rod, torque):
        x, y, phi = rod.coordinates
        scene.constraint("pivot", [x - 0.5 * np.cos(phi), y - 0.5 * np.sin(phi)])
        scene.force("friction", {phi: -0.3 * phi.v})
        scene.potential_energy("spring", 0.5 * 2.0 * (phi + 1.0) ** 2)
        scene.force("damper", lambda at: [-at.b[0] * at.v[0] + at.u[0]], q=[phi], u=[torque], b=[0.1])
        scene.cost("end", lambda at: 0.5 * (at.q[0] - at.b[0]) ** 2, sum="terminal", q=[phi], b=[0.3])

    ready, own = results(ready), results(own)
    assert own.value == pytest.approx(ready.value, rel=1e-13)
    for part in ("controls", "design", "q", "v", "steps"):
        expected = getattr(ready, part)
        assert getattr(own, part) == pytest.approx(expected, abs=1e-11 * np.abs(expected).max())


def test_energies_of_a_body_by_formulas():
    """T and V of a body, M from the design variables, against the body of the library."""

    def motion(own):
        scene = ha.Scene()
        mass = scene.design("mass", 0.8)
        force = scene.control("force")
        if own:
            ball = scene.coordinates("ball", "x y")
            x, y = ball
            scene.kinetic_energy("ball", 0.5 * mass * (x.v**2 + y.v**2))
            scene.potential_energy("weight of ball", mass * 9.81 * y)
            scene.force("push", [force * np.cos(ha.t), -0.1 * y.v * abs(y.v)], q=[x, y])
        else:
            scene.gravity(0.0, -9.81)
            x, y = scene.particle("ball", mass)
            scene.force("push", {x: force * np.cos(ha.t), y: -0.1 * y.v * abs(y.v)})
        scene.cost("path", x * y + 1e-3 * (x.a**2 + y.p**2 + x.p_dot + force.rate**2), sum="integral")
        system = scene.compile()
        inputs = system.at_rest(40, 0.02)
        inputs["force"] = np.sin(inputs.times)
        return ha.gradient(system, inputs)

    own, ready = motion(True), motion(False)
    assert own.value == pytest.approx(ready.value, rel=1e-13)
    assert own.design == pytest.approx(ready.design, rel=1e-12)
    assert own.controls == pytest.approx(ready.controls, rel=1e-11, abs=1e-15)


def test_forces_may_read_coordinates_on_which_they_do_not_act():
    def coupled(add):
        scene = ha.Scene()
        x, y, z = scene.coordinates("pair", "x y z", [0.1, 0.2, 0.5])
        for one in (x, y, z):
            scene.kinetic_energy(f"energy of {one.name}", 0.5 * one.v**2)
        add(scene, x, y, z)
        scene.cost("end", x * y + z, sum="terminal")
        system = scene.compile()
        return ha.gradient(system, system.at_rest(20, 0.05))

    whole = coupled(lambda scene, x, y, z: scene.force("pull", {x: y - x + z.v, y: 0.0, z: 0.0}))
    assert coupled(lambda scene, x, y, z: scene.force("pull", {x: y - x + z.v})).value == whole.value
    read = coupled(lambda scene, x, y, z: scene.force("pull", y - x + z.v, q=[x]))
    assert read.value == whole.value and np.array_equal(read.q, whole.q)
    with pytest.raises(ha.SceneError, match="1 formula for 2 coordinates"):
        coupled(lambda scene, x, y, z: scene.force("pull", [y - x], q=[x, y]))


def test_multipliers_in_costs_and_outputs():
    scene = ha.Scene()
    scene.gravity(0.0, -9.81)
    ball = scene.particle("ball", 2.0, (0.0, -1.0))
    rope = scene.distance("rope", ha.GROUND.at(0.0, 0.0), ball, length=1.0)
    tension = scene.output("tension", rope[0].lam, sum="terminal")
    scene.term(tension, "more tension", rope[0].sigma * 0.0 + rope[0].lam, sum=ha.node(0))
    system = scene.compile()
    assert system.outputs == ["tension"] and system.equations == ["rope"]
    solver = ha.Solver(system)
    solver.simulate(system.at_rest(10, 0.01))
    assert abs(solver.outputs()[0]) == pytest.approx(2 * 2.0 * 9.81, rel=1e-9)
    assert len(solver.jacobian()) == 1
