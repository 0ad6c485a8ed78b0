"""Figures by matplotlib."""

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from scenes import cart_with_links, pushed

pytest.importorskip("matplotlib").use("agg")
import matplotlib.pyplot as plt  # noqa: E402


@pytest.fixture
def motion():
    system = cart_with_links(2)[0].compile()
    yield ha.simulate(system, pushed(system))
    plt.close("all")


def test_a_motion_is_drawn_by_kind_and_unit(motion):
    axes = motion.plot()
    labels = ["coordinates [m]", "coordinates [rad]", "velocities [m/s]", "velocities [rad/s]", "force on the cart [N]"]
    assert [of.get_ylabel() for of in axes] == labels
    assert [len(of.lines) for of in axes] == [6, 3, 6, 3, 1]
    assert axes[-1].get_xlabel() == "time [s]" and axes[0].get_xlabel() == ""
    line = axes[2].lines[2]
    assert line.get_label() == "link 1.x.v" and np.array_equal(line.get_ydata(), motion.v[3]) and np.array_equal(line.get_xdata(), motion.times)


def test_quantities_are_chosen(motion):
    scene = motion.system.scene
    phi, hinge = scene["link 1"].phi, scene["hinge 1"]
    one = motion.plot(phi.v, linestyle="--")
    assert one.get_ylabel() == "link 1.φ.v [rad/s]" and one.lines[0].get_linestyle() == "--"
    axes = motion.plot("cart.x", scene["cart"].x.p, scene["cart"].x.p_dot, phi.p_dot, hinge, "force on the cart")
    units = ["cart.x [m]", "cart.x.p [N s]", "cart.x.p_dot [N]", "link 1.φ.p_dot [N m]", "multipliers [N s]", "force on the cart [N]"]
    assert [of.get_ylabel() for of in axes] == units
    assert np.array_equal(axes[4].lines[1].get_ydata(), motion[hinge[1].sigma])
    assert np.array_equal(motion["force on the cart"], motion.controls[0])


def test_motions_share_axes(motion):
    axes = motion.plot("cart.x", "link 1.φ")
    assert motion.plot("cart.x", "link 1.φ", ax=axes) is axes and [len(of.lines) for of in axes] == [2, 2]
    one = motion.plot("cart.x")
    assert motion.plot("cart.x", "link 1.φ", ax=one) is one and len(one.lines) == 3
    # Axes of several units have no unit.
    assert one.get_ylabel() == "" and [line.get_label() for line in one.lines[1:]] == ["cart.x [m]", "link 1.φ [rad]"]
    with pytest.raises(ha.InputError, match="2 axes were given, but these quantities need 3"):
        motion.plot("cart.x", "link 1.φ", "force on the cart", ax=axes)


def test_many_lines_can_be_told_apart():
    system = cart_with_links(7)[0].compile()
    axes = ha.simulate(system, pushed(system, steps=2)).plot()
    figure = axes[0].figure
    figure.canvas.draw()
    boxes = [of.get_legend().get_window_extent() for of in axes[:4]]
    assert all(above.y0 > below.y1 for above, below in zip(boxes, boxes[1:])) and boxes[0].y1 < figure.bbox.y1
    looks = [(line.get_color(), line.get_linestyle()) for line in axes[0].lines]
    assert len(looks) == 16 == len(set(looks))
    own = plt.subplots()[1]
    ha.simulate(system, pushed(system, steps=2)).plot("cart.x", "link 1.φ", "force on the cart", ax=own)
    own.figure.canvas.draw()
    box = own.get_legend().get_window_extent()
    assert own.bbox.x0 < box.x0 and box.x1 < own.bbox.x1
    plt.close("all")


def test_mistakes(motion):
    scene = motion.system.scene
    with pytest.raises(KeyError, match="no coordinate or control has the name `cart.z`"):
        motion.plot("cart.z")
    with pytest.raises(KeyError, match="no values of `m`"):
        motion.plot(ha.Scene().design("m", 1.0))
    with pytest.raises(TypeError, match="coordinates, velocities, controls"):
        motion.plot(1.0)
    with pytest.raises(KeyError, match="has no `other`"):
        motion.plot(scene.control("other"))


def test_the_history_of_an_optimisation_is_drawn():
    scene = ha.Scene()
    (x,) = scene.coordinates("cart", ["x"])
    force = scene.control("force")
    scene.kinetic_energy("motion", 0.5 * x.v**2)
    scene.force("push", {x: force - 0.1 * x.v})
    scene.cost("effort", 0.5 * force**2, sum="integral")
    scene.output("end", x - 1.0, sum="terminal")
    system = scene.compile()
    found = ha.minimise(system, system.at_rest(20, 0.05), [force])
    value, rest = found.plot()
    assert list(value.lines[0].get_ydata()) == [at.value for at in found.history]
    assert [of.get_label() for of in rest.lines] == ["violation", "stationarity"] and rest.get_yscale() == "log"
    assert rest.get_xlabel() == "iteration"
    value.figure.canvas.draw()
    with pytest.raises(ha.InputError, match="needs two"):
        found.plot(ax=value)
    plt.close("all")


def test_names_are_not_formulas():
    scene = ha.Scene()
    names = ["a$b", "c_{d}$^", "100%", "q\"uo'te", "наклон", "x\\frac", "_x"]
    group = scene.coordinates("$g^{", names)
    for x in group:
        scene.kinetic_energy(f"energy of {x.name}", 0.5 * x.v**2)
    controls = [scene.control(name) for name in ("$F_1^$ %s {0}", "_G")]
    scene.force("$", {group[0]: controls[0], group[1]: controls[1]})
    system = scene.compile()
    motion = ha.simulate(system, system.at_rest(2, 0.1))
    axes = motion.plot()
    plt.gcf().canvas.draw()
    assert [text.get_text() for text in axes[-1].get_legend().get_texts()] == [r"\$F_1^\$ %s {0}", " _G"]
    assert motion.plot(controls[0]).get_ylabel() == r"\$F_1^\$ %s {0}"
    plt.gcf().canvas.draw()
    plt.close("all")


@pytest.mark.parametrize("steps", [0, 1])
def test_short_motions_are_drawn(steps):
    scene, force, _ = cart_with_links(1)
    scene.cost("effort", force**2, sum="integral")
    system = scene.compile()
    axes = ha.simulate(system, system.at_rest(steps, 0.1)).plot()
    plt.gcf().canvas.draw()
    assert len(axes[0].lines[0].get_xdata()) == steps + 1
    plt.close("all")
