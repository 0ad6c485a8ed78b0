"""Mechanical quantities at single states."""

import dataclasses
import pickle

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from scenes import cart_with_links, differences, pushed


def test_a_pendulum_has_its_textbook_accelerations_and_reactions():
    m, length, angle, rate = 1.3, 0.7, -0.4, 2.1
    scene = ha.Scene()
    scene.gravity(0.0, -9.81)
    bob = scene.body("bob", m, 0.2, (length * np.cos(angle), length * np.sin(angle), 0.3))
    rod = scene.distance("rod", ha.GROUND.at(0.0, 0.0), bob.at(0.0, 0.0), length)
    system = scene.compile()
    v = [-length * rate * np.sin(angle), length * rate * np.cos(angle), 0.0]
    at = ha.Mechanics(system, v=v)
    v_dot, lam = at.accelerations()
    turn = -9.81 * np.cos(angle) / length
    expected = length * np.array([-turn * np.sin(angle) - rate**2 * np.cos(angle), turn * np.cos(angle) - rate**2 * np.sin(angle)])
    assert v_dot == pytest.approx([*expected, 0.0], abs=1e-13)
    assert [at[bob.x.a], at[bob.y.a], at[rod[0].lam], at[bob.y], at[bob.x.v]] == [v_dot[0], v_dot[1], lam[0], at.q[1], v[0]]
    pull = m * (length * rate**2 - 9.81 * np.sin(angle))
    assert np.linalg.norm(at.phi_q.T @ lam) == pytest.approx(pull, abs=1e-12)
    assert at.kinetic_energy == pytest.approx(0.5 * m * (length * rate) ** 2) and at.potential_energy == pytest.approx(m * 9.81 * length * np.sin(angle))
    assert at.energy == at.kinetic_energy + at.potential_energy and at.degrees_of_freedom == 2
    assert np.array_equal(at.mass, np.diag([m, m, 0.2])) and at.momenta == pytest.approx(at.mass @ v)
    assert [*at.phi, *at.phi_dot] == pytest.approx([0.0, 0.0], abs=1e-15) and at.phi_q.shape == (1, 3)


def test_nodes_of_motions():
    scene, force, _ = cart_with_links()
    system = scene.compile()
    inputs = pushed(system, steps=20, dt=1e-4)
    motion = ha.simulate(system, inputs, scheme="ESDIRK5")
    v_dot, lam = ha.Mechanics.at_node(motion, 10).accelerations()
    assert v_dot == pytest.approx((motion.v[:, 11] - motion.v[:, 9]) / 2e-4, abs=1e-4)
    assert lam == pytest.approx((motion.sigma[:, 11] - motion.sigma[:, 9]) / 2e-4, abs=1e-4)
    last, first = ha.Mechanics.at_node(motion, -1), ha.Mechanics.at_start(system, inputs)
    assert np.array_equal(last.q, motion.q[:, 20]) and np.array_equal(last.v, motion.v[:, 20])
    # Work of the force on a cart that has just begun to move: P = F v.
    assert first.energy < last.energy
    assert np.array_equal(first.accelerations()[0], ha.Mechanics(system).with_controls([10.0]).accelerations()[0])
    for node in (21, -22):
        with pytest.raises(ha.InputError, match=f"node {node} does not exist.*21 nodes, counted from 0"):
            ha.Mechanics.at_node(motion, node)
    with pytest.raises(TypeError, match="a node must be a whole number, not 0.5"):
        ha.Mechanics.at_node(motion, 0.5)


def test_points_and_other_values_of_the_design():
    scene = ha.Scene()
    length = scene.design("the length", 0.8)
    arm = scene.body("arm", 1.0, 0.1)
    dot = scene.particle("dot", 1.0, (2.0, 3.0))
    system = scene.compile()
    q, v = np.array([0.3, -0.2, 1.1, 2.0, 3.0]), np.array([0.5, 0.1, -2.0, 0.7, 0.0])
    at, tip = ha.Mechanics(system, q, v).with_design([1.2]), arm.at(length * 0.5, 0.1)
    sin, cos = np.sin(1.1), np.cos(1.1)
    assert at.position(tip) == pytest.approx([0.3 + cos * 0.6 - sin * 0.1, -0.2 + sin * 0.6 + cos * 0.1])
    ahead, behind = (ha.Mechanics(system, q + step * v, v).with_design([1.2]).position(tip) for step in (1e-6, -1e-6))
    assert at.velocity(tip) == pytest.approx((ahead - behind) / 2e-6, abs=1e-9)
    assert at.position(dot).tolist() == [2.0, 3.0] and at.velocity(dot).tolist() == [0.7, 0.0]
    assert at.position(ha.GROUND.at(1.0, length)).tolist() == [1.0, 1.2]
    with pytest.raises(ha.SceneError, match="`other` belongs to another scene"):
        at.position(ha.Scene().body("other", 1.0, 1.0).at(0.0, 0.0))
    with pytest.raises(ha.SceneError, match="`width` belongs to another scene"):
        at.position(arm.at(ha.Scene().design("width", 1.0), 0.0))
    with pytest.raises(ha.InputError, match="no body `late`"):
        at.position(scene.body("late", 1.0, 1.0).at(0.0, 0.0))
    with pytest.raises(KeyError, match="the system has no `depth`: it was added to the scene after this system was compiled"):
        at.position(arm.at(scene.design("depth", 1.0), 0.0))
    with pytest.raises(TypeError, match=r"a point such as arm.at\(0.5, 0\)"):
        at.position(arm)


def test_markers_in_space():
    scene = ha.Scene()
    radius = scene.design("radius", 0.2)
    wheel = scene.body_in_space("wheel", 1.0, (0.1, 0.1, 0.1, 0.0, 0.0, 0.0))
    axle = scene.revolute_in_space("axle", ha.GROUND.along((0, 0, 1)), wheel.along((0, 0, 1)))
    scene.motor("motor", axle.angle, scene.control("torque"))
    system = scene.compile()
    at = ha.Mechanics(system, [0.5 * np.pi], [3.0]).with_controls([0.2]).at_time(1.0)
    rim = at.marker(wheel.at(radius, 0.0, 0.0))
    assert rim.position == pytest.approx([0.0, 0.2, 0.0]) and rim.velocity == pytest.approx([-0.6, 0.0, 0.0])
    # Centripetal and tangential; the torque turns with 2 rad/s².
    assert rim.acceleration == pytest.approx([-0.4, -1.8, 0.0]) and rim.angular_velocity == pytest.approx([0.0, 0.0, 3.0])
    assert rim.angular_acceleration == pytest.approx([0.0, 0.0, 2.0])
    # The wheel has turned by a quarter.
    assert rim.axes[0] == pytest.approx([0.0, 1.0, 0.0]) and rim.axes[1] == pytest.approx([-1.0, 0.0, 0.0])
    assert at.marker(wheel.at(0, 0, 0).along((1, 0, 0))).axes[2] == pytest.approx([0.0, 1.0, 0.0])
    toward = at.marker(wheel.at(0, 0, 0).along_and_toward((0, 0, 1), (0, 1, 0)))
    assert toward.axes[0] == pytest.approx([-1.0, 0.0, 0.0])
    assert at.marker(wheel.at(0, 0, 0).turned((0, 0, 0.5 * np.pi))).axes[0] == pytest.approx([-1.0, 0.0, 0.0])
    assert at.marker(wheel).velocity == pytest.approx([0.0, 0.0, 0.0]) and at.marker(ha.GROUND).position.tolist() == [0.0, 0.0, 0.0]
    assert at.marker(ha.GROUND.at(1.0, 2.0, 3.0)).position.tolist() == [1.0, 2.0, 3.0]


def motorised_pendulum():
    """A rod of 2 kg and 0.1 kg m² whose centre is 0.5 m from the hinge, with a motor and damping; it begins horizontal."""
    scene = ha.Scene()
    scene.gravity(0.0, -9.81)
    damping = scene.design("damping", 0.3)
    arm = scene.body("arm", 2.0, 0.1, (0.5, 0.0, 0.0))
    hinge = scene.revolute("hinge", ha.GROUND.at(0.0, 0.0), arm.at(-0.5, 0.0))
    torque = scene.control("torque")
    scene.torque_actuator("motor", ha.GROUND, arm, torque)
    scene.joint_friction("friction", ha.GROUND, arm, damping=damping)
    return scene, arm, hinge, torque


def test_a_linear_model_of_a_pendulum():
    scene, arm, _, torque = motorised_pendulum()
    at = ha.Mechanics(scene.compile(), [0.0, -0.5, -0.5 * np.pi])
    inertia, damping = 0.1 + 2.0 * 0.5**2, 0.3
    for model in (at.linear_model(arm.phi), at.linear_model("arm.φ")):
        assert (model.coordinates, model.states) == (("arm.φ",), ("arm.φ", "arm.φ.v")) and (model.controls, model.designs) == (("torque",), ("damping",))
        assert model.a == pytest.approx(np.array([[0.0, 1.0], [-2.0 * 9.81 * 0.5 / inertia, -damping / inertia]]), abs=1e-13)
        assert model.b == pytest.approx(np.array([[0.0], [1.0 / inertia]]), abs=1e-13) and not model.by_design.any()
        # x = cos φ / 2 and y = sin φ / 2.
        assert model.q_z == pytest.approx(np.array([[0.5, 0.0], [0.0, 0.0], [1.0, 0.0]]), abs=1e-13)
        assert model.v_z == pytest.approx(np.array([[0.0, 0.5], [0.0, 0.0], [0.0, 1.0]]), abs=1e-13)
        decay, frequency = 0.5 * damping / inertia, np.sqrt(9.81 / inertia - (0.5 * damping / inertia) ** 2)
        assert sorted(model.eigenvalues, key=np.imag) == pytest.approx([-decay - 1j * frequency, -decay + 1j * frequency], abs=1e-12)
    # While the rod turns, damping changes its acceleration.
    turning = ha.Mechanics(at.system, at.q, [3.0 * 0.5, 0.0, 3.0]).linear_model(arm.phi)
    assert turning.by_design == pytest.approx(np.array([[0.0], [-3.0 / inertia]]), abs=1e-12)
    assert repr(model) == "<linear model: 2 states, 1 control, 1 design variable>\n  states: arm.φ, arm.φ.v\n  eigenvalues: -0.25 ± 4.036i 1/s"
    with pytest.raises(dataclasses.FrozenInstanceError):
        model.a = model.b
    with pytest.raises(ValueError, match="read-only"):
        model.a[0, 0] = 1.0
    assert np.array_equal(pickle.loads(pickle.dumps(model)).a, model.a)


def hanging_chain():
    """Two links of given masses that hang in gravity; a control pulls the end of the chain to the right."""
    scene = ha.Scene()
    scene.gravity(0.0, -9.81)
    mass, length = scene.design("mass", 0.8), scene.design("length", 0.6)
    pull = scene.control("pull")
    upper = scene.body("upper", mass, 0.02, (0.2, -0.3, -1.0))
    lower = scene.body("lower", 0.5, 0.01, (0.4, -0.9, -1.0))
    hinges = (
        scene.revolute("first", ha.GROUND.at(0.0, 0.0), upper.at(length * -0.5, 0.0)),
        scene.revolute("second", upper.at(length * 0.5, 0.0), lower.at(-0.25, 0.0)),
    )
    scene.force("wind", {lower.x: pull, lower.phi: -0.25 * pull * np.sin(lower.phi)})
    return scene, (upper, lower), hinges, pull


def test_the_equilibrium_of_a_chain_and_its_derivatives():
    scene, (upper, lower), hinges, pull = hanging_chain()
    system = scene.compile()
    guess = ha.Mechanics(system).with_controls([2.0])
    found = guess.equilibrium()
    at = found.state
    assert found.is_stable and not at.v.any() and at[pull] == 2.0 and np.array_equal(at.controls, [2.0])
    assert np.abs(at.phi).max() < 1e-12 and not found.holding.any() and len(found.eigenvalues) == 4
    # Moments about the hinges.
    assert np.tan(at[lower.phi]) == pytest.approx(-0.5 * 0.5 * 9.81 / 2.0)
    assert np.tan(at[upper.phi]) == pytest.approx(-(0.5 * 0.8 + 0.5) * 9.81 / 2.0)
    # All accelerations vanish, and reactions are those of statics.
    v_dot, lam = at.accelerations()
    assert np.abs(v_dot).max() < 1e-11 and found.lam == pytest.approx(lam, abs=1e-11)
    assert sorted(np.abs(found.lam[:2])) == pytest.approx([2.0, 1.3 * 9.81])

    def solved(parameters):
        return ha.Mechanics(system, at.q).with_design(parameters[:2]).with_controls(parameters[2:]).equilibrium()

    parameters = np.array([0.8, 0.6, 2.0])
    for of, rows in (("q", lambda of: of.state.q), ("lam", lambda of: of.lam), ("holding", lambda of: of.holding)):
        by_design, by_controls = getattr(found.by_design, of), getattr(found.by_controls, of)
        numerical = [differences(lambda p: rows(solved(p))[i], parameters) for i in range(len(rows(found)))]
        assert np.hstack([by_design, by_controls]) == pytest.approx(np.array(numerical), abs=2e-9)
    of_design = found.by_design
    assert of_design.names == ("mass", "length") and of_design.coordinates == tuple(system.coordinates) and of_design.equations == tuple(system.equations)
    assert repr(of_design) == "<derivatives of an equilibrium with respect to mass, length: q 6 × 2, lam 4 × 2, holding 6 × 2>"
    shown = repr(found)
    assert shown.startswith(f"<stable equilibrium>\n  q: upper.x = {at[upper.x]:.6g}, ") and "\n  eigenvalues: 0 ± " in shown and "held" not in shown
    copied = pickle.loads(pickle.dumps(found))
    assert np.array_equal(copied.state.q, at.q) and np.array_equal(copied.by_design.q, of_design.q)


def test_held_coordinates_and_stability():
    scene, arm, hinge, torque = motorised_pendulum()
    system = scene.compile()
    horizontal = ha.Mechanics(system).equilibrium("arm.φ")
    # The torque that holds the rod against its weight.
    assert horizontal.holding == pytest.approx([0.0, 0.0, 2.0 * 9.81 * 0.5], abs=1e-12) and horizontal.state[arm.phi] == 0.0
    assert horizontal.by_controls.holding == pytest.approx(np.array([[0.0], [0.0], [-1.0]]), abs=1e-12)
    assert repr(horizontal).endswith("held by forces on arm.φ = 9.81\n  no motion is free") and horizontal.eigenvalues.shape == (0,)
    upright = ha.Mechanics(system, [0.0, 0.5, 0.5 * np.pi])
    assert not upright.equilibrium().is_stable and repr(upright.equilibrium()).startswith("<unstable")
    hanging = upright.stable_equilibrium()
    assert hanging.is_stable and hanging.state[arm.y] == pytest.approx(-0.5, abs=1e-12)
    with pytest.raises(ha.InputError, match="`arm.y` cannot be held"):
        ha.Mechanics(system, [0.4, 0.3, 0.6]).equilibrium(arm.phi, arm.y)
    with pytest.raises(ha.InputError, match="`arm.y` is not independent"):
        ha.Mechanics(system, [0.3, 0.4, np.arctan2(4, 3)]).linear_model(arm.phi, arm.y)


def test_states_without_equilibrium():
    scene, force, _ = cart_with_links(1)
    system = scene.compile()
    at = ha.Mechanics(system, system.initial)
    with pytest.raises(ha.MotionError, match="no force changes if these coordinates move: .*cart.x.*; hold one of them"):
        at.equilibrium()
    assert at.equilibrium("cart.x").holding[0] == pytest.approx(0.0, abs=1e-12)
    with pytest.raises(ha.MotionError, match="no equilibrium was found at t = 0.0 s: a force of 3.000e0 on `(cart|link 1).x` remains"):
        at.with_controls([3.0]).equilibrium()
    with pytest.raises(ha.MotionError, match=r"the state violates .* \(tolerance .*\); use .* `ha.Mechanics.at_start\(system, inputs.assemble\(\)\)`$"):
        ha.Mechanics(system, np.ones(system.n)).linear_model()
    scene = ha.Scene()
    arm = scene.body("arm", 1.0, 0.1)
    scene.revolute("hinge", ha.GROUND.at(0.0, 0.0), arm.at(0.0, 0.0))
    scene.driven_angle("drive", ha.GROUND, arm, ha.constant_speed(0.0, 2.0))
    with pytest.raises(ha.MotionError, match="`drive` depends on time there"):
        ha.Mechanics(scene.compile()).equilibrium()


def test_a_structure_without_degrees_of_freedom():
    scene = ha.Scene()
    scene.gravity(0.0, -10.0)
    beam = scene.body("beam", 2.0, 0.1, (0.5, 0.0, 0.0))
    scene.revolute("pin", ha.GROUND.at(0.0, 0.0), beam.at(-0.5, 0.0))
    scene.distance("strut", ha.GROUND.at(0.0, -1.0), beam.at(0.5, 0.0), np.sqrt(2.0))
    at = ha.Mechanics(scene.compile())
    # Moments about the pin: the strut carries half of the weight at 45°.
    assert at.equilibrium().lam[2] == pytest.approx(-10.0 * np.sqrt(2.0))
    model = at.linear_model()
    assert model.a.shape == (0, 0) and model.b.shape == (0, 0) and model.q_z.shape == (3, 0) and model.states == ()
    assert repr(model) == "<linear model: 0 states, 0 controls, 0 design variables>\n  no motion is free"


def test_inverse_dynamics():
    scene, force, (angle,) = cart_with_links(1)
    system = scene.compile()
    start = ha.Mechanics(system).equilibrium("cart.x").state
    inputs = system.at_rest(1, 0.01)
    inputs.q = start.q
    inputs[angle] += 0.4
    at = ha.Mechanics.at_start(system, inputs.assemble(angle))
    found = at.inverse_dynamics({angle: 1.5}, [force])
    assert found[angle.a] == pytest.approx(1.5, abs=1e-12) and found[force] == found.controls[0] != 0.0 and np.array_equal(found.q, at.q)
    assert at.inverse_dynamics({"link 1.φ": 1.5}, ["force on the cart"])[force] == found[force]
    # A motor that acts on the accelerations of a coordinate that the rail prescribes.
    with pytest.raises(ha.MotionError, match="the control `force on the cart` does not determine the accelerations of `cart.y`"):
        at.inverse_dynamics({"cart.y": 1.0}, [force])
    with pytest.raises(ha.InputError, match="controls of the inverse dynamics"):
        at.inverse_dynamics({angle: 1.0}, [])
    with pytest.raises(ha.InputError, match="the acceleration of `link 1.φ`"):
        at.inverse_dynamics({angle: np.nan}, [force])
    with pytest.raises(TypeError, match="a list, such as .torque."):
        at.inverse_dynamics({angle: 1.0}, force)
    with pytest.raises(TypeError, match="a control or its name is expected, not .*φ"):
        at.inverse_dynamics({angle: 1.0}, [angle])
    with pytest.raises(TypeError, match="such as {arm.phi: 0.0}"):
        at.inverse_dynamics([1.0], [force])


def test_relative_degree():
    scene = ha.Scene()
    carts = [scene.particle(f"cart {k}", 2.0, (float(k), 0.0)) for k in range(2)]
    force = scene.control("force")
    scene.actuator("motor", ha.GROUND.at(0.0, 0.0), carts[0].point(), 0.0, force)
    scene.spring_damper("spring", carts[0].point(), carts[1].point(), 100.0, 1.0, 0.0)
    at = ha.Mechanics(scene.compile())
    behind = carts[1].x
    assert at.relative_degree(carts[0].x, [force]) == 2 and at.relative_degree(behind, ["force"]) == 4
    assert at.relative_degree(carts[1].y, [force]) is None
    with pytest.raises(ha.MotionError, match="order 4 .*index 5.*as splines, with readings"):
        at.inverse_dynamics({behind: 1.0}, [force])
    with pytest.raises(TypeError, match="a list, such as .torque."):
        at.relative_degree(behind, force)


def test_names_of_coordinates():
    scene, _, (angle,) = cart_with_links(1)
    at = ha.Mechanics(scene.compile())
    for call in (at.linear_model, at.equilibrium, at.stable_equilibrium):
        with pytest.raises(ha.InputError, match="no coordinate `cart.z`; did you mean `cart"):
            call("cart.z")
        with pytest.raises(TypeError, match="a coordinate or its name is expected, not .*φ.v"):
            call(angle.v)
        with pytest.raises(ha.SceneError, match="`other.x` belongs to another scene"):
            call(ha.Scene().body("other", 1.0, 1.0).x)


def test_mistakes():
    scene, force, angles = cart_with_links(1)
    system = scene.compile()
    at = ha.Mechanics(system)
    with pytest.raises(ha.InputError, match="q"):
        ha.Mechanics(system, [0.0])
    with pytest.raises(ha.InputError, match="v, entry 0,"):
        ha.Mechanics(system, v=np.full(system.n, np.nan))
    with pytest.raises(ha.InputError, match="its shape is \\(1, 6\\)"):
        ha.Mechanics(system, [np.zeros(system.n)])
    with pytest.raises(ha.InputError, match="controls"):
        at.with_controls([1.0, 2.0])
    with pytest.raises(ha.InputError, match="t"):
        at.at_time(np.inf)
    with pytest.raises(TypeError, match="controls and reactions `rope.0..lam`, not of link 1.φ.p"):
        at[angles[0].p]
    # Both ends of a dead centre: the configuration is singular only for massless links, but a guess may violate the constraints.
    assert np.linalg.norm(ha.Mechanics(system, np.ones(system.n)).phi) > 0.1
