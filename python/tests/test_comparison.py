"""The four-bar linkage of the comparison with other libraries, against reference values of an independent program."""

import json
import pathlib
import re
import sys

import numpy as np
import pytest

PROGRAMS = pathlib.Path(__file__).parent.parent.parent / "paper-repro" / "peers" / "four_bar"
REFERENCE = json.loads((PROGRAMS / "reference.json").read_text(encoding="utf-8"))
EXPECTED = [REFERENCE[name] for name in ("J", "dJ/dtorque", "dJ/dlength")]


@pytest.fixture
def programs(monkeypatch):
    """The modules of the task and of this package."""
    monkeypatch.syspath_prepend(str(PROGRAMS))
    import crate_four_bar
    import task

    yield task, crate_four_bar
    for name in ("crate_four_bar", "task"):
        del sys.modules[name]


def errors(programs, scheme, steps):
    """Relative errors of J and of its derivatives with respect to the torques and the length."""
    task, crate_four_bar = programs
    value, gradient = crate_four_bar.functions(steps, scheme=scheme)
    found = gradient(task.TORQUES, task.COUPLER)
    assert value(task.TORQUES, task.COUPLER) == found[0]
    return [np.abs(np.subtract(of, expected)).max() / np.abs(expected).max() for of, expected in zip(found, EXPECTED)]


def test_the_programs_of_the_page_are_accurate_to_1e_5(programs):
    for scheme, steps in programs[1].SCHEMES.items():
        assert max(errors(programs, scheme, steps)) < 1e-5


@pytest.mark.parametrize("scheme, steps, order", [("trapezoidal rule", 1000, 2), ("ESDIRK4", 320, 4), ("ESDIRK5", 320, 5)])
def test_values_and_derivatives_converge_with_the_order_of_the_scheme(programs, scheme, steps, order):
    coarse, fine = errors(programs, scheme, steps), errors(programs, scheme, 2 * steps)
    assert max(fine) < 1.1 * 2.0**-order * max(coarse)


def test_the_reference_agrees_with_a_second_formulation():
    assert abs(REFERENCE["J in absolute coordinates"] - REFERENCE["J"]) < 1e-12
    assert abs(REFERENCE["dJ/dlength as a difference quotient"] - REFERENCE["dJ/dlength"]) < 1e-7


def test_the_page_has_the_text_from_which_it_is_written():
    page = (PROGRAMS.parents[2] / "docs" / "comparison.md").read_text(encoding="utf-8")
    for text in re.split(r"<!-- \w+ -->", (PROGRAMS / "page.md").read_text(encoding="utf-8")):
        assert text in page
