"""Checks of gradients and Jacobians."""

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from scenes import cart_with_links, pushed
from test_files import own


def test_gradients_of_formulas_are_right():
    system = own().compile()
    inputs = system.at_rest(15, 0.02)
    inputs.controls[:] = np.sin(inputs.times)
    inputs.v[:2] = -0.2, 0.3  # away from the kink at v = 0
    report = ha.check_gradient(system, inputs, complete=True)
    report.assert_passed()
    assert report and report.verdict == "Right" and "by direct diff." in repr(report)
    ha.check_gradient(system, inputs, output="end").assert_passed()


def test_no_output_with_a_name():
    system = cart_with_links()[0].compile()
    with pytest.raises(ha.InputError, match="no output `end`"):
        ha.check_gradient(system, pushed(system), output="end")
    with pytest.raises(ha.InputError, match="no output `ends`; did you mean `end`?"):
        system = own().compile()
        ha.check_gradient(system, system.at_rest(5, 0.02), output="ends")


def polar(x):
    r, phi = x
    return [r * np.cos(phi), r * np.sin(phi)]


def right(x):
    return [[np.cos(x[1]), -x[0] * np.sin(x[1])], [np.sin(x[1]), x[0] * np.cos(x[1])]]


def test_jacobians():
    ha.check(polar, right, [1.0, 0.3]).assert_passed()
    ha.check(lambda x: np.sum(x**2), lambda x: 2 * x, [1.0, 0.3, 2.0]).assert_passed()
    ha.check(lambda x: x[0] ** 3, lambda x: 3 * x**2, [[1.0], [2.0]], random_points=0).assert_passed()
    wrong = ha.check(polar, lambda x: np.abs(right(x)), [1.0, 0.3], names=["r", "φ"], outputs=["x", "y"], random_points=0)
    assert not wrong and "sign flipped in d(`x`)/d(`φ`)" in wrong.text
    with pytest.raises(AssertionError, match="sign flipped"):
        wrong.assert_passed()


def test_a_jacobian_that_fails():
    with pytest.raises(ZeroDivisionError):
        ha.check(polar, lambda x: 1 / 0, [1.0, 0.3])
    assert not ha.check(polar, lambda x: np.zeros((3, 2)), [1.0, 0.3])


def test_control_c_ends_a_check():
    points = []

    def interrupted(x):
        points.append(x)
        if len(points) == 3:
            raise KeyboardInterrupt
        return right(x)

    with pytest.raises(KeyboardInterrupt):
        ha.check(polar, interrupted, [1.0, 0.3])
    assert len(points) == 3
