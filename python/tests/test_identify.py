"""Readings and fits."""

import pickle
import re

import hamiltonian_adjoint as ha
import numpy as np
import pytest


def oscillator(stiffness=3.0):
    """1 kg on a spring, released at 1 m."""
    scene = ha.Scene()
    x = scene.coordinates("block", ["x"], [1.0]).x
    stiffness = scene.design("stiffness", stiffness)
    scene.kinetic_energy("motion", 0.5 * x.v**2)
    scene.potential_energy("spring", 0.5 * stiffness * x**2)
    return scene, x, stiffness


def measured(of, times, deviation, seed=1):
    return of(times) + deviation * np.random.default_rng(seed).normal(size=len(times))


def test_a_fit_to_a_table(tmp_path):
    times, deviation = np.sort(np.random.default_rng(2).uniform(0.05, 3.0, 40)), 0.01
    values = measured(lambda t: np.cos(2.0 * t), times, deviation)
    rows = [f"{t!r},{x!r},{0.5 if i % 2 else ''}" for i, (t, x) in enumerate(zip(times.tolist(), values.tolist()))]
    (tmp_path / "readings.csv").write_text("t [s],x [m],force [N]\n" + "\n".join(rows) + "\n", encoding="utf-8")
    table = ha.Table.load(tmp_path / "readings.csv")
    assert table.names == ["x [m]", "force [N]"] and np.array_equal(table["x"], [times, values]) and len(table["force [N]"][0]) == 20

    scene, x, stiffness = oscillator()
    steps = ha.steps_through([0.0, *table.times], 0.02)
    outputs = scene.readings("position", x, *table["x"], deviation=deviation, steps=steps)
    assert [of.name for of in outputs[:2]] == ["position.0", "position.1"]
    system = scene.compile()
    found = ha.minimise(system, system.at_rest(steps), [stiffness], method="Levenberg-Marquardt")
    assert found.converged and "χ²" in str(found)
    error = found.standard_errors[0]
    assert abs(found.inputs[stiffness] - 4.0) < 3 * error and 1e-4 < error < 0.05
    assert found.covariance[0, 0] == pytest.approx(error**2)
    # Forty normal deviates less one parameter.
    assert found.degrees_of_freedom == 39 and abs(found.chi_squared - 39) < 3 * np.sqrt(78)
    assert found.chi_squared == pytest.approx(np.sum(found.constraints**2)) and len(found.grid_shifts) == 1 and found.undetermined == []
    lines = str(found).splitlines()
    assert lines[0].endswith(",") and lines[1].startswith("  after ") and lines[2].startswith("  χ² ") and "largest violation" not in lines[2]
    decimals = 1 - int(np.floor(np.log10(error)))
    assert lines[3] == f"  stiffness = {found.x[0]:.{decimals}f} ± {error:.{decimals}f}" and decimals in (3, 4) and len(lines) == 4
    # The errors for known deviations differ by the factor √(χ²/degrees of freedom) in the part of the noise.
    shift, scale = found.grid_shifts[0], np.sqrt(found.chi_squared / found.degrees_of_freedom)
    assert found.absolute_errors[0] == pytest.approx(np.hypot(np.sqrt(error**2 - shift**2) / scale, shift))
    # Residuals by hand.
    motion = ha.simulate(system, found.inputs)
    at = np.searchsorted(motion.times, times - 1e-9)
    assert found.constraints == pytest.approx((motion[x][at] - values) / deviation, abs=1e-9)


@pytest.mark.parametrize(
    "quantity, truth",
    [
        (lambda x: x.v, lambda t: -2.0 * np.sin(2.0 * t)),
        (lambda x: x.a, lambda t: -4.0 * np.cos(2.0 * t)),
        (lambda x: 2.0 * x, lambda t: 2.0 * np.cos(2.0 * t)),
    ],
)
def test_readings_of_formulas(quantity, truth):
    scene, x, stiffness = oscillator()
    times = np.linspace(0.1, 2.0, 20)
    deviation = np.where(times < 1.0, 0.01, 0.02)
    values = measured(truth, times, deviation)
    scene.readings("sensor", quantity(x), times, values, deviation=deviation, steps=400, dt=0.005)
    system = scene.compile()
    inputs = system.at_rest(400, 0.005)
    inputs[stiffness] = 4.0
    solver = ha.Solver(system)
    solver.simulate(inputs)
    # The trapezoidal rule has an error of phase (ω Δt)²/12 ω t; the amplitude is at most 4.
    assert solver.outputs() * deviation == pytest.approx(truth(times) - values, abs=4.0 * 0.01**2 / 12.0 * 4.0)
    ha.check_gradient(system, inputs, output="sensor.7").assert_passed()
    inputs[stiffness] = 3.0
    found = ha.minimise(system, inputs, [stiffness], method="Levenberg-Marquardt")
    assert found.converged and abs(found.inputs[stiffness] - 4.0) < 3 * found.standard_errors[0] < 0.1


def test_controls_from_a_table():
    table = ha.Table("t,force\n0,1\n1,3\n2,\n3,5\n")
    assert np.interp([0.5, 2.0, 9.0], *table["force"]).tolist() == [2.0, 4.0, 5.0]


def test_undetermined_variables_have_names():
    scene, x, stiffness = oscillator()
    idle = scene.design("idle", 1.0)
    scene.readings("position", x, [0.5, 1.0, 1.5], [0.54, -0.42, -0.99], deviation=0.01, steps=100, dt=0.02)
    system = scene.compile()
    found = ha.minimise(system, system.at_rest(100, 0.02), [stiffness, idle], method="Levenberg-Marquardt")
    assert found.undetermined == ["idle"] and found.standard_errors is None and found.absolute_errors is None
    assert "do not determine idle" in str(found)


def test_errors_of_several_parameters():
    scene, x, stiffness = oscillator()
    damping = scene.design("damping", 0.1)
    scene.force("friction", {x: -damping * x.v})
    times = np.linspace(0.1, 2.0, 20)
    scene.readings("position", x, times, measured(lambda t: np.cos(2.0 * t), times, 0.01), deviation=0.01, steps=200, dt=0.01)
    system = scene.compile()
    found = ha.minimise(system, system.at_rest(200, 0.01), [stiffness, damping], method="Levenberg-Marquardt")
    noise = np.linalg.inv(found.jacobian.T @ found.jacobian)
    assert found.absolute_errors == pytest.approx(np.sqrt(np.diag(noise) + found.grid_shifts**2), rel=1e-6)
    assert len(str(found).splitlines()) == 5
    scaled = ha.minimise(
        system, system.at_rest(200, 0.01), [ha.free(stiffness, logarithm=True, scale=2.0), ha.free(damping, scale=0.1)], method="Levenberg-Marquardt"
    )
    assert scaled.x[0] == pytest.approx(np.log(found.x[0] / 2.0), rel=1e-4)
    for of, line in zip(found.names, str(scaled).splitlines()[3:]):
        name, value, error = re.fullmatch(r"  (.*) = (.*) ± (.*)", line).groups()
        i = found.names.index(of)
        assert name == of and abs(float(value) - found.x[i]) <= 0.06 * found.standard_errors[i] and float(error) == pytest.approx(found.standard_errors[i], rel=0.06)


def test_a_fit_that_ends_early_says_so():
    scene, x, stiffness = oscillator()
    scene.readings("position", x, [0.5, 1.0, 1.5], [0.54, -0.42, -0.99], deviation=0.01, steps=100, dt=0.02)
    system = scene.compile()
    found = [ha.minimise(system, system.at_rest(100, 0.02), [stiffness], method="Levenberg-Marquardt", iterations=count) for count in (1, 100)]
    assert ["shorter steps" in str(of).splitlines()[-1] for of in found] == [True, False] and found[1].converged


def test_as_many_readings_as_parameters():
    scene, x, stiffness = oscillator()
    scene.readings("position", x, [0.5], [np.cos(1.0)], deviation=0.01, steps=50, dt=0.01)
    system = scene.compile()
    found = ha.minimise(system, system.at_rest(50, 0.01), [stiffness], method="Levenberg-Marquardt")
    # x = cos(√k t): dx/dk = −t sin(√k t)/(2 √k)
    assert found.standard_errors is None and found.absolute_errors[0] == pytest.approx(0.01 / (0.5 * np.sin(1.0) / 4.0), rel=1e-3)


@pytest.mark.parametrize(
    "times, values, keywords, message",
    [
        ([0.1, 0.2], [1.0, np.nan], {}, r"reading 1 is nan at t = 0.2 s \(1 of 2 are not finite\).*keep = np.isfinite"),
        ([0.1, np.inf], [1.0, 1.0], {}, "reading 1 is 1.0 at t = inf s"),
        ([0.1, 0.137], [1.0, 1.0], {}, "readings `x`: it has a value at 0.137 s, where the grid has no node; use `steps_through`"),
        ([0.1, 0.2], [1.0], {}, r"two lists of one length, but their shapes are \(2,\) and \(1,\)"),
        ([], [], {}, "two lists of one length"),
        ([0.1, 0.2], [1.0, 2.0], {"deviation": 0.0}, "deviation of reading 0 is 0.0; a standard deviation must be positive"),
        ([0.1, 0.2], [1.0, 2.0], {"deviation": [1.0, 1.0, 1.0]}, r"the shape \(3,\); it must be a number, or one for each of 2"),
        ([0.1, 0.2], [1.0, 2.0], {"steps": -1}, "must not be negative"),
    ],
)
def test_mistakes(times, values, keywords, message):
    scene, x, _ = oscillator()
    with pytest.raises(ha.InputError, match=message):
        scene.readings("x", x, times, values, **{"deviation": 0.1, "steps": 10, "dt": 0.1, **keywords})
    assert not scene.compile().outputs


@pytest.mark.parametrize("quantity", [lambda x: x, lambda x: 2.0 * x])
def test_readings_belong_to_their_times(quantity):
    scene, x, stiffness = oscillator()
    times = np.linspace(0.1, 2.0, 20)
    values = measured(lambda t: quantity(np.cos(2.0 * t)), times, 0.01)
    scene.readings("position", quantity(x), times, values, deviation=0.01, steps=200, dt=0.01)
    for of in (scene, ha.Scene.from_json(scene.to_json()), pickle.loads(pickle.dumps(scene))):
        system = of.compile()
        system = pickle.loads(pickle.dumps(system))
        right, slow, late = system.at_rest(200, 0.01), system.at_rest(200, 0.02), system.at_rest(200, 0.01)
        late.t0 = 0.5
        solver = ha.Solver(system)
        evaluations = [
            lambda inputs: ha.minimise(system, inputs, [stiffness], method="Levenberg-Marquardt", iterations=2),
            lambda inputs: ha.Problem(system, inputs, [stiffness]).multi_start([[3.0]], iterations=2),
            lambda inputs: ha.Trials([ha.Problem(system, inputs, [stiffness])]).start,
            lambda inputs: ha.Objective(system, inputs, [stiffness]).outputs([3.0]),
            lambda inputs: ha.Objective(system, inputs, [stiffness]).jacobian([3.0]),
            lambda inputs: ha.check_gradient(system, inputs, output="position.3"),
            lambda inputs: ha.LongSolver(system, 10**6).jacobian(inputs),
            lambda inputs: solver.gradient(inputs) and solver.outputs(),
            lambda inputs: solver.simulate(inputs) and solver.weighted_gradient(0.0, np.ones(20)),
        ]
        for evaluate in evaluations:
            evaluate(right)
            with pytest.raises(ha.InputError, match="reading `position.0` belongs to 0.1 s, but node 10 is at 0.2 s; use the steps"):
                evaluate(slow)
            with pytest.raises(ha.InputError, match="node 10 is at 0.6 s"):
                evaluate(late)
        # The motion and J do not read nodes.
        assert ha.simulate(system, slow).times[-1] == pytest.approx(4.0) and ha.gradient(system, slow).value == 0.0
        # The same nodes from other sums.
        right.steps[:] = np.diff(np.arange(201) * 0.01)
        evaluations[0](right)


def test_an_optimiser_may_move_readings():
    # The clock of the sensor started later by an unknown time, the length of the first step.
    scene, x, stiffness = oscillator()
    times = np.linspace(0.1, 2.0, 20)
    scene.readings("position", x, times, measured(lambda t: np.cos(2.0 * (t + 0.03)), times, 0.01), deviation=0.01, steps=200, dt=0.01)
    system = scene.compile()
    free = [stiffness, ha.step_length(1, within=(0.001, 0.1), scale=0.01)]
    found = ha.minimise(system, system.at_rest(200, 0.01), free, method="Levenberg-Marquardt")
    errors = found.standard_errors
    assert abs(found.inputs[stiffness] - 4.0) < 3 * errors[0] < 0.1 and abs(found.inputs.steps[0] - 0.04) < 3 * 0.01 * errors[1] < 0.02
    again = ha.minimise(system, found.inputs, free, method="Levenberg-Marquardt")
    assert again.value == pytest.approx(found.value)
    problem = ha.Problem(system, system.at_rest(200, 0.01), [stiffness])

    def stretch(inputs, s):
        inputs.steps[:] = 0.01 * (1.0 + 0.1 * s)

    problem.homotopy(stretch, iterations=1)


def test_mistakes_in_tables_and_grids():
    with pytest.raises(ha.FileError, match="line 3.*not later"):
        ha.Table("t [s],x\n1,2\n1,3\n")
    with pytest.raises(ha.FileError, match="`ms`; expected `s`"):
        ha.Table("t [ms],x\n1,2\n")
    with pytest.raises(KeyError, match="no column `y`; its columns are x"):
        ha.Table("t [s],x\n1,2\n")["y"]
    with pytest.raises(ha.InputError, match="longest step of `steps_through`"):
        ha.steps_through([0.0, 1.0], 0.0)
    with pytest.raises(ha.InputError, match="a time of `steps_through`"):
        ha.steps_through([0.0, np.nan], 0.1)
    scene, x, _ = oscillator()
    scene.readings("x", x, [0.1], [1.0], deviation=1.0, steps=10, dt=0.1)
    scene.readings("x", x, [0.2], [1.0], deviation=1.0, steps=10, dt=0.1)
    with pytest.raises(ha.SceneError, match="x.0"):
        scene.compile()


def test_graded_steps():
    steps = ha.graded_steps(6, 0.02)
    assert steps.sum() == pytest.approx(0.02) and steps == pytest.approx(steps[::-1]) and steps[0] < 0.3 * steps[2]
    assert ha.steps_through([0.0, 0.1], 0.01).shape == (10,)
    with pytest.raises(ha.InputError, match="0 steps: the number of steps must be positive"):
        ha.graded_steps(0, 1.0)


def record(start, guess, seed=1, stiffness=10.0, **given):
    """A record of the oscillator with 40 N/m and a wrong guess of its stiffness and start."""
    scene, x, stiffness = oscillator(stiffness)
    times = np.arange(1, 101) * 0.05
    values = measured(lambda t: start * np.cos(np.sqrt(40.0) * t), times, 0.01, seed)
    scene.readings("position", x, times, values, **{"deviation": 0.01, "steps": 500, "dt": 0.01, **given})
    system = scene.compile()
    inputs = system.at_rest(500, 0.01)
    inputs[x] = guess
    return ha.Problem(system, inputs, [stiffness, ha.free(x, scale=0.1)], settings={"scheme": "ESDIRK4"})


def test_records_are_identified_from_far():
    records = [record(0.3, 0.2), record(-0.2, -0.2, seed=2)]
    found = ha.Trials(records, share="designs").identify()
    assert found.names == ["stiffness", "initial block.x of trial 0", "initial block.x of trial 1"]
    assert found.converged and len(found.attempts) > 1 and found.warnings == []
    truth = np.array([40.0, 3.0, -2.0])
    assert np.all(np.abs(found.x - truth) < 4 * found.absolute_errors) and found.absolute_errors[0] < 0.3
    assert found.trials[1].q[0] == pytest.approx(0.1 * found.x[2]) and found.trials[0].q[0] == pytest.approx(0.1 * found.x[1])
    assert found.degrees_of_freedom == 197
    lines = str(found).splitlines()
    assert re.match(r"  initial block.x of trial 1 = -0\.\d+ ± 0\.\d+", lines[5]), lines
    assert any(line.strip().startswith("segments with 3 readings") for line in lines)
    # A single record is a case of one.
    one = records[0].identify()
    assert one.names == ["stiffness", "initial block.x"] and abs(one.x[0] - 40.0) < 4 * one.absolute_errors[0]
    # As it is, the motion does not follow.
    with pytest.warns(ha.MotionWarning, match="larger than the errors of the readings"):
        assert abs(records[0].minimise("Levenberg-Marquardt", iterations=50).x[0] - 40.0) > 1.0
    with pytest.raises(ha.InputError, match="'all' variables or 'designs', not 'some'"):
        ha.Trials(records, share="some")
    stopped = records[0].identify(callback=lambda iterate, x: True)
    assert "callback" in stopped.reason and len(stopped.attempts) == 1


def test_an_improbable_chi_squared_warns():
    for deviation, quantity in [(0.001, None), (0.1, None), (0.001, 2.0)]:
        problem = record(0.3, 0.3, stiffness=39.0, deviation=deviation)
        if quantity is not None:
            scene, x, stiffness = oscillator(39.0)
            times = np.arange(1, 101) * 0.05
            values = measured(lambda t: 0.6 * np.cos(np.sqrt(40.0) * t), times, 0.01)
            scene.readings("double", quantity * x, times, values, deviation=deviation, steps=500, dt=0.01)
            system = scene.compile()
            problem = ha.Problem(system, system.at_rest(500, 0.01), [stiffness, x], settings={"scheme": "ESDIRK4"})
        with pytest.warns(ha.MotionWarning, match="larger" if deviation < 0.01 else "smaller"):
            found = problem.minimise("Levenberg-Marquardt")
        assert found.warnings[0][0] == "Misfit"
    # A deviation of 1 is not known.
    assert record(0.3, 0.3, stiffness=39.0, deviation=1.0).minimise("Levenberg-Marquardt").warnings == []
