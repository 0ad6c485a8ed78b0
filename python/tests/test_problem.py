"""Problems with several starts, in segments, and solved by way of others."""

import pickle
import signal
import threading

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from scenes import block_on_a_spring, cart_with_links, pushed
from test_optimise import block


def swing(duration=1.0, steps=40):
    """A cart with one link and little effort; its end states are outputs."""
    scene, force, (angle,) = cart_with_links(1, cost="none")
    rail = scene["cart.x"]
    scene.effort("effort", force, 1e-4)
    ends = {q: scene.end_state(q) for q in (rail, angle)}
    system = scene.compile()
    return force, rail, angle, ends, system, system.at_rest(steps, duration / steps)


def test_a_problem_is_a_statement():
    x, force, mass, position, speed, system, inputs = block()
    problem = ha.Problem(system, inputs, [force], constraints={position: 1.0, speed: 0.0}, bounds={force: (-20.0, 20.0)})
    inputs[force] = 7.0
    assert np.array_equal(problem.start, np.zeros(51)) and problem.names[3] == "force [3]" and repr(problem) == "<Problem of 51 variables>"
    found = problem.minimise()
    same = ha.minimise(system, system.at_rest(50, 0.02), [force], constraints={position: 1.0, speed: 0.0}, bounds={force: (-20.0, 20.0)})
    assert found.value == same.value and np.array_equal(found.x, same.x)
    again = problem.minimise(start=found.x)
    assert again.converged and again.iterations < found.iterations
    assert pickle.loads(pickle.dumps(problem)).minimise().value == found.value
    with pytest.raises(ha.InputError, match="variables of the start"):
        problem.minimise(start=[1.0])
    with pytest.raises(TypeError, match="no option `iteration`; options of the methods are iterations, target"):
        problem.minimise(iteration=3)


def test_many_starts():
    scene, force, (angle,) = cart_with_links(1)
    system = scene.compile()
    problem = ha.Problem(system, system.at_rest(40, 0.02), [force])
    starts = [np.full(41, of) for of in (-10.0, 5.0, 20.0, 0.0, 1.0)]
    found = problem.multi_start(starts, target=1e-10)
    alone = [problem.minimise(start=start, target=1e-10) for start in starts]
    assert [(of.value, of.iterations) for of in found] == [(of.value, of.iterations) for of in alone]
    best = ha.lowest(found)
    assert best is not None and best.value == min(of.value for of in found) < 1e-10
    assert ha.lowest(found, violation=-1.0) is None and problem.multi_start([]) == []
    with pytest.raises(ha.Error, match="start"):
        problem.multi_start([starts[0], starts[0] * np.nan])


def test_least_squares_from_many_starts():
    scene, x, stiffness = block_on_a_spring()
    times = np.linspace(0.1, 5.0, 50)
    values = np.cos(2.0 * times) + 0.01 * np.random.default_rng(3).normal(size=50)
    scene.readings("x", x, times, values, deviation=0.01, steps=500, dt=0.01)
    system = scene.compile()
    problem = ha.Problem(system, system.at_rest(500, 0.01), [ha.free(stiffness, within=(0.1, 100.0))])
    found = problem.multi_start([[20.0], [3.5], [60.0]], "Levenberg-Marquardt")
    best = ha.lowest(found, np.inf)
    # The others are local minima.
    assert best is found[1] and best.x[0] == pytest.approx(4.0, abs=0.01) and best.chi_squared < 100 < found[2].chi_squared


def test_ctrl_c_stops_all_starts():
    scene, force, _ = cart_with_links()
    system = scene.compile()
    problem = ha.Problem(system, pushed(system, steps=3000, dt=2.0 / 3000), [force])
    threading.Timer(0.2, lambda: signal.raise_signal(signal.SIGINT)).start()
    # Without an end if they are not stopped.
    with pytest.raises(KeyboardInterrupt):
        problem.multi_start([np.full(3001, of) for of in np.linspace(5.0, 10.0, 50)], "L-BFGS", stationarity=0.0, iterations=10**9)
    with pytest.raises(KeyboardInterrupt):
        threading.Timer(0.2, lambda: signal.raise_signal(signal.SIGINT)).start()
        problem.homotopy(lambda inputs, s: None, stationarity=0.0, iterations=10**9)


@pytest.mark.filterwarnings("ignore::hamiltonian_adjoint.MotionWarning")
def test_other_threads_run_during_many_starts():
    scene, force, _ = cart_with_links()
    system = scene.compile()
    problem = ha.Problem(system, pushed(system), [force])
    thread = threading.Thread(target=problem.multi_start, args=([np.full(101, of) for of in (4.0, 8.0, 10.0, 12.0)], "L-BFGS"))
    thread.start()
    # This thread needs the lock of the interpreter.
    while thread.is_alive():
        ha.gradient(system, pushed(system))
    thread.join()


def test_a_homotopy():
    # From 2.5 s to 2 s, as in the guide to optimisation.
    force, rail, angle, ends, system, inputs = swing(2.0, 100)
    upright = {ends[angle][0]: np.pi / 2, ends[angle][1]: 0.0, ends[rail][0]: 0.0, ends[rail][1]: 0.0}
    problem = ha.Problem(system, inputs, [force], constraints=upright)
    seen, iterates = [], []

    def shorter(inputs, s):
        seen.append(s)
        inputs.steps[:] = (2.5 - 0.5 * s) / 100

    found = problem.homotopy(shorter, stationarity=1e-5, callback=lambda iterate, x: iterates.append(iterate.value))
    assert found.converged and found.violation < 1e-9
    assert seen[0] == 0.0 and seen[-1] == 1.0 and sorted(set(seen)) == list(dict.fromkeys(seen)) and len(iterates) >= found.iterations
    assert found.inputs.times[-1] == pytest.approx(2.0) and ha.simulate(system, found.inputs)[angle][-1] == pytest.approx(np.pi / 2, abs=1e-8)


@pytest.mark.filterwarnings("ignore::hamiltonian_adjoint.MotionWarning")
def test_exceptions_during_a_homotopy():
    force, rail, angle, ends, system, inputs = swing()
    problem = ha.Problem(system, inputs, [force], constraints={ends[angle][0]: -1.5})
    calls = []

    def fails(inputs, s):
        calls.append(s)
        if s > 0.0:
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        problem.homotopy(fails)
    assert len(calls) == 2 and calls[0] == 0.0

    def longer(inputs, s):
        inputs.steps = np.full(50, 0.02)
        inputs.controls = np.zeros((1, 51))

    with pytest.raises(ha.InputError, match="50|51"):
        problem.homotopy(longer)
    # A function may use the library itself.
    found = problem.homotopy(lambda inputs, s: ha.gradient(system, inputs) and problem.multi_start([problem.start], iterations=1) and None, stationarity=1e-4)
    assert found.converged


def test_multiple_shooting():
    force, rail, angle, ends, system, inputs = swing()
    turn = -np.pi / 2 + np.pi * np.arange(41) / 40
    problem = ha.MultipleShooting(
        system, inputs, [force], [rail, angle], 4, guess={angle: turn, angle.v: np.pi}, constraints={ends[angle][0]: np.pi / 2}, bounds={force: (-80.0, 80.0)}
    )
    assert len(problem.start) == 41 + 3 * 4 and problem.names[41:43] == ["cart.x at node 10", "rate of cart.x at node 10"]
    assert problem.start[43:45] == pytest.approx([turn[10], np.pi]) and not problem.start[41:43].any()
    found = problem.minimise(stationarity=1e-5)
    assert found.converged and found.violation < 1e-9 and np.abs(found.inputs.controls).max() <= 80.0
    by_stages = problem.minimise(method="stages", stationarity=1e-6)
    assert by_stages.converged and by_stages.value == pytest.approx(found.value, rel=1e-6)
    # Any independent coordinates are states, here one without an end state.
    place = angle.scene["link 1.x"]
    guess = {place: 0.5 * np.cos(turn), angle: turn, place.v: -0.5 * np.pi * np.sin(turn), angle.v: np.pi}
    others = ha.MultipleShooting(
        system, inputs, [force], [place, angle], 4, guess=guess, constraints={ends[angle][0]: np.pi / 2}, bounds={force: (-80.0, 80.0)}
    )
    assert others.names[41] == "link 1.x at node 10"
    assert others.minimise(method="stages", stationarity=1e-6).value == pytest.approx(found.value, rel=1e-6)
    with pytest.raises(ha.InputError, match="state the problem as a MultipleShooting"):
        ha.minimise(system, inputs, [force], method="stages")
    # A single motion differs by the error of the scheme.
    single = ha.Problem(system, found.inputs, [force], constraints={ends[angle][0]: np.pi / 2}).minimise(stationarity=1e-5)
    assert single.converged and single.value == pytest.approx(found.value, rel=0.02)
    many = problem.multi_start([problem.start, found.x], stationarity=1e-5)
    assert many[0].value == found.value and many[1].iterations < found.iterations
    assert pickle.loads(pickle.dumps(problem)).minimise(stationarity=1e-5).value == found.value


def test_outputs_in_the_cost_of_segments():
    force, rail, angle, ends, system, inputs = swing()
    # The angle at the end is as small as the bounds permit, the cart moves to the right.
    problem = ha.MultipleShooting(system, inputs, [force], [rail, angle], 2, costs=[ends[angle][0]], bounds={force: (-5.0, 5.0)})
    found = problem.minimise(stationarity=1e-5)
    assert found.converged and ha.simulate(system, found.inputs)[angle][-1] < -np.pi / 2 - 0.1


@pytest.mark.parametrize(
    "keywords, kind, message",
    [
        ({"states": ["cart.X"]}, ha.InputError, "no coordinate `cart.X`; did you mean `cart.x`?"),
        ({"scheme": "ESDIRK4"}, TypeError, r"`scheme` is a setting of the solver: write settings=\{'scheme': …\}"),
        ({"states": ["cart.x"]}, ha.InputError, "at least the number of degrees of freedom"),
        ({"segments": 0}, ha.InputError, "number of segments"),
        ({"guess": {"cart.x": [1.0, 2.0]}}, ha.InputError, r"the shape \(2,\); a number or 41 values"),
        ({"guess": {"cart.x": np.nan}}, ha.InputError, "cart.x"),
        ({"guess": {"force on the cart": 1.0}}, TypeError, "a guess has coordinates and velocities"),
        ({"costs": ["height"]}, ha.InputError, "no output `height`"),
        ({"free": ["duration"], "segments": 2, "settings": {"max_halvings": 0}}, None, ""),
    ],
)
def test_mistakes(keywords, kind, message):
    force, rail, angle, ends, system, inputs = swing()
    stated = {"free": [force], "states": [rail, angle], "segments": 4, **keywords}
    if kind is None:
        assert len(ha.MultipleShooting(system, inputs, **stated).start) == 1 + 4
        return
    with pytest.raises(kind, match=message):
        ha.MultipleShooting(system, inputs, **stated).minimise()


def test_controls_on_knots_in_segments():
    force, rail, angle, ends, system, inputs = swing()
    constraints = {ends[angle][0]: -1.2}
    problem = ha.MultipleShooting(system, inputs, [ha.free(force, spline=8)], [rail, angle], 4, constraints=constraints)
    assert len(problem.start) == 8 + 3 * 4
    found = problem.minimise("stages")
    single = ha.Problem(system, inputs, [ha.free(force, spline=8)], constraints=constraints).minimise()
    assert found.converged and single.converged and found.value == pytest.approx(single.value, rel=0.02)


def test_single_step_lengths_are_not_divided():
    force, rail, angle, ends, system, inputs = swing()
    problem = ha.MultipleShooting(system, inputs, [force, ha.step_length(2)], [rail, angle], 4)
    with pytest.raises(ha.OptimiseError, match="`length of step 2`: step lengths can be free only through their sum"):
        problem.minimise()
    assert repr(problem).startswith("<MultipleShooting that cannot be solved: ") and "through their sum" in repr(problem)


def test_trials():
    """Two experiments with different starts determine a stiffness and a damping."""

    def experiment(start, seed):
        scene = ha.Scene()
        x = scene.coordinates("block", ["x"], [start]).x
        stiffness, damping = scene.design("stiffness", 3.0), scene.design("damping", 0.5)
        scene.kinetic_energy("motion", 0.5 * x.v**2)
        scene.potential_energy("spring", 0.5 * stiffness * x**2)
        scene.force("damper", {x: -damping * x.v})
        times = np.linspace(0.1, 3.0, 30)
        # ẍ + 2 δ ẋ + 4 x = 0, δ = 0.1, from rest
        delta, omega = 0.1, np.sqrt(4.0 - 0.01)
        truth = start * np.exp(-delta * times) * (np.cos(omega * times) + delta / omega * np.sin(omega * times))
        values = truth + 0.01 * np.random.default_rng(seed).normal(size=30)
        scene.readings("x", x, times, values, deviation=0.01, steps=300, dt=0.01)
        system = scene.compile()
        return ha.Problem(system, system.at_rest(300, 0.01), [stiffness, damping])

    problems = [experiment(1.0, 1), experiment(-2.0, 2)]
    both = ha.Trials(problems)
    assert both.names == ["stiffness", "damping"] and "2 variables" in repr(both)
    found = both.minimise("Levenberg-Marquardt")
    alone = [problem.minimise("Levenberg-Marquardt") for problem in problems]
    assert found.converged and found.degrees_of_freedom == 58 and len(found.trials) == 2 and found.inputs is found.trials[0]
    assert [of.q[0] for of in found.trials] == [1.0, -2.0] and np.array_equal(found.trials[0].design, found.trials[1].design)
    assert (np.abs(found.inputs.design - [4.0, 0.2]) < 4 * found.standard_errors).all()
    assert (found.standard_errors < np.array([of.standard_errors for of in alone]).min(axis=0) * 1.2).all()
    assert both.multi_start([found.x], "Levenberg-Marquardt")[0].converged
    with pytest.raises(TypeError, match="a list of one or more instances of `Problem`"):
        ha.Trials([])
    with pytest.raises(ha.Error, match="variables of a trial"):
        ha.Trials([problems[0], ha.Problem(problems[1].system, problems[1].inputs, ["duration"])]).minimise()
