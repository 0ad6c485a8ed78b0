"""Optima from a guess of the states, by `solve`."""

import multiprocessing
import pickle
import signal
import threading

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from scenes import cart_with_links, pushed
from test_optimise import block


def upright(links=1, steps=40, duration=1.0, time=False):
    """A cart whose links turn up with little effort, or in the shortest time: inputs at rest, the force, the angles, and the constraints."""
    scene, force, angles = cart_with_links(links, cost="none")
    if time:
        scene.time("time", 1.0)
    else:
        scene.effort("effort", force, 1e-4)
    ends = [scene.end_state(angle) for angle in angles]
    system = scene.compile()
    constraints = {output: value for position, rate in ends for output, value in ((position, np.pi / 2), (rate, 0.0))}
    return system.at_rest(steps, duration / steps), force, angles, constraints


def problem_of(of):
    inputs, force, _, constraints = of
    return ha.Problem(inputs.system, inputs, [force], constraints=constraints)


# No attempt converges with these options, so that no start is the last one.
ENDLESS = {"stationarity": 0.0, "iterations": 3}


# With two links, the steps are too long for an accurate motion.
@pytest.mark.filterwarnings("ignore:the steps are too long")
@pytest.mark.parametrize("links", [1, 2])
def test_a_swing_up_from_rest(links):
    inputs, force, angles, constraints = upright(links, 30 * links, 0.8 * links)
    found = ha.solve(inputs.system, inputs, [force], constraints=constraints)
    assert found.converged and found.violation < 1e-9, found
    motion = ha.simulate(inputs.system, found.inputs)
    for angle in angles:
        assert motion[angle][-1] == pytest.approx(np.pi / 2, abs=1e-8) and motion[angle.v][-1] == pytest.approx(0.0, abs=1e-8)
    last = found.attempts[-1]
    assert (last.what, last.reason, last.value, last.unstable) == (f"{6 * links} segments", found.reason, found.value, False)
    head, row, *warnings = str(found).splitlines()[3:]
    assert len(warnings) == len(found.warnings) and all("warning: the steps are too long" in line for line in warnings)
    assert head.split() == ["tried", "iterations", "J", "violation", "end"] and last.what in row and f"{last.iterations} " in row and row.endswith(last.reason)
    problem = problem_of((inputs, force, angles, constraints))
    for same in (problem.solve(), pickle.loads(pickle.dumps(problem)).solve()):
        assert same.value == found.value and np.array_equal(same.x, found.x) and same.attempts == found.attempts
    assert pickle.loads(pickle.dumps(found)).attempts == found.attempts and str(pickle.loads(pickle.dumps(found))) == str(found)
    # Other methods have no attempts, and the optimum is stationary for them.
    by_name = problem.minimise(start=found.x, stationarity=1e-5)
    assert by_name.converged and by_name.iterations < 5 and by_name.attempts == [] and "tried" not in str(by_name)


def test_an_optimum_of_a_similar_problem():
    inputs, force, (angle,), constraints = upright()

    def solved(change, guess):
        moved = {output: value + change * (value != 0.0) for output, value in constraints.items()}
        return ha.solve(inputs.system, inputs, [force], bounds={force: (-40.0, 40.0)}, constraints=moved, guess=guess)

    first = solved(0.0, "straight")
    assert first.converged and np.sum(np.abs(first.x) > 40.0 - 1e-3) > 3
    next = solved(1e-3, first)
    assert next.converged and next.iterations <= 6 and [of.what for of in next.attempts] == ["near the optimum"], next
    assert next.value == pytest.approx(solved(1e-3, "straight").value, rel=1e-6)
    longer = ha.Problem(inputs.system, inputs.system.at_rest(50, 0.02), [force], constraints=constraints)
    with pytest.raises(ha.Error, match="variables of a guess"):
        longer.solve(first)


@pytest.mark.parametrize("form", [{}, {"spline": 8}])
def test_sensitivities(form):
    """The derivatives of an optimum are those of solving again, also by an initial value that is held."""
    inputs, force, (angle,), constraints = upright()
    (target, _), *_ = constraints.items()

    def problem(change=0.0, start=0.0, assembled=True):
        at = inputs.copy()
        at[angle] = held = float(inputs[angle]) + start
        if assembled:
            at.assemble(angle)
        free = [ha.free(force, **form, within=(-40.0, 40.0)), angle]
        return ha.Problem(at.system, at, free, bounds={angle: (held, held)}, constraints={**constraints, target: np.pi / 2 + change})

    stated = problem()
    found = stated.solve(stationarity=1e-10)
    by_target, by_start, by_number = stated.sensitivities(found, [target, angle, len(found.x) - 1], stationarity=1e-10)
    for derivative, change in ((by_target, {"change": 1e-4}), (by_start, {"start": 1e-4})):
        above, below = (problem(**{name: sign * by for name, by in change.items()}).solve(found, stationarity=1e-10) for sign in (1, -1))
        assert derivative.value == pytest.approx((above.value - below.value) / 2e-4, rel=1e-4)
        expected = (above.x - below.x) / 2e-4
        assert np.abs(derivative.x - expected).max() < 1e-2 * np.abs(expected).max()
    assert by_number.value == by_start.value and np.array_equal(by_number.x, by_start.x)
    # The multiplier of a target is the derivative of -J.
    place = inputs.system.outputs.index(target.name)
    assert by_target.value == pytest.approx(-found.multipliers[place], rel=1e-5)
    assert stated.sensitivities(found, [target.name])[0].value == pytest.approx(by_target.value, rel=1e-5)
    for wrong, error, words in ((force, ha.InputError, "not a single free variable"), (len(found.x), ha.Error, "is not among the"), ("no output", ha.InputError, "no output")):
        with pytest.raises(error, match=words):
            stated.sensitivities(found, [wrong])
    # A given start cannot change by one coordinate alone.
    with pytest.raises(ha.OptimiseError, match="cannot be free if the start is given"):
        problem(assembled=False).sensitivities(found, [angle])
    with pytest.raises(TypeError, match="an Optimum"):
        stated.sensitivities(found.x, [target])


def test_nothing_is_free():
    inputs, _, _, constraints = upright()
    found = ha.solve(inputs.system, inputs, [], constraints=constraints)
    assert not found.converged and "nothing is free: list in `free` what may change" in str(found)


def test_an_accuracy():
    inputs, force, _, constraints = upright()
    rough, fine = (ha.solve(inputs.system, inputs, [force], constraints=constraints, accuracy=accuracy) for accuracy in (None, 1e-5))
    assert fine.converged and not fine.warnings and [of.what for of in fine.attempts][1] == "by ESDIRK4", fine
    assert (rough.scheme, fine.scheme) == ("trapezoidal rule", "ESDIRK4")
    solver = ha.Solver(inputs.system, scheme=fine.scheme)
    solver.simulate(fine.inputs)
    assert solver.cost() == pytest.approx(fine.value, rel=1e-9) and rough.value == pytest.approx(fine.value, rel=0.05)
    with pytest.raises(ha.InputError, match="accuracy"):
        ha.solve(inputs.system, inputs, [force], constraints=constraints, accuracy=-1.0)


def test_guesses():
    of = upright()
    inputs, force, (angle,), constraints = of
    straight = problem_of(of).solve()
    motion = ha.simulate(inputs.system, straight.inputs)
    # Segments with the forces of the optimum meet if they begin at its states, and only there.
    again = ha.Problem(inputs.system, straight.inputs, [force], constraints=constraints)
    guesses = [motion, (motion.q, motion.v), [motion.q.tolist(), motion.v.tolist()], np.array([motion.q, motion.v])]
    for guess in guesses:
        found = again.solve(guess)
        assert found.converged and found.history[0].violation < 0.05, found.history[0]
        assert found.value == pytest.approx(straight.value, rel=1e-6)
    assert ha.solve(inputs.system, straight.inputs, [force], constraints=constraints, guess=motion).history[0] == again.solve(motion).history[0]
    assert again.solve().history[0].violation > 0.1 and again.solve((motion.q, 0 * motion.v)).history[0].violation > 0.1
    # Without segments, this is the interior point method.
    direct = again.solve("inputs")
    assert [of.what for of in direct.attempts] == ["one motion"] and direct.history == again.minimise().history


def test_several_starts():
    problem = problem_of(upright())
    one, several = problem.solve(), problem.solve(starts=3)
    assert several.converged and several.value <= one.value and several.attempts[0] == one.attempts[0] and len(several.attempts) >= 3
    assert problem.solve(starts=3).attempts == several.attempts and problem.solve("inputs", starts=2).converged
    many = problem.solve(starts=9, **ENDLESS)
    assert not many.converged and "more `iterations`" in str(many)
    assert len(many.attempts) > 10 and str(many).splitlines()[-1] == f"  … and {len(many.attempts) - 10} other attempts"
    assert sum(of.what in line for of, line in zip(many.attempts, str(many).splitlines()[-11:])) == 10


def test_what_to_do_without_an_optimum():
    x, force, mass, position, speed, system, inputs = block(20)
    with pytest.warns(ha.MotionWarning, match="force is at its bounds in 21 of 21 variables"):
        found = ha.solve(system, inputs, [force], constraints={position: 1.0, speed: 0.0}, bounds={force: (-2.0, 2.0)})
    assert not found.converged and "try several `starts`, another `guess`, a longer duration, or wider bounds" in str(found)


def test_the_shortest_time():
    inputs, force, _, constraints = upright(time=True)
    bounds = {force: (-40.0, 40.0), "duration": (0.2, 4.0)}
    found = ha.solve(inputs.system, inputs, [force, "duration"], constraints=constraints, bounds=bounds, stationarity=1e-6)
    assert found.converged and found.violation < 1e-9 and found.value == pytest.approx(found.inputs.times[-1]) and found.value < 0.95


def test_a_scene_from_a_file(tmp_path):
    inputs, force, angles, constraints = upright()
    scene, _, _ = cart_with_links(1, cost="none")
    scene.effort("effort", scene["force on the cart"], 1e-4)
    scene.end_state(scene["link 1"].phi)
    scene.save(tmp_path / "cart.json")
    system = ha.Scene.load(tmp_path / "cart.json").compile()
    names = {"value of link 1.φ at the end": np.pi / 2, "rate of link 1.φ at the end": 0.0}
    found = ha.solve(system, system.at_rest(40, 0.025), [ha.Scene.load(tmp_path / "cart.json")["force on the cart"]], constraints=names)
    assert found.value == ha.solve(inputs.system, inputs, [force], constraints=constraints).value
    assert [name for name, _, _ in found.limits] == [f"output `{name}`" for name in names]


def test_settings_and_options():
    inputs, force, _, constraints = upright()
    found = ha.solve(inputs.system, inputs, [force], constraints=constraints, settings={"scheme": "ESDIRK4"}, stationarity=1e-5)
    assert found.converged and found.value != ha.solve(inputs.system, inputs, [force], constraints=constraints).value
    early = ha.solve(inputs.system, inputs, [force], constraints=constraints, iterations=2)
    assert not early.converged and all(of.iterations <= 2 for of in early.attempts)


def calls_of_one_start(problem):
    """The number of calls of the callback in the first start."""
    calls = []
    problem.solve(callback=lambda *of: calls.append(of), **ENDLESS)
    return len(calls)


def test_callbacks():
    problem = problem_of(upright())
    seen = []

    def stop(iterate, x):
        seen.append((iterate, x.copy(), threading.current_thread()))
        return len(seen) == 3

    found = problem.solve(callback=stop)
    assert not found.converged and "callback" in found.reason and [of.reason for of in found.attempts] == [found.reason]
    assert "continue from x" in str(found)
    assert len(seen) == 3 and [of for of, _, _ in seen] == found.history
    # Callbacks are called in the thread of the caller, where they may draw.
    assert all(x.shape == (41,) and thread is threading.current_thread() for _, x, thread in seen)
    with pytest.raises(ZeroDivisionError):
        problem.solve(callback=lambda iterate, x: 1 / 0)
    # A callback may use the library itself.
    assert problem.solve(starts=2, callback=lambda iterate, x: bool(problem.minimise(iterations=1).converged)).converged


def test_callbacks_stop_other_starts():
    problem = problem_of(upright())
    first, seen = calls_of_one_start(problem), []

    def stop(iterate, x):
        seen.append(iterate)
        return len(seen) == first + 2

    found = problem.solve(starts=10**4, callback=stop, **ENDLESS)
    assert not found.converged and len(seen) == first + 2 and len(found.attempts) < 30
    assert all(np.isfinite(of.stationarity) for of in seen)

    def fail(iterate, x):
        seen.append(iterate)
        if len(seen) > first:
            raise ZeroDivisionError

    seen.clear()
    with pytest.raises(ZeroDivisionError):
        problem.solve(starts=10**4, callback=fail, **ENDLESS)
    assert len(seen) == first + 1


@pytest.mark.parametrize("starts", [1, 10**4])
def test_ctrl_c(starts):
    # Without an end, or for minutes, if they are not stopped.
    problem = problem_of(upright(3, 2000, 2.0) if starts == 1 else upright())
    first, seen = 1 if starts == 1 else calls_of_one_start(problem), []

    def interrupt(iterate, x):
        seen.append(iterate)
        if len(seen) == first:
            threading.Timer(0.2, lambda: signal.raise_signal(signal.SIGINT)).start()

    with pytest.raises(KeyboardInterrupt):
        problem.solve(starts=starts, callback=interrupt, **({"stationarity": 0.0} if starts == 1 else ENDLESS))
    assert len(seen) >= first


def test_other_threads_run():
    problem = problem_of(upright())
    thread = threading.Thread(target=problem.solve, kwargs={"starts": 3})
    thread.start()
    # This thread needs the lock of the interpreter.
    while thread.is_alive():
        assert len(problem.start) == 41
    thread.join()


def value_from_several_starts(problem):
    return problem.solve(starts=3).value


@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="no processes by fork")
@pytest.mark.filterwarnings("ignore:.*fork")
def test_processes_by_fork():
    problem = problem_of(upright())
    value = value_from_several_starts(problem)
    with multiprocessing.get_context("fork").Pool(1) as pool:
        assert pool.apply_async(value_from_several_starts, (problem,)).get(timeout=60) == value


@pytest.mark.parametrize(
    "arguments, kind, message",
    [
        ({"guess": "line"}, ha.InputError, r"no guess 'line'; a guess is 'straight', 'inputs', a motion, an optimum, or a pair \(q, v\)"),
        ({"guess": 3}, TypeError, r"a pair \(q, v\) of arrays .*, not int"),
        ({"guess": {"cart.x": 0.0}}, TypeError, "a pair"),
        ({"guess": (np.zeros((6, 41)),)}, TypeError, "a pair"),
        ({"guess": (np.zeros((6, 40)), np.zeros((6, 41)))}, ha.InputError, r"`q` of the guess has the shape \(6, 40\); \(6, 41\) is expected, a row for each"),
        ({"guess": (np.zeros((6, 41)), np.zeros(41))}, ha.InputError, r"`v` of the guess has the shape \(41,\); \(6, 41\)"),
        ({"guess": (np.zeros((6, 41)), np.full((6, 41), np.nan))}, ha.InputError, "velocities of a guess"),
        ({"starts": 0}, ha.InputError, "`starts` is 0; at least one"),
        ({"starts": 1.5}, TypeError, "`starts` must be a whole number, not 1.5"),
        ({"iteration": 3}, TypeError, "there is no option `iteration`; options"),
        ({"scheme": "ESDIRK4"}, TypeError, r"a setting of the solver: write settings=\{'scheme': …\}"),
        ({"method": "L-BFGS"}, TypeError, "`method` is an argument of `minimise`; options"),
        ({"violation": -1.0}, ha.InputError, "violation"),
    ],
)
def test_mistakes(arguments, kind, message):
    with pytest.raises(kind, match=message):
        problem_of(upright()).solve(**arguments)


def test_mistakes_about_problems():
    of = upright()
    inputs, force, (angle,), constraints = of
    shooting = ha.MultipleShooting(inputs.system, inputs, [force], ["cart.x", angle], 4, constraints=constraints)
    with pytest.raises(ha.OptimiseError, match=r"itself: state it as a `Problem`, or call `minimise\(method='stages'\)`"):
        shooting.solve()
    with pytest.raises(ha.OptimiseError, match="`solve` is for a single motion"):
        ha.Trials([problem_of(of), problem_of(of)]).solve()
    assert ha.Trials([problem_of(of)]).solve().value == problem_of(of).solve().value
    other = upright(2)[0].system
    with pytest.raises(ha.InputError, match="the guess is a motion of another system"):
        problem_of(of).solve(ha.simulate(other, pushed(other)))
    with pytest.raises(TypeError, match=r"`starts` is an argument of `solve`: write problem.solve\(starts=…\)"):
        ha.Problem(inputs.system, inputs, [force], starts=3)
    with pytest.raises(TypeError, match="`guess` is an argument of `solve`; options"):
        problem_of(of).minimise(guess="straight")
    with pytest.raises(ha.InputError, match="no output `height`"):
        ha.solve(inputs.system, inputs, [force], constraints={"height": 0.0})
