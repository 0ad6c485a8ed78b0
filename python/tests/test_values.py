"""Values of quantities and formulas along a motion."""

import hamiltonian_adjoint as ha
import numpy as np
import pytest


def pendulum():
    """A bob of 2 kg on a massless rod of length 1, with a horizontal force."""
    scene = ha.Scene()
    scene.gravity(0.0, -9.81)
    mass = scene.design("mass", 2.0)
    bob = scene.particle("bob", mass, (1.0, 0.0))
    rod = scene.distance("rod", ha.GROUND.at(0, 0), bob, length=1.0)
    force = scene.control("force")
    scene.force("push", {bob.x: force})
    for node in (0, 7, 40):
        scene.output(f"a{node}", bob.x.a, sum=ha.node(node))
        scene.output(f"lam{node}", rod[0].lam, sum=ha.node(node))
    system = scene.compile()
    inputs = system.at_rest(40, 0.01)
    inputs[force] = np.sin(9.0 * inputs.times)
    inputs[mass] = 1.5
    return bob, rod, force, mass, system, inputs


def test_accelerations_and_reactions_are_those_of_outputs():
    bob, rod, force, mass, system, inputs = pendulum()
    solver = ha.Solver(system)
    motion = solver.simulate(inputs)
    of = dict(zip(system.outputs, solver.outputs()))
    for node in (0, 7, 40):
        assert motion[bob.x.a][node] == pytest.approx(of[f"a{node}"], rel=1e-12, abs=1e-12)
        assert motion[rod[0].lam][node] == pytest.approx(of[f"lam{node}"], rel=1e-12, abs=1e-12)
    assert motion.a.shape == (2, 41) and motion.lam.shape == (1, 41)
    assert motion[rod[0].lam] is not None and np.array_equal(motion[bob.y.a], motion.a[1])
    # Without rounding errors, Newton's law along the rod: m ẍ = F − x λ' with the same λ' in both directions.
    along_x = inputs[force] - 1.5 * motion[bob.x.a]
    along_y = -1.5 * 9.81 - 1.5 * motion[bob.y.a]
    assert along_x * motion[bob.y] == pytest.approx(along_y * motion[bob.x], abs=1e-9)


def test_formulas():
    bob, rod, force, mass, system, inputs = pendulum()
    motion = ha.simulate(system, inputs)
    x, y = bob.x, bob.y
    q, v = motion.q, motion.v
    energy = 0.5 * mass * (x.v**2 + y.v**2) + 9.81 * mass * y
    assert motion[energy] == pytest.approx(0.75 * (v[0] ** 2 + v[1] ** 2) + 9.81 * 1.5 * q[1], rel=1e-14)
    assert motion[x + x.a] == pytest.approx(q[0] + motion.a[0], rel=1e-14)
    assert motion[ha.t * 2.0] == pytest.approx(2.0 * motion.times)
    assert motion[mass].tolist() == [1.5] * 41 and np.array_equal(motion[ha.t], motion.times)
    assert motion[ha.where(x < 0.9, force, -y)] == pytest.approx(np.where(q[0] < 0.9, inputs[force], -q[1]))
    assert motion[np.hypot(x, y) - 1.0] == pytest.approx(motion.phi[0], abs=1e-4)
    deep = x
    for _ in range(3000):
        deep = deep + 1.0
    assert motion[deep] == pytest.approx(q[0] + 3000.0)
    with pytest.raises(ha.InputError, match=r"is nan at node \d+ \(t = .* s\)"):
        motion[np.sqrt(x - 0.99)]


def test_mistakes():
    bob, rod, force, mass, system, inputs = pendulum()
    motion = ha.simulate(system, inputs)
    with pytest.raises(KeyError, match="no values of `force.rate`; it has those of coordinates"):
        motion[force.rate]
    with pytest.raises(KeyError, match="no values of `force.rate`"):
        motion[2.0 * force.rate]
    with pytest.raises(KeyError, match="no values of `<equation rod>`"):
        motion[rod[0]]
    other = ha.Scene().coordinates("other", ["x"]).x
    with pytest.raises(ha.SceneError, match="`other.x.a` belongs to another scene"):
        motion[other.a]
    with pytest.raises(ha.SceneError, match="`other.x` belongs to another scene"):
        motion[other + 1.0]


def test_plots():
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("agg")
    bob, rod, force, mass, system, inputs = pendulum()
    motion = ha.simulate(system, inputs)
    axes = motion.plot(bob.x.a, rod[0].lam, 0.5 * mass * bob.x.v**2)
    assert len(axes) == 3 and axes[0].get_ylabel() == "bob.x.a [m/s²]" and axes[1].get_ylabel() == "rod.lam [N]"
    assert np.array_equal(axes[2].lines[0].get_ydata(), motion[0.5 * mass * bob.x.v**2])
    pyplot.close("all")
