"""Messages of the library name what exists in Python."""

import pathlib
import re

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from hamiltonian_adjoint._errors import in_python
from scenes import rope_of_a_design

SOURCE = pathlib.Path(__file__).parents[2] / "src"
# Methods of optimisation, which are functions in Rust.
METHODS = ("lbfgs", "interior_point", "augmented_lagrangian", "levenberg_marquardt")


def messages():
    """Lines of the library with a name in backticks, comments and tests left out."""
    for path in sorted(SOURCE.rglob("*.rs")):
        for line in path.read_text(encoding="utf-8").split("#[cfg(test)]")[0].splitlines():
            if not line.lstrip().startswith("//") and "`" in line and path.name != "tests.rs":
                yield line.strip().replace("{name}", "name")


def test_names_of_rust_are_translated():
    found = [line for line in messages() if re.search(r"`[\w:]*::", line)]
    assert len(found) > 40
    for line in found:
        assert not re.search(r"`[\w:]*::", in_python(line)), line


def test_names_of_methods_are_translated():
    found = [line for line in messages() if re.search(rf"`({'|'.join(METHODS)})`", line)]
    assert found
    for line in found:
        assert not re.search(rf"`({'|'.join(METHODS)})`", in_python(line)), line


def test_what_messages_say_instead():
    scene = ha.Scene()
    bob = scene.particle("bob", 1.0, (1.1, 0.0))
    scene.distance("rope", ha.GROUND.at(0, 0), bob, length=1.0)
    force = scene.control("force")
    scene.force("push", {bob.x: force})
    scene.output("end", bob.x - 1.0, sum="terminal")
    system = scene.compile()
    inputs = system.at_rest(5, 0.01)
    with pytest.raises(ha.MotionError, match=r"correct `inputs.q`, compute it with `inputs.assemble\(\)`, or increase `position_tolerance` of the settings"):
        ha.simulate(system, inputs)
    inputs.assemble()
    with pytest.raises(ha.InputError, match="that are not `None` .*use 'augmented Lagrangian' for constraints or 'Levenberg-Marquardt'"):
        ha.minimise(system, inputs, [force], method="L-BFGS")
    with pytest.raises(ha.Error, match="`stationarity` is -1"):
        ha.minimise(system, inputs, [force], stationarity=-1.0)
    inputs.steps[0] = 0.0
    with pytest.raises(ha.InputError, match="beside longer ones, without costs on rates of controls$"):
        ha.simulate(system, inputs)
    inputs.steps[0], inputs.stages = 0.01, 0
    with pytest.raises(ha.InputError, match="`inputs.stages` is 0"):
        ha.simulate(system, inputs)


def test_warnings_have_names_of_python():
    system = rope_of_a_design().compile()
    with pytest.warns(ha.MotionWarning, match=r"use `inputs.assemble\(\)`"):
        found = ha.gradient(system, system.at_rest(5, 0.01))
    assert np.isfinite(found.value) and "::" not in found.warnings[0][1]
