"""Estimates of errors that the grid causes."""

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from test_identify import oscillator


def oscillation(steps, **parts):
    scene, x, stiffness = oscillator(4.0)
    scene.cost("J", 0.5 * x**2, sum=parts.get("sum", "integral"))
    system = scene.compile()
    return system, system.at_rest(steps, 1.0 / steps), stiffness, x


def test_an_oscillation():
    system, inputs, stiffness, x = oscillation(64)
    found = ha.estimate(system, inputs)
    # J = ½ ∫ cos²(ω t) dt = ¼ + sin(2 ω)/(8 ω) with ω = √k
    w = 2.0
    truth, slope = 0.25 + np.sin(2 * w) / (8 * w), (np.cos(2 * w) / (4 * w) - np.sin(2 * w) / (8 * w**2)) / (2 * w)
    exact = ha.gradient(system, inputs)
    assert found.withdrawn is None and found.value == exact.value and found.gradient[stiffness] == exact[stiffness]
    assert abs(found.value - truth) < found.uncertainty < 10 * abs(found.value - truth)
    assert abs(found.corrected.value - truth) < 0.01 * abs(found.value - truth)
    assert found.value + found.residual == pytest.approx(truth, abs=0.01 * found.uncertainty)
    by = {of.of: of for of in found.derivatives}
    assert list(by) == ["`stiffness`", "q₀ of `block.x`", "v₀ of `block.x`"]
    one = by["`stiffness`"]
    assert one.value == exact[stiffness] and abs(one.value - slope) < one.uncertainty < 10 * abs(one.value - slope)
    assert 0.0 < found.gradient_uncertainty < 0.01 and str(found).startswith("J = 0.2") and "±" in str(found)
    start, end, share = found.largest
    assert 0.0 <= start < end <= 1.0 and 0.5 <= share <= 1.0
    finer = ha.estimate(*oscillation(128)[:2], scheme="ESDIRK4")
    assert finer.uncertainty < 0.01 * found.uncertainty and finer.residual is None


def test_what_cannot_be_estimated():
    found = ha.estimate(*oscillation(64, sum=ha.node(3))[:2])
    assert found.uncertainty is None and found.corrected is None and found.derivatives == [] and "read at a single node" in found.withdrawn
    system, inputs, *_ = oscillation(8)
    inputs.q[:] = np.nan
    with pytest.raises(ha.InputError):
        ha.estimate(system, inputs)
    with pytest.raises(TypeError, match="there is no setting"):
        ha.estimate(system, inputs, grid=3)
