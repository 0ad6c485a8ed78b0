"""Motions as tables of pandas and xarray."""

import csv
import io

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from scenes import cart_with_links, pushed


def moved():
    scene, force, angles = cart_with_links()
    system = scene.compile()
    return ha.simulate(system, pushed(system, steps=10)), force, angles


def test_pandas():
    pytest.importorskip("pandas")
    motion, force, angles = moved()
    frame = motion.to_pandas()
    header, *rows = csv.reader(io.StringIO(motion.to_csv()))
    assert [frame.index.name, *frame.columns] == header
    assert np.array_equal(np.column_stack([frame.index, frame]), np.array(rows, dtype=float))
    assert np.array_equal(frame["link 2.φ [rad]"], motion[angles[1]]) and np.array_equal(frame["v of cart.x [m/s]"], motion.v[0])


def test_xarray():
    pytest.importorskip("xarray")
    motion, force, angles = moved()
    data = motion.to_xarray()
    assert np.array_equal(data.q.sel(coordinate="link 2.φ"), motion[angles[1]])
    assert np.array_equal(data.u.sel(control=force.name), motion[force])
    assert np.array_equal(data.sigma.sel(equation="hinge 1.1"), motion.sigma[motion.system.equations.index("hinge 1.1")])
    assert data.sizes == {"coordinate": 12, "time": 11, "equation": 8, "control": 1} and np.array_equal(data.time, motion.times)


def test_events_have_several_rows():
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    scene = ha.Scene()
    scene.gravity(0.0, -9.81)
    ball = scene.particle("ball", 1.0, (0.0, 1.0))
    floor = scene.rigid_contact("floor", ha.GROUND.at(0.0, 0.0), ball.point(), normal=0.5 * np.pi)
    scene.impact_at_event(scene.find("floor", "event"), equation=floor[0], restitution=0.7)
    system = scene.compile()
    solver = ha.Solver(system)
    inputs = solver.find_phases(system.at_rest(40, 0.02), 8)
    motion = solver.simulate(inputs)
    node = inputs.events[0][1]
    frame, data = motion.to_pandas(), motion.to_xarray()
    speeds = frame.loc[motion.times[node], "v of ball.y [m/s]"].to_numpy()
    assert len(frame) == motion.computed and speeds[0] < 0.0 < speeds[-1] == pytest.approx(-0.7 * speeds[0])
    after = data.drop_duplicates("time", keep="last").v.sel(coordinate="ball.y", time=motion.times[node])
    assert float(after) == speeds[-1]
