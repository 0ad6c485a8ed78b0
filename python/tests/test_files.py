"""Files and pickles."""

import concurrent.futures
import copy
import multiprocessing
import pathlib
import pickle

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from scenes import cart_with_links, pushed
from test_paper import assert_same


def own():
    """A scene with formulas of every kind, and names that need care."""
    scene = ha.Scene()
    scene.gravity(0.0, -9.81)
    odd, m = scene.design("t", 0.7), scene.design("the mass [kg]", 2.0)
    pull = scene.control("0")
    arm = scene.coordinates("arm [1]", "φ y", [0.3, 0.0])
    phi, y = arm
    ball = scene.particle("ball", m * odd + np.sqrt(m) / 3, (1.0, 0.0))
    scene.kinetic_energy("T", 0.5 * m * (phi.v**2 + y.v**2) + 0.1 * odd * phi.v * y.v * np.cos(phi))
    scene.potential_energy("V", m * 9.81 * (1 - np.cos(phi)) + ha.t * y * 0.1)
    scene.force("Q", {phi: pull - 0.1 * phi.v, y: ha.where(y.v < 0, -y.v, -2 * y.v)})
    scene.force("drag 1", lambda at: [-at.b[0] * at.v[0]], q=[phi], b=[odd * 2])
    scene.force("drag 2", lambda at: [-at.b[0] * at.v[0]], q=[y], b=[0.3])
    rope = scene.constraint("rope", [(ball.x**2 + ball.y**2 - 1.0) / 2])
    scene.cost("J", rope[0].lam ** 2 * 1e-3 + pull.rate**2 * 1e-3 + phi**2 + y.a**2, sum="integral")
    out = scene.output("end", phi + odd, sum="terminal")
    scene.term(out, "more", y, sum=ha.node(3))
    scene.event("level", y - 0.5 * ha.t)
    return scene


def result(scene):
    system = scene.compile()
    inputs = system.at_rest(20, 0.01)
    inputs.controls[:] = np.sin(inputs.times)
    return ha.gradient(system, inputs)


def test_everything_made_in_python_survives_a_file(tmp_path):
    scene = own()
    expected = result(scene)
    assert '"like": "drag 1"' in scene.to_json()
    scene.save(tmp_path / "scene.json")
    read = ha.Scene.load(tmp_path / "scene.json")
    assert read.to_json() == scene.to_json()
    for again in (read, scene.copy(), pickle.loads(pickle.dumps(scene)), scene.compile().scene):
        assert_same(result(again), expected)


def test_handles_of_a_scene_that_was_read():
    scene = ha.Scene.from_json(own().to_json())
    phi, force, m = scene["arm [1].φ"], scene.find("0"), scene["the mass [kg]"]
    assert isinstance(phi, ha.Coordinate) and isinstance(force, ha.Control) and isinstance(m, ha.Design)
    assert isinstance(scene["ball"], ha.Particle) and isinstance(scene["end"], ha.Output) and isinstance(scene["level"], ha.Event)
    assert isinstance(scene["rope"][0], ha.Equation)
    scene.cost("another", m * phi.v**2 + scene["rope"][0].sigma ** 2, sum="terminal")
    assert result(scene).value > 0
    assert isinstance(ha.cart_pendulum(2)["link 2"], ha.Body)


def test_pickles():
    scene, force, angles = cart_with_links()
    system = scene.compile()
    inputs = pushed(system)
    inputs.assemble(angles[0])
    motion, gradient = ha.simulate(system, inputs), ha.gradient(system, inputs)
    for protocol in (2, pickle.HIGHEST_PROTOCOL):
        read = pickle.loads(pickle.dumps((system, inputs, motion, gradient), protocol))
        assert read[0].coordinates == system.coordinates
        assert read[1] == inputs and read[1].held == (["link 1.φ"], ["link 1.φ"])
        assert np.array_equal(read[2].q, motion.q) and np.array_equal(read[2].sigma, motion.sigma) and read[2].html() == motion.html()
        assert_same(read[3], gradient)
        assert_same(ha.gradient(read[0], read[1]), gradient)
    assert copy.deepcopy(inputs) == inputs
    moved = inputs.copy()
    moved.controls[0, 3] += 1.0
    assert moved != inputs and inputs.controls[0, 3] == 10.0


def test_pickles_of_solvers_and_functions():
    scene, force, angles = cart_with_links()
    system = scene.compile()
    inputs = pushed(system)
    solver = ha.Solver(system, scheme="ESDIRK4", tolerance=1e-11)
    expected = solver.gradient(inputs)
    for again in (pickle.loads(pickle.dumps(solver)), copy.copy(solver)):
        with pytest.raises(ha.MotionError, match="`simulate`"):
            again.gradient()
        assert_same(again.gradient(inputs), expected)
    assert_same(pickle.loads(pickle.dumps(ha.LongSolver(system, 10**6))).gradient(inputs), ha.gradient(system, inputs))
    objective = ha.Objective(system, inputs, [ha.free(force, pieces=4), "duration"], scheme="ESDIRK4")
    again = pickle.loads(pickle.dumps(objective))
    assert again.names == objective.names and np.array_equal(again.x, objective.x)
    assert np.array_equal(again(objective.x + 0.1)[1], objective(objective.x + 0.1)[1])
    assert repr(again) == "<objective of 5 variables>"
    warning = ha._errors.warning_class("GridPhase")("a message")
    assert repr(pickle.loads(pickle.dumps(warning))) == repr(warning)


def test_other_processes_evaluate_an_objective():
    scene, force, _ = cart_with_links()
    system = scene.compile()
    objective = ha.Objective(system, pushed(system), [ha.free(force, pieces=2)])
    points = [objective.x, objective.x - 3.0]
    with concurrent.futures.ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        assert list(pool.map(objective.value, points)) == [objective.value(x) for x in points]


def test_pickles_of_states():
    scene = ha.Scene()
    scene.gravity(0.0, -10.0)
    mass, force = scene.design("mass", 2.0), scene.control("force")
    ball = scene.particle("ball", mass, (0.0, 0.8))
    scene.force("push", {ball.x: force * ha.t})
    floor = scene.event("landing", ball.y)
    stop = scene.constraint("floor", ball.y)
    scene.close_at_event(floor, stop)
    system = scene.compile()
    inputs = system.at_rest(60, 0.01)
    inputs[force] = 3.0
    phases = ha.Solver(system).find_phases(inputs, 8)
    motion = ha.simulate(system, phases)
    at_start, at_end = ha.Mechanics.at_start(system, inputs), ha.Mechanics.at_node(motion, -1)
    assert abs(at_start.accelerations()[0][1]) > 9.0 and abs(at_end.accelerations()[0][1]) < 1e-9
    for at in (at_start, at_end, ha.Mechanics(system, v=[1.0, 2.0]).with_design([3.0]).at_time(0.5)):
        again = pickle.loads(pickle.dumps(at))
        assert np.array_equal(again.q, at.q) and np.array_equal(again.v, at.v) and again.energy == at.energy
        assert all(np.array_equal(of, expected) for of, expected in zip(again.accelerations(), at.accelerations()))


def test_inputs_as_files(tmp_path):
    scene, force, angles = cart_with_links()
    system = scene.compile()
    inputs = pushed(system).assemble(angles[0])
    inputs.t0, inputs[angles[0].v] = 0.5, 0.1
    inputs.save(tmp_path / "inputs.json")
    assert ha.Inputs.load(system, tmp_path / "inputs.json") == inputs
    with pytest.raises(ha.FileError, match="`controls`"):
        ha.Inputs.from_json(system, inputs.to_json().replace("force on the cart", "force"))
    assert ha.Inputs.from_json(system, inputs.to_json().replace('"stages": 1', '"stages": 2')).stages == 2


def test_pages():
    scene, *_ = cart_with_links()
    system = scene.compile()
    motion = ha.simulate(system, pushed(system))
    assert motion.html("A cart").startswith("<!doctype html>") and "A cart" in motion.html("A cart")
    assert motion._repr_html_().startswith("<iframe srcdoc=") and "<script>" not in motion._repr_html_()
    assert motion.svg(1.0).startswith("<svg")
    assert motion.to_csv().splitlines()[0].startswith("t [s],")
    for of, text in [(scene, "parts"), (system, "12 coordinates"), (motion, "101 nodes to t = 2 s"), (pushed(system), "100 steps"), (ha.gradient(system, pushed(system)), "J = 15.18")]:
        assert text in repr(of)
