"""Optimisation of motions."""

import signal
import threading
import warnings

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from hamiltonian_adjoint._optimise import SETTINGS
from scenes import block_on_a_spring, cart_with_links, pushed


def block(steps=50):
    """A block of 2 kg that a force pushes: from rest, by 1 m, in 1 s."""
    scene = ha.Scene()
    x = scene.coordinates("block", ["x"]).x
    force, mass = scene.control("force"), scene.design("mass", 2.0)
    scene.kinetic_energy("motion", 0.5 * mass * x.v**2)
    scene.force("push", {x: force})
    scene.cost("effort", 0.5 * force**2, sum="integral")
    position, speed = scene.end_state(x)
    system = scene.compile()
    return x, force, mass, position, speed, system, system.at_rest(steps, 1.0 / steps)


@pytest.mark.parametrize("method", ["interior point", "augmented Lagrangian"])
def test_the_least_effort_of_a_block(method):
    x, force, mass, position, speed, system, inputs = block()
    found = ha.minimise(system, inputs, [force], constraints={position: 1.0, speed: 0.0}, method=method)
    assert found.converged and found.violation < 1e-8, found
    # u = m (6 − 12 t), J = ½ ∫ u² dt = 6 m²
    assert found.value == pytest.approx(24.0, rel=2e-3)
    inner = found.inputs[force][1:-1]
    assert inner == pytest.approx(2.0 * (6.0 - 12.0 * inputs.times[1:-1]), abs=0.05)
    end = ha.simulate(system, found.inputs)
    assert end[x][-1] == pytest.approx(1.0, abs=1e-8) and end[x.v][-1] == pytest.approx(0.0, abs=1e-8)
    assert found.names[0].startswith("force") and len(found.x) == 51
    assert [of.evaluations for of in found.history] == sorted(of.evaluations for of in found.history)


def test_bounds_forms_and_other_quantities():
    x, force, mass, position, speed, system, inputs = block()
    bounded = ha.minimise(system, inputs, [force], constraints={position: 1.0, speed: 0.0}, bounds={force: (-10.0, 10.0)})
    assert bounded.converged and np.abs(bounded.inputs.controls).max() <= 10.0
    # The force is linear in time between its bounds, for a time s on both sides of the middle with s² = 0.15.
    assert bounded.value == pytest.approx(50.0 - 200.0 / 3.0 * np.sqrt(0.15), rel=2e-3)
    few = ha.minimise(system, inputs, [ha.free(force, linear=3)], constraints={position: 1.0, speed: 0.0})
    assert few.converged and len(few.x) == 3
    inputs[force] = 4.0
    timed = ha.minimise(system, inputs, ["duration"], constraints={position: 1.0}, bounds={"duration": (0.1, 5.0)})
    assert timed.converged and timed.inputs.times[-1] == pytest.approx(1.0, rel=1e-8)
    heavier = ha.minimise(system, inputs, [ha.free(mass, within=(0.1, 9.0))], constraints={position: 0.5})
    assert heavier.inputs[mass] == pytest.approx(4.0, rel=1e-8)
    thrown = ha.minimise(system, inputs, [x.v], constraints={position: 2.0})
    assert thrown.inputs[x.v] == pytest.approx(1.0, rel=1e-8)


def test_a_fit_with_its_accuracy():
    scene, x, stiffness = block_on_a_spring()
    noise = np.random.default_rng(1).normal(size=20) * 0.01
    for i in range(20):
        scene.reading(f"reading {i}", x, 5 * (i + 1), float(np.cos(2.0 * 0.05 * (i + 1)) + noise[i]), 100.0)
    system = scene.compile()
    found = ha.minimise(system, system.at_rest(100, 0.01), [stiffness], method="Levenberg-Marquardt")
    assert found.converged
    assert abs(found.inputs[stiffness] - 4.0) < 4 * found.standard_errors[0] < 1.0
    assert found.covariance.shape == (1, 1)


def test_the_swing_up_of_the_paper():
    scene, force, _ = cart_with_links()
    system = scene.compile()
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        found = ha.minimise(system, pushed(system), [force], method="L-BFGS", target=1e-10)
    assert found.converged and found.value <= 1e-10 and found.evaluations < 80, found
    assert "target" in found.reason
    assert {of.category.__name__ for of in seen} == {kind for kind, _ in found.warnings}


def test_callbacks_stop_and_raise():
    scene, force, _ = cart_with_links()
    system = scene.compile()
    seen = []

    def stop(iterate, x):
        seen.append((iterate.value, x.shape))
        return len(seen) == 3

    found = ha.minimise(system, pushed(system), [force], method="L-BFGS", callback=stop)
    assert not found.converged and "callback" in found.reason and len(seen) == 3 and seen[0][1] == (101,)
    with pytest.raises(ZeroDivisionError):
        ha.minimise(system, pushed(system), [force], callback=lambda iterate, x: 1 / 0)
    threading.Timer(0.2, lambda: signal.raise_signal(signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        ha.minimise(system, pushed(system, steps=3000, dt=2.0 / 3000), [force], stationarity=0.0, iterations=10**9)


def test_settings_of_the_solver():
    x, force, mass, position, speed, system, inputs = block()
    ends = {position: 1.0, speed: 0.0}
    found = ha.minimise(system, inputs, [force], constraints=ends, settings={"scheme": "ESDIRK4"})
    same = ha.Problem(system, inputs, [force], constraints=ends, settings={"scheme": "ESDIRK4"}).minimise()
    other = ha.minimise(system, inputs, [force], constraints=ends)
    assert found.value == same.value != other.value
    # The solver has the settings that the messages of optimisers list.
    with pytest.raises(TypeError) as error:
        ha.Solver(system, nothing=1)
    assert str(error.value).endswith(", ".join(SETTINGS))


def test_an_optimum_says_what_is_off():
    x, force, mass, position, speed, system, inputs = block()
    bounded = {"constraints": {position: 1.0, speed: (-0.1, 0.0)}, "bounds": {force: (-2.0, 2.0)}}
    found = ha.minimise(system, inputs, [force], **bounded)
    names = [f"output `{of.name}`" for of in (position, speed)]
    assert not found.converged and found.limits == [(names[0], 1.0, 1.0), (names[1], -0.1, 0.0)]
    first, second, third, *lines = str(found).splitlines()
    assert first.startswith("<optimum: ") and second.startswith("  after ") and "e0" not in third and "largest violation" in third
    place, rate = found.constraints
    assert f"  {names[0]} is {place:.6g} instead of 1, off by {1.0 - place:.2g}" in lines
    assert f"  {names[1]} is {rate:.6g} instead of at most 0, off by {rate:.2g}" in lines and rate > 0.0
    assert "another start, a longer duration, or wider bounds" in lines[-1]
    early = ha.minimise(system, inputs, [force], constraints={position: 1.0, speed: 0.0}, iterations=0)
    assert str(early).endswith("allow more `iterations`") and "0 iterations (1 value, " in str(early)
    done = ha.minimise(system, inputs, [force], constraints={position: 1.0, speed: 0.0})
    assert done.converged and len(str(done).splitlines()) == 3


def test_an_optimum_lists_the_worst_outputs():
    scene = ha.Scene()
    x = scene.coordinates("block", ["x"]).x
    force = scene.control("force")
    scene.kinetic_energy("motion", 0.5 * x.v**2)
    scene.force("push", {x: force})
    for i in range(8):
        scene.output(f"at {i}", x - float(i), sum="terminal")
    system = scene.compile()
    found = ha.minimise(system, system.at_rest(20, 0.05), [force])
    lines = str(found).splitlines()[3:]
    worst = [float(line.split("off by ")[1]) for line in lines[:5]]
    assert worst == sorted(worst, reverse=True) and "… and 3 other outputs" in lines[5] and len(lines) == 7


END = "value of block.x at the end"


@pytest.mark.parametrize(
    "call, kind, message",
    [
        (lambda s, i, f: ha.minimise(s, i, f), TypeError, "must be a list"),
        (lambda s, i, f: ha.minimise(s, i, [f], method="BFGS"), ha.InputError, "the methods are 'interior point'"),
        (lambda s, i, f: ha.minimise(s, i, ["duratoin"]), TypeError, "'duration' can be free"),
        (lambda s, i, f: ha.minimise(s, i, [f], step=1), TypeError, "there is no option `step`; options of the methods are iterations,.*; settings of the solver, as .* are scheme,"),
        (lambda s, i, f: ha.minimise(s, i, [f], max_iterations=3), TypeError, r"a setting of the solver: write settings=\{'max_iterations': …\}; options"),
        (lambda s, i, f: ha.Problem(s, i, [f]).minimise(tolerance=3), TypeError, "a setting of the solver"),
        (lambda s, i, f: ha.Problem(s, i, [f]).multi_start([[0.0] * 51], tolerance=3), TypeError, "a setting of the solver"),
        (lambda s, i, f: ha.Problem(s, i, [f]).homotopy(lambda i, s: None, tolerance=3), TypeError, "a setting of the solver"),
        (lambda s, i, f: ha.Problem(s, i, [f], settings={"iterations": 3}), TypeError, "an option of the method, not a setting of the solver"),
        (lambda s, i, f: ha.minimise(s, i, [f], settings={"tolerence": 3}), TypeError, "there is no setting `tolerence`; options of the methods are"),
        (lambda s, i, f: ha.minimise(s, i, [f], bounds={f: (1, 2, 3)}), ha.InputError, r"bounds of control `force`: bounds are a pair"),
        (lambda s, i, f: ha.minimise(s, i, [f], bounds={f: 0.1}), ha.InputError, "not 0.1; to keep the quantity at this value, set it in the inputs"),
        (lambda s, i, f: ha.free(f, within=0.1), ha.InputError, "free control `force`: bounds are a pair"),
        (lambda s, i, f: ha.minimise(s, i, [f], constraints={END: (1, 2, 3)}), ha.InputError, f"constraint `{END}`: a number, a pair"),
        (lambda s, i, f: ha.minimise(s, i, [f], constraints={END: "no"}), ha.InputError, f"constraint `{END}`: a number, a pair"),
        (lambda s, i, f: ha.minimise(s, i, [f], bounds={"duration": (1, 2)}), ha.InputError, "`bounds` has a pair for `duration`, which is not free"),
        (lambda s, i, f: ha.minimise(s, i, [f], constraints={END: "3"}), ha.InputError, f"constraint `{END}`: a number, a pair"),
        (lambda s, i, f: ha.minimise(s, i, [f], bounds={f: ("-1", 1)}), ha.InputError, "bounds of control `force`: bounds are a pair"),
        (lambda s, i, f: ha.minimise(s, i, ["force"]), TypeError, r"not 'force'; find a quantity by its name with `scene\['…'\]`"),
        (lambda s, i, f: ha.minimise(s, i, [f], bounds={f: (2, 1)}), ha.InputError, "at least the lower bound"),
        (lambda s, i, f: ha.minimise(s, i, [f], constraints={"height": 0}), ha.InputError, "no output `height`"),
        (lambda s, i, f: ha.Problem(s, i, [f], constraints={END[:-1]: 0}), ha.InputError, f"did you mean `{END}`"),
        (lambda s, i, f: ha.Problem(s, i, [f], scheme="ESDIRK4"), TypeError, r"`scheme` is a setting of the solver: write settings=\{'scheme': …\}; options"),
        (lambda s, i, f: ha.Problem(s, i, [f], iterations=3), TypeError, r"`iterations` is an argument of `minimise`: write problem.minimise\(iterations=…\)"),
        (lambda s, i, f: ha.Problem(s, i, [f], method="L-BFGS"), TypeError, "`method` is an argument of `minimise`"),
        (lambda s, i, f: ha.Problem(s, i, [f], bound={}), TypeError, r"a problem has no argument `bound`; did you mean `bounds`\?"),
        (lambda s, i, f: ha.minimise(s, i, [f], constraints=[END]), TypeError, r"`constraints` must be a dictionary, such as \{output: 0.5\}, not \['value"),
        (lambda s, i, f: ha.minimise(s, i, [f], constraints={(END, END): (1, 2)}), TypeError, "is no output and no name of one"),
        (lambda s, i, f: ha.minimise(s, i, [f], bounds=(-1, 1)), TypeError, r"`bounds` must be a dictionary, such as \{force: \(-5, 5\)\}, not \(-1, 1\)"),
        (lambda s, i, f: ha.minimise(s, i, [f], iterations=1e3), TypeError, "`iterations` must be a whole number, not 1000.0"),
        (lambda s, i, f: ha.solve(s, i, [f], starts="5"), TypeError, "`starts` must be a whole number, not '5'"),
        (lambda s, i, f: ha.MultipleShooting(s, i, [f], ["block.x"], 2.5), TypeError, "`segments` must be a whole number, not 2.5"),
        (lambda s, i, f: ha.Scene().outputs_at("x", 1.0, 51), TypeError, r"`nodes` must be a list of nodes, such as range\(51\), not 51"),
        (lambda s, i, f: ha.minimise(s, i, [f, f]), ha.Error, "force"),
        (lambda s, i, f: ha.free(f, linear=2, spline=3), TypeError, "only one of them"),
    ],
)
def test_mistakes(call, kind, message):
    _, force, _, _, _, system, inputs = block()
    with pytest.raises(kind, match=message):
        call(system, inputs, force)
