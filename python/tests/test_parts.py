"""Ready-made parts: their methods, descriptions and results."""

import inspect
import math
import pathlib
import re
import runpy

import hamiltonian_adjoint as ha
import pytest


def test_methods_of_parts_are_up_to_date():
    tools = pathlib.Path(__file__).parent.parent / "tools" / "parts.py"
    parts = runpy.run_path(str(tools))
    assert parts["text"]() == parts["FILE"].read_text(encoding="utf-8"), "run tools/parts.py"
    assert len(parts["core"].kinds()) >= 95


def test_methods_of_parts_explain_their_numbers():
    kinds = dict(ha._hamiltonian_adjoint.kinds())
    numbers = ("a number or formula", "3 numbers or formulas", "6 numbers or formulas", "the name of a control", "the name of a function of time")
    for name, method in inspect.getmembers(ha.Scene.__mro__[1], inspect.isfunction):
        if name.startswith("_"):
            continue
        kind = re.search(r'self._ready\("(.*?)"', inspect.getsource(method))[1]
        wanted = [entry for entry, content, _ in kinds[kind] if content in numbers]
        missing = [entry for entry in wanted if f"`{entry}`" not in method.__doc__]
        assert method.__doc__.startswith(("Adds ", "Draws ", "Lets ", "Makes ")) and not missing, (name, missing)


def test_results_of_parts():
    scene = ha.Scene()
    a, b, ground = scene.body("a", 1.0, 0.1), scene.body("b", 1.0, 0.1), ha.GROUND.at(0.0, 0.0)
    assert len(scene.rigid_contact("floor", ground, a.at(0.0, 0.0), normal=1.57)) == 1
    assert scene.torsional_spring_damper("spring", a, b, stiffness=1.0, free_angle=0.0, damping=0.0) is None
    assert isinstance(scene.contact("ball", ground, a.at(0, 0), 1.57, stiffness=1.0, damping=0.0, friction=0.1, speed=0.1), ha.Event)
    body, other = (scene.body_in_space(name, 1.0, (0.1, 0.1, 0.1, 0.0, 0.0, 0.0)) for name in ("body", "other"))
    hinge = scene.revolute_in_space("hinge", ha.GROUND.at(0, 0, 0), body)
    assert len(hinge) == 0 and hinge.angle.name == "hinge.angle" and len(scene.load_cell("cell", body.at(0, 0, 1), other)) == 6
    tip = scene.outputs_of_a_marker("tip", other.at(0.0, 0.5, 0.0), "position", "terminal")
    turn = scene.rotation_error("turn", other, ha.GROUND.at(0, 0, 0), ha.node(0))
    system = scene.compile()
    assert system.outputs == [output.name for output in (*tip, *turn)] and scene["tip x"].name == tip[0].name
    solver = ha.Solver(system)
    solver.simulate(system.at_rest(5, 0.01))
    assert solver.outputs() == pytest.approx([0.0, 0.5, 1.0, 0.0, 0.0, 0.0], abs=1e-12)


GROUND, ORIGIN = ha.GROUND, ha.GROUND.at(0.0, 0.0)
NORMAL = 1000 * 0.01**1.5 * (1 + 0.5 * 0.2)
# How a part is added to a body of 2 kg and 0.5 kg m², where this is and how it moves, and the force along x and y and the torque, as `part_texts.py` states them.
LAWS = {
    "spring_damper": (lambda s, b: s.spring_damper("f", ORIGIN, b.at(0, 0), 10.0, 0.5, 2.0), (1, 0, 0), (0.1, 0, 0), (-10 * 0.5 - 2 * 0.1, 0, 0)),
    "torsional_spring_damper": (lambda s, b: s.torsional_spring_damper("f", GROUND, b, 3.0, 0.2, 0.4), (0, 0, 0.5), (0, 0, 0.1), (0, 0, -3 * 0.3 - 0.4 * 0.1)),
    "joint_friction": (lambda s, b: s.joint_friction("f", GROUND, b, 3.0), (0, 0, 0), (0, 0, 0.1), (0, 0, -3 * 0.1)),
    "sliding_friction": (lambda s, b: s.sliding_friction("f", ORIGIN, b.at(0, 0), 0.0, 3.0), (0, 0, 0), (0.1, 0.2, 0), (-3 * 0.1, 0, 0)),
    "bushing": (lambda s, b: s.bushing("f", ORIGIN, b.at(0, 0), 1, 2, 3, 0.4, 0.5, 0.6), (1, 1, 0.1), (0.1, 0.2, 0.3), (-1 - 0.04, -2 - 0.1, -3 * 0.1 - 0.18)),
    "coulomb_friction": (lambda s, b: s.coulomb_friction("f", GROUND, b, 3.0, 0.2), (0, 0, 0), (0, 0, 0.1), (0, 0, -3 * math.tanh(0.5))),
    "coulomb_sliding_friction": (lambda s, b: s.coulomb_sliding_friction("f", ORIGIN, b.at(0, 0), 0, 3, 0.2), (0, 0, 0), (0.1, 0, 0), (-3 * math.tanh(0.5), 0, 0)),
    "end_stop": (lambda s, b: s.end_stop("f", GROUND, b, -1, 0.3, 100, 0.5, 0.0), (0, 0, 0.5), (0, 0, 0.1), (0, 0, -100 * 0.2 * (1 + 0.5 * 0.1))),
    "sliding_end_stop": (lambda s, b: s.sliding_end_stop("f", ORIGIN, b.at(0, 0), 0, -1, 0.3, 100, 0.5, 0.0), (0.5, 0, 0), (0.1, 0, 0), (-100 * 0.2 * 1.05, 0, 0)),
    "contact": (
        lambda s, b: s.contact("f", ORIGIN, b.at(0, 0), math.pi / 2, stiffness=1000, damping=0.5, friction=0.3, speed=0.2),
        (0, -0.01, 0),
        (0.1, -0.2, 0),
        (-0.3 * NORMAL * math.tanh(0.5), NORMAL, 0),
    ),
    "axis_spring_damper": (lambda s, b: s.axis_spring_damper("f", b.x, 3.0, 0.2, 0.4), (1, 0, 0), (0.1, 0, 0), (-3 * 0.8 - 0.4 * 0.1, 0, 0)),
    "axis_coulomb_friction": (lambda s, b: s.axis_coulomb_friction("f", b.phi, 3.0, 0.2), (0, 0, 0), (0, 0, 0.1), (0, 0, -3 * math.tanh(0.5))),
    "axis_end_stop": (lambda s, b: s.axis_end_stop("f", {b.x: 2}, -1, 0.3, 100, 0.5, 0.0), (0.5, 0, 0), (0.1, 0, 0), (-2 * 100 * 0.7 * (1 + 0.5 * 0.2), 0, 0)),
    "actuator": (lambda s, b: s.actuator("f", ORIGIN, b.at(0, 0), 0.0, s.control("u")), (0, 0, 0), (0, 0, 0), (3, 0, 0)),
    "torque_actuator": (lambda s, b: s.torque_actuator("f", GROUND, b, s.control("u")), (0, 0, 0), (0, 0, 0), (0, 0, 3)),
    "two_point_actuator": (lambda s, b: s.two_point_actuator("f", ORIGIN, b.at(0, 0), s.control("u")), (0, 1, 0), (0, 0, 0), (0, 3, 0)),
}


@pytest.mark.parametrize("name", LAWS)
def test_laws(name):
    add, place, velocity, forces = LAWS[name]
    scene = ha.Scene()
    body = scene.body("body", 2.0, 0.5, place)
    add(scene, body)
    system = scene.compile()
    inputs = system.at_rest(2, 0.01)
    inputs.v, inputs.controls[:] = velocity, 3.0
    accelerations, _ = ha.Mechanics.at_start(system, inputs).accelerations()
    assert accelerations * [2.0, 2.0, 0.5] == pytest.approx(forces, rel=1e-12, abs=1e-12)
