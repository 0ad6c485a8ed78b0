"""Progress bars by tqdm."""

import re
import time

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from hamiltonian_adjoint import _progress
from scenes import cart_with_links, pushed
from test_paper import assert_same

pytest.importorskip("tqdm")


@pytest.fixture
def shown(monkeypatch, capsys):
    """Bars appear at once; returns what they have shown."""
    monkeypatch.setattr(_progress, "_DELAY", 0.0)
    return lambda: capsys.readouterr().err


def long_motion(seconds=0.4):
    """A system and inputs whose motion takes about this time, whether the library is optimised or not."""
    system = cart_with_links(3)[0].compile()
    times = []
    # The least time is that without other processes.
    for _ in range(5):
        start = time.perf_counter()
        ha.simulate(system, pushed(system, force=0.1, steps=2000, dt=1e-5))
        times.append(time.perf_counter() - start)
    steps = int(2000 * seconds / min(times))
    return system, pushed(system, force=0.1, steps=steps, dt=1e-5)


# A call, and the time of its motion. A backward sweep takes less time than the motion.
CALLS = {
    "motion": (ha.simulate, 0.4),
    "gradient": (ha.gradient, 0.5),
    "motions": (lambda system, inputs, **progress: ha.gradients(system, [inputs] * 8, **progress)[0], 0.1),
}


@pytest.mark.parametrize("task", CALLS)
def test_long_calls_show_progress(task, shown):
    call, seconds = CALLS[task]
    system, inputs = long_motion(seconds)
    with_bar, text = call(system, inputs, progress=True), shown()
    assert f"{task}: " in text and "%" in text and f"/{8 if task == 'motions' else len(inputs.times)} " in text
    shares = [(int(percent), 100 * int(done) / int(of)) for percent, done, of in re.findall(r"(\d+)%\|[^\r]*, (\d+)/(\d+) ", text)]
    assert shares and all(abs(percent - share) <= 0.5 for percent, share in shares)
    silent = call(system, inputs)
    assert shown() == ""
    if task == "motion":
        assert np.array_equal(with_bar.q, silent.q)
    else:
        assert_same(with_bar, silent)


def test_a_long_solver_shows_progress(shown):
    system, inputs = long_motion(0.5)
    ha.LongSolver(system, 10**8, progress=True).gradient(inputs)
    assert "gradient: " in shown()


def test_short_calls_show_nothing(capsys):
    system = cart_with_links()[0].compile()
    ha.Solver(system, progress=True).gradient(pushed(system))
    assert capsys.readouterr().err == ""


def test_optimisers_show_iterates(shown):
    scene, force, _ = cart_with_links(1)
    # Without it, J has many minima of 0, some of which are inaccurate on this grid.
    scene.effort("effort", force, 1e-4)
    system = scene.compile()
    iterates = []
    inputs = pushed(system, 1.0, 40, 0.02)
    ha.minimise(system, inputs, [force], method="L-BFGS", iterations=5, progress=True, callback=lambda *of: iterates.append(of))
    text = shown()
    assert "iterates: " in text and "violation=" in text and len(iterates) > 3
    problem = ha.Problem(system, inputs, [force])
    problem.homotopy(lambda inputs, s: None, progress=True, iterations=3)
    assert "iterates: " in shown()
    alone = problem.solve(starts=3, iterations=20)
    assert problem.solve(starts=3, iterations=20, progress=True).value == alone.value
    text = shown()
    assert "iterates: " in text and "stationarity=" in text and "nan" not in text
    starts = [problem.start + of for of in np.linspace(0.0, 1.0, 100)]
    expected = problem.multi_start(starts, "L-BFGS", iterations=20)
    found = problem.multi_start(starts, "L-BFGS", iterations=20, progress=True)
    assert [of.value for of in found] == [of.value for of in expected]


def test_bars_end_with_their_call(monkeypatch, shown):
    system, inputs = long_motion()
    solver = ha.Solver(system, progress=True)
    bars = []
    close = _progress.Bar.close
    monkeypatch.setattr(_progress.Bar, "close", lambda bar: (bars.append(bar._bar), close(bar)))
    solver.simulate(inputs)
    assert bars[-1] is not None and bars[-1].disable

    def fail(*_):
        raise RuntimeError("no terminal")

    monkeypatch.setattr(_progress.Bar, "__call__", fail)
    with pytest.raises(RuntimeError, match="no terminal"):
        solver.simulate(inputs)
    monkeypatch.undo()
    assert_same(solver.gradient(pushed(system)), ha.gradient(system, pushed(system)))
