"""Mechanical quantities at single states."""

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from scenes import cart_with_links, pushed


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
    with pytest.raises(TypeError, match="not of force on the cart"):
        at[force]
    # Both ends of a dead centre: the configuration is singular only for massless links, but a guess may violate the constraints.
    assert np.linalg.norm(ha.Mechanics(system, np.ones(system.n)).phi) > 0.1
