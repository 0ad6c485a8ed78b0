"""Parts in space, along axes, and at events."""

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from test_paper import assert_same

MASS, LENGTH, INERTIA = 0.8, 0.4, 0.02


def swing(scene, angle, torque):
    scene.motor("motor", angle, torque)
    scene.axis_spring_damper("spring", {angle: 2.0}, stiffness=0.3, free_value=0.1, damping=0.05)
    scene.cost("angle", 0.5 * (angle - 1.0) ** 2, sum="terminal")
    system = scene.compile()
    inputs = system.at_rest(60, 0.02)
    inputs[torque] = np.sin(inputs.times)
    return ha.gradient(system, inputs)


def in_space():
    """A pendulum that turns about the y axis of the ground."""
    scene = ha.Scene()
    scene.gravity(0.0, 0.0, -9.81)
    mass = scene.design("mass", MASS)
    rod = scene.body_in_space("rod", mass, (0.01, INERTIA, 0.01, 0.0, 0.0, 0.0))
    hinge = scene.revolute_in_space("hinge", ha.GROUND.at(0, 0, 1).along((0, 1, 0)), rod.at(0, 0, LENGTH).along((0, 1, 0)))
    return scene, hinge


def test_a_pendulum_in_space_is_that_of_formulas():
    scene, hinge = in_space()
    assert len(hinge) == 0 and isinstance(hinge.angle, ha.Coordinate)
    scene.place(hinge.angle, 0.3)
    found = swing(scene, hinge.angle, scene.control("torque"))

    scene = ha.Scene()
    mass = scene.design("mass", MASS)
    angle = scene.coordinates("pendulum", ["angle"], [0.3]).angle
    scene.kinetic_energy("T", 0.5 * (INERTIA + mass * LENGTH**2) * angle.v**2)
    scene.potential_energy("V", -mass * 9.81 * LENGTH * np.cos(angle))
    expected = swing(scene, angle, scene.control("torque"))
    assert found.value == pytest.approx(expected.value, rel=1e-11)
    assert found.design == pytest.approx(expected.design, rel=1e-9)
    assert found.controls == pytest.approx(expected.controls, rel=1e-9, abs=1e-13)


def test_files_of_parts_in_space():
    scene, hinge = in_space()
    torque = scene.control("torque")
    again = ha.Scene.from_json(scene.to_json())
    assert isinstance(again["rod"], ha.SpaceBody)
    found = swing(again, again["hinge.angle"], again["torque"])
    assert_same(found, swing(scene, hinge.angle, torque))


def test_loops_and_markers():
    scene, hinge = in_space()
    rod = scene["rod"]
    scene.outputs_of_a_marker("tip", rod.at(0, 0, -LENGTH), quantity="position", sum="terminal")
    held = scene.point_on_plane("held", ha.GROUND.at(0, 0, 0).along((1, 0, 0)), rod)
    assert len(held) == 1
    system = scene.compile()
    solver = ha.Solver(system)
    motion = solver.simulate(system.at_rest(10, 0.01))
    assert np.abs(motion[hinge.angle]).max() < 1e-12
    assert solver.outputs() == pytest.approx([0.0, 0.0, 1.0 - 2 * LENGTH], abs=1e-12)


def test_a_ball_that_bounces():
    scene = ha.Scene()
    scene.gravity(0.0, -10.0)
    ball = scene.particle("ball", 1.0, (0.0, 0.8))
    floor = scene.rigid_contact("floor", ha.GROUND.at(0, 0), ball, normal=np.pi / 2)
    landing = scene.find("floor", kind="event")
    scene.impact_at_event(landing, restitution=0.5, equation=floor[0])
    scene.cost("speed", ball.y.v, sum="terminal")
    system = scene.compile()
    inputs = ha.Solver(system).find_phases(system.at_rest(60, 0.01), 4)
    assert [name for name, _ in inputs.events] == ["floor"]
    motion = ha.simulate(system, inputs)
    # It falls for 0.4 s to −4 m/s and rises again with 2 m/s.
    assert motion[ball.y.v][-1] == pytest.approx(2.0 - 10.0 * 0.2, abs=1e-9)
    # v(T) = e w − g (T − t) with w² = v² + 2 g y, t = (v + w)/g: dv(T)/dv = (1 + e) v/w + 1.
    assert ha.gradient(system, inputs)[ball.y.v] == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda s, rod: s.revolute_in_space("h", ha.GROUND.at(0, 0), rod), "`a` must be a marker, such as"),
        (lambda s, rod: s.body_in_space("b", 1.0, (1.0, 2.0)), "`inertia` must have 6 numbers or formulas"),
        (lambda s, rod: s.motor("m", rod, s.control("u")), "`axis` must be a coordinate, or coordinates with factors"),
        (lambda s, rod: s.impact_at_event("e", 0.5, 3), "`equation` must be an equation"),
        (lambda s, rod: s.fixed("weld", rod, s.body_in_space("b", 1.0, np.ones(6))).offset, "there is no coordinate `weld.offset`"),
        (lambda s, rod: (s.revolute_in_space("second", ha.GROUND, rod), s.compile()), "carries"),
        (lambda s, rod: s.outputs_of_a_marker("o", rod, quantity="speed", sum="terminal"), "`quantity` must be one of position"),
    ],
)
def test_mistakes(make, message):
    scene, hinge = in_space()
    with pytest.raises((TypeError, AttributeError, KeyError, ha.SceneError), match=message):
        make(scene, scene["rod"])


def test_markers_that_are_turned():
    """Roll, pitch and yaw are rotations about the fixed axes x, y and z, in this order."""
    roll, pitch, yaw = 0.5, 1.0, 0.7
    scene = ha.Scene()
    body = scene.body_in_space("body", 1.0, (0.1, 0.1, 0.1, 0.0, 0.0, 0.0))
    scene.revolute_in_space("hinge", ha.GROUND.at(0, 0, 0).turned((roll, pitch, yaw)), body)
    for axis in "xyz":
        scene.outputs_of_a_marker(f"axis {axis}", body.at(0, 0, 0), f"{axis} axis", "terminal")
    system = scene.compile()
    solver = ha.Solver(system)
    solver.simulate(system.at_rest(2, 0.01))
    about_x = [[1, 0, 0], [0, np.cos(roll), -np.sin(roll)], [0, np.sin(roll), np.cos(roll)]]
    about_y = [[np.cos(pitch), 0, np.sin(pitch)], [0, 1, 0], [-np.sin(pitch), 0, np.cos(pitch)]]
    about_z = [[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]]
    assert solver.outputs().reshape(3, 3).T == pytest.approx(np.array(about_z) @ about_y @ about_x, abs=1e-14)
