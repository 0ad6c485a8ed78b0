"""What people type wrong, and what they are told."""

import math
import re

import hamiltonian_adjoint as ha
import numpy as np
import pytest
from scenes import rope_of_a_design


class Given:
    """A scene with a body, a particle, a control and a design variable."""

    def __init__(self):
        self.s = self.scene = ha.Scene()
        self.cart = self.scene.coordinates("cart", ["x"])
        self.x = self.cart.x
        self.rod = self.scene.body("rod", 1.0, 0.1)
        self.ball = self.scene.particle("ball", 1.0)
        self.force = self.scene.control("force")
        self.m = self.scene.design("mass", 2.0)
        self.other = ha.Scene()
        self.foreign = self.other.coordinates("other", ["x"]).x
        self.scene.kinetic_energy("motion of the cart", self.m * self.x.v**2)

    @property
    def system(self):
        return self.scene.compile()

    @property
    def inputs(self):
        return self.system.at_rest(10, 0.01)


def branch(g):
    if g.x > 0:
        return g.x


def later(g, name=None):
    inputs = g.inputs
    late = g.scene.control("late")
    inputs[name or late] = 1.0


def late_keys(g, read):
    """Reads values of a coordinate and an equation that are added after the simulation."""
    motion = ha.simulate(g.system, g.inputs)
    system, scene = motion.system, g.scene
    late, rope = scene.coordinates("late", ["x"]).x, scene.distance("rope", ha.GROUND.at(0, 0), g.rod.at(1, 0), 2.0)
    read(motion, ha.Mechanics(system), late, rope[0])


MISTAKES = [
    (lambda g: math.sin(g.x), TypeError, "use functions of numpy, such as numpy.sin(x)"),
    (lambda g: float(g.x * 2), TypeError, "cart.x * 2 has no value while the formula is written"),
    (lambda g: branch(g), TypeError, "write `where(x < y, a, b)`"),
    (lambda g: 0 < g.x < 1, TypeError, "chain of comparisons"),
    (lambda g: g.x > 0 and g.x < 1, TypeError, "`and`"),
    (lambda g: not g.x, TypeError, "`not`"),
    (lambda g: max(g.x, 0.0), TypeError, "`maximum(x, y)`"),
    (lambda g: np.where(g.x > 0, 1.0, 2.0), TypeError, "write `where(x < y, a, b)`"),
    (lambda g: g.x == 0, TypeError, "`==` of an expression is not known"),
    (lambda g: ha.where(g.x, 1.0, 2.0), TypeError, "must be a comparison such as `x < y`"),
    (lambda g: np.heaviside(g.x, 0.0), TypeError, "numpy.heaviside has no formula"),
    (lambda g: np.add.reduce(g.x), TypeError, "make an array of them"),
    (lambda g: g.x + "1", TypeError, "unsupported operand"),
    (lambda g: g.x * math.nan, ValueError, "numbers must be finite"),
    (lambda g: (-2.0) ** g.x, ValueError, "must be positive"),
    (lambda g: g.s.kinetic_energy(0.5 * g.x.v**2, "T"), TypeError, "the first argument is the name of the part"),
    (lambda g: g.s.kinetic_energy("T", g.x.a**2), ha.SceneError, "reads `cart.x.a`, but such a formula may read coordinates, velocities"),
    (lambda g: g.s.force("F", {g.x: g.x.p}), ha.SceneError, "reads `cart.x.p`"),
    (lambda g: g.s.force("F", {g.x.v: 1.0}), TypeError, "keys of its formulas must be coordinates"),
    (lambda g: g.s.force("F", [1.0, 2.0], q=[g.x]), ha.SceneError, "force `F`: 2 formulas for 1 coordinate;"),
    (lambda g: g.s.force("F", {g.x: 1.0}, q=[g.x]), TypeError, "`q` is not needed"),
    (lambda g: g.s.cost("J", g.foreign**2, sum="terminal"), ha.SceneError, "belongs to another scene"),
    (lambda g: g.s.cost("J", g.x**2), TypeError, "sum"),
    (lambda g: g.s.cost("J", g.x**2, sum="mean"), ha.SceneError, "'mean' is not one of the sums plain"),
    (lambda g: g.s.cost("J", [g.x, g.x], sum="terminal"), ha.SceneError, "must be a single formula"),
    (lambda g: g.s.cost("J", lambda at: at.q[0] > 1, q=[g.x], sum="plain"), TypeError, "cost `J`: cart.x > 1 is not part of a formula"),
    (lambda g: g.s.cost("J", lambda at: None, sum="plain"), TypeError, "None is not part of a formula"),
    (lambda g: g.s.cost("J", "0.5*x", sum="plain"), TypeError, "cost `J` is text, '0.5*x'; write it with handles"),
    (lambda g: g.s.cost("J", g.x**2, sum=ha.node(0.5)), TypeError, "a node must be a whole number, not 0.5"),
    (lambda g: g.s.output("J", g.x), TypeError, "the sum of its formula is missing"),
    (lambda g: g.s.revolute("hinge", g.rod, g.rod.at(1, 0)), TypeError, "`a` must be a point, such as rod.at(0.5, 0)"),
    (lambda g: g.s.joint_friction("f", g.rod.at(0, 0), ha.GROUND, damping=1), TypeError, "`a` must be a body or GROUND"),
    (lambda g: g.s.revolute("hinge", g.rod.at(1, 0)), TypeError, "missing 1 required positional argument: 'b'"),
    (lambda g: g.s.distance("d", g.rod.at(0, 0), g.ball, lenght=1), TypeError, "unexpected keyword argument 'lenght'"),
    (lambda g: g.s.body("b", g.x, 1.0), ha.SceneError, "`cart.x` changes during the motion"),
    (lambda g: g.s.torque_actuator("t", ha.GROUND, g.rod, torque=3.0), TypeError, "`torque` must be a control"),
    (lambda g: g.s.applied_force("f", g.ball, direction=0, motion=3), TypeError, "constant(…), constant_speed(…) or harmonic(…)"),
    (lambda g: g.s.coordinates("g", ["a", "b"], [1.0]), ha.SceneError, "1 initial value for 2 coordinates"),
    (lambda g: g.s.place("cart.y", 1.0), ha.SceneError, "no coordinate `cart.y`"),
    (lambda g: g.s.design("a`b", 1.0), ha.SceneError, "must not contain a backtick"),
    (lambda g: g.cart.y, AttributeError, "the coordinates are cart.x"),
    (lambda g: g.s["cart.z"], KeyError, "the scene has no part with the name `cart.z`"),
    (lambda g: (g.s.control("force"), g.s.compile()), ha.SceneError, "more than one control has the name `force`"),
    (lambda g: ha.Scene().compile(), ha.SceneError, "coordinates"),
    (lambda g: g.s.body("b", -1.0, 1.0) and g.s.compile(), ha.Error, "the mass of `b`"),
    (lambda g: g.system.at_rest(100), TypeError, "at_rest(100, 0.01)"),
    (lambda g: g.system.at_rest(-1, 0.1), ha.InputError, "must not be negative"),
    (lambda g: ha.Inputs(g.scene, 100, 0.1), TypeError, "scene.compile()"),
    (lambda g: setattr(g.inputs, "controls", np.zeros(11)), ha.InputError, "has the shape (11,), but this system and grid need (1, 11)"),
    (lambda g: setattr(g.inputs, "control", 1.0), AttributeError, "inputs have no attribute 'control'"),
    (lambda g: g.inputs[g.x.a], TypeError, "inputs are chosen by a control"),
    (lambda g: g.inputs["forces"], KeyError, "no input has the name `forces`"),
    (lambda g: ha.gradient(g.system, 10.0), TypeError, "system.at_rest(100, 0.01)"),
    (lambda g: ha.gradient(g.scene, g.inputs), TypeError, "a system such as scene.compile() is expected"),
    (lambda g: ha.gradient(g.system, g.inputs, tolerence=1e-9), TypeError, "there is no setting `tolerence`"),
    (lambda g: ha.gradient(g.system, g.inputs, scheme="euler"), ha.InputError, "the schemes are 'trapezoidal rule', 'TR-BDF2'"),
    (lambda g: ha.gradient(g.system, ha.cart_pendulum(1).compile().at_rest(3, 0.1)), ha.InputError, "belong to another system"),
    (lambda g: (g.s.cost("J", g.x, sum=ha.node(30)), ha.gradient(g.system, g.inputs)), ha.InputError, "(`sum=node(i)`), on a grid with nodes 0 to 10, is 30; it must be"),
    (lambda g: ha.Solver(g.system).gradient(), ha.MotionError, "call `simulate` first"),
    (lambda g: ha.Scene.from_json("{"), ha.FileError, "line 1, column"),
    (lambda g: ha.Scene.from_json("{}"), ha.FileError, "is missing"),
    (lambda g: setattr(g.inputs, "q", [1.0]), ha.InputError, "`q` has the shape (1,)"),
    (lambda g: g.s.force("F", [g.x, -g.x]), TypeError, "force `F`: state the coordinates that it acts on, as {x: formula, y: formula} or by q=[x, y]"),
    (lambda g: g.s.force("F", g.force - g.x.v), TypeError, "state the coordinates"),
    (lambda g: g.s.force("F", lambda at: [-g.x]), TypeError, "state the coordinates"),
    (lambda g: g.s.force("F", lambda at: [-at.v[1]], q=[g.x]), ha.SceneError, "force `F`: list index out of range; of the lists that the formula is called with, `q` has 1"),
    (lambda g: ha.where(g.x == g.m, 1.0, 2.0), TypeError, "True or False already"),
    (lambda g: ha.where([g.x == g.m, g.x < 1], 1.0, 2.0), TypeError, "True or False already"),
    (lambda g: g.x % 1, TypeError, "`%` of an expression has no formula"),
    (lambda g: 1 // g.x, TypeError, "`//` of an expression has no formula"),
    (lambda g: round(g.x), TypeError, "`round` of an expression has no formula"),
    (lambda g: math.floor(g.x), TypeError, "`floor` of an expression has no formula"),
    (lambda g: np.interp(ha.t, [0, 1], [0, 1]), TypeError, "those of a control: inputs[force] = numpy.interp(inputs.times, …)"),
    (lambda g: g.x.velocity, AttributeError, "`.v` is the velocity"),
    (lambda g: g.force.dot, AttributeError, "`.rate` is the rate of a control"),
    (lambda g: (2 * g.x).arcsine, AttributeError, "did you mean `arcsin`"),
    (lambda g: ha.minimize, AttributeError, "did you mean `minimise` or"),
    (lambda g: g.s.spring("s"), AttributeError, "did you mean `spring_damper`"),
    (lambda g: g.s.revolut("s"), AttributeError, "did you mean `revolute`"),
    (lambda g: g.s.place(g.x, math.nan), ha.SceneError, "the initial value of `cart.x` is nan; it must be finite"),
    (lambda g: g.s.place(g.x, g.m), TypeError, "the initial value of `cart.x` must be a number, not mass"),
    (lambda g: g.s.coordinates("g", ["a"], [math.inf]), ha.SceneError, "group `g`: an initial value is inf"),
    (lambda g: g.s.design("b", math.nan), ha.SceneError, "the value of design variable `b` is nan"),
    (lambda g: g.s.design("b", "2kg"), TypeError, "the value of design variable `b` must be a number, not '2kg'"),
    (lambda g: g.s.design(2.0, "b"), TypeError, "the first argument is the name of the part"),
    (lambda g: g.s.body("b", 1.0, 1.0, (0.0, 0.0)), ha.SceneError, "body `b`: `place` has 2 numbers, but the body has 3 coordinates: x, y, φ"),
    (lambda g: g.s.body("b", 1.0, 1.0, (0.0, math.nan, 0.0)), ha.SceneError, "body `b`: a number of `place` is nan"),
    (lambda g: g.s.body("b", math.nan, 1.0), ha.SceneError, "body `b`, `mass`: nan cannot be part of a formula; numbers must be finite"),
    (lambda g: g.s.distance("d", g.ball, g.rod.at(0, 0), g.x), ha.SceneError, "distance `d`, `length`: `cart.x` changes during the motion"),
    (lambda g: g.s.find("rod.z"), KeyError, "or `rod.x`?"),
    (lambda g: g.s["carts.x"], KeyError, "did you mean `cart.x`"),
    (lambda g: g.s.find("Force", "control"), KeyError, "the scene has no control `Force`; did you mean `force`?"),
    (lambda g: (g.s.control("mass"), g.s.find("mass")), KeyError, "a control and of a design variable: choose by scene.find('mass', 'control')"),
    (lambda g: g.inputs["forse"], KeyError, "no input has the name `forse`; did you mean `force`?"),
    (lambda g: ha.steps_through([0.0, 2.0, 1.0], 0.1), ha.InputError, "time 2 of `steps_through`, 1 s, is before time 1, 2 s; sort the times"),
    (lambda g: g.system.at_rest(10, 0.0), ha.InputError, "the length of the steps is 0.0 s"),
    (lambda g: g.inputs.__setitem__(g.force, np.ones(10)), ha.InputError, "`force` must be set to a number, or one for each of the 11 nodes, not to an array of the shape (10,)"),
    (lambda g: g.inputs.__setitem__(g.x.v, [1.0]), ha.InputError, "`cart.x.v` must be set to a number, not to an array of the shape (1,)"),
    (lambda g: g.inputs.__setitem__(g.force, "much"), TypeError, "`force` must be set to numbers, not to 'much'"),
    (lambda g: g.inputs[g.foreign], ha.SceneError, "`other.x` belongs to another scene; use handles of the scene that was compiled"),
    (lambda g: g.inputs["rod"], KeyError, "no input has the name `rod`; did you mean `rod.x` or"),
    (lambda g: late_keys(g, lambda motion, at, x, rope: motion[x.v]), KeyError, "the system has no `late.x.v`: it was added to the scene after this system"),
    (lambda g: late_keys(g, lambda motion, at, x, rope: motion[x * 2]), KeyError, "the system has no `late.x`: it was added to the scene after this system"),
    (lambda g: late_keys(g, lambda motion, at, x, rope: motion["late.x"]), KeyError, "has the name `late.x`: it was added to the scene after this system"),
    (lambda g: late_keys(g, lambda motion, at, x, rope: motion[rope.lam]), KeyError, "the system has no `rope.lam`: it was added to the scene after this system"),
    (lambda g: late_keys(g, lambda motion, at, x, rope: at[x.a]), KeyError, "the system has no `late.x.a`: it was added to the scene after this system"),
    (lambda g: late_keys(g, lambda motion, at, x, rope: at[rope.lam]), KeyError, "the system has no `rope.lam`: it was added to the scene after this system"),
    (lambda g: late_keys(g, lambda motion, at, x, rope: motion["Cart.x"]), KeyError, "no coordinate or control has the name `Cart.x`; did you mean `cart.x`?"),
    (lambda g: late_keys(g, lambda motion, at, x, rope: motion[g.foreign]), ha.SceneError, "`other.x` belongs to another scene"),
    (lambda g: late_keys(g, lambda motion, at, x, rope: at[g.foreign.v]), ha.SceneError, "`other.x.v` belongs to another scene"),
    (lambda g: ha.Mechanics(g.system).position(g.other.body("rod", 1.0, 1.0).at(0, 0)), ha.SceneError, "`rod` belongs to another scene"),
    (lambda g: ha.Mechanics(g.system).position(g.rod.at(g.x, 0)), TypeError, "`cart.x` changes during the motion"),
    (lambda g: g.inputs.at("landing", 3), ha.InputError, "the system has no event `landing`"),
    (lambda g: g.inputs.assemble("cart.X"), ha.InputError, "the system has no coordinate `cart.X`; did you mean `cart.x`?"),
    (lambda g: g.inputs.assemble(g.foreign), ha.SceneError, "`other.x` belongs to another scene"),
    (lambda g: g.s.close_at_event(g.s.event("e", g.x), g.s.constraint("c", g.x)[0]), TypeError, "`equations` must be a list of equations, such as [joint[0]]"),
    (lambda g: later(g), KeyError, "the system has no `late`: it was added to the scene after this system was compiled; compile the scene again"),
    (lambda g: later(g, "late"), KeyError, "no input has the name `late`: it was added to the scene after"),
]


@pytest.mark.parametrize("number", range(len(MISTAKES)))
def test_mistake(number):
    make, kind, message = MISTAKES[number]
    with pytest.raises(kind, match=re.escape(message)) as error:
        make(Given())
    assert "panic" not in str(error.value).lower()


def test_there_are_many():
    assert len(MISTAKES) >= 25


def test_a_refused_part_leaves_the_scene_as_it_was():
    scene = Given().scene
    before = scene.to_json()
    with pytest.raises(ha.SceneError):
        scene._add("force", "drag", q=["cart.x"], formula="nothing * 2")
    assert scene.to_json() == before
    scene.compile()


def test_errors_have_a_common_base():
    for kind in (ha.SceneError, ha.FileError, ha.InputError, ha.MotionError, ha.OptimiseError):
        assert issubclass(kind, ha.Error)
    assert issubclass(ha.SceneError, ValueError) and issubclass(ha.MotionError, ArithmeticError)


def test_motions_that_fail():
    scene = ha.Scene()
    x = scene.coordinates("ball", ["x"], [1.0]).x
    scene.kinetic_energy("motion", 0.5 * x.v**2)
    scene.force("push", {x: 1.0 / (x - 1.0)})
    scene.cost("end", x, sum="terminal")
    system = scene.compile()
    with pytest.raises(ha.MotionError, match="`push`"):
        ha.simulate(system, system.at_rest(10, 0.1))
    good = system.at_rest(10, 0.1)
    good[x] = 3.0
    solver = ha.Solver(system)
    with pytest.raises(ha.MotionError):
        solver.simulate(system.at_rest(10, 0.1))
    assert solver.motion.computed == 0
    assert solver.simulate(good).computed == 11
    first, second = ha.gradients(system, [system.at_rest(10, 0.1), good], errors="return")
    assert isinstance(first, ha.MotionError) and second.value > 3.0
    with pytest.raises(ha.MotionError):
        ha.gradients(system, [good, system.at_rest(10, 0.1)])


def test_warnings_have_kinds():
    system = rope_of_a_design().compile()
    with pytest.warns(ha.MotionWarning, match="arm") as found:
        ha.gradient(system, system.at_rest(5, 0.01))
    assert [warning.category.__name__ for warning in found] == ["GivenStart"]
    assert found[0].filename == __file__


def test_numbers_with_nouns():
    given = Given()
    assert repr(given.system) == "<system of 6 coordinates, 0 constraint equations, 1 control, 1 design variable>"
    assert "1 step to t = 0.1 s, 1 control," in repr(given.system.at_rest(1, 0.1))
    assert repr(given.s.constraint("wall", given.x)) == "<wall with 1 equation>" and repr(ha.Scene()) == "<scene of 0 parts>"


def test_handles_of_scenes_with_the_same_parts():
    """Handles of the scene itself, of a loaded copy and of a scene that has grown are keys; those of a scene with other parts are not."""
    given = Given()
    inputs, again = given.inputs, ha.Scene.from_json(given.scene.to_json())
    inputs[given.force], inputs[again["cart.x"].v] = 2.0, 3.0
    assert inputs[inputs.system.scene["force"]][0] == 2.0 and inputs[given.x.v] == 3.0
    other = Given()
    other.scene.control("second")
    given.scene.gravity(0.0, -1.0)
    inputs = given.inputs
    for handle in (other.force, other.x, other.m):
        with pytest.raises(ha.SceneError, match="another scene"):
            inputs[handle] = 3.0


def test_gradients_without_a_cost():
    scene = ha.Scene()
    x = scene.coordinates("block", ["x"]).x
    scene.kinetic_energy("motion", 0.5 * x.v**2)
    system = scene.compile()
    with pytest.warns(ha.MotionWarning, match="neither a cost nor an output") as found:
        assert ha.gradient(system, system.at_rest(5, 0.1)).value == 0.0
    assert [warning.category.__name__ for warning in found] == ["NothingAsked"] and found[0].filename == __file__
    scene.time("duration", 0.0)
    system = scene.compile()
    assert ha.gradient(system, system.at_rest(5, 0.1)).value == 0.0


def test_motions_backward_in_time():
    scene = ha.Scene()
    x = scene.coordinates("block", ["x"], [1.0]).x
    scene.kinetic_energy("motion", 0.5 * x.v**2)
    scene.force("spring", {x: -x})
    system = scene.compile()
    motion = ha.simulate(system, system.at_rest(100, -0.01))
    assert motion.times[-1] == pytest.approx(-1.0) and motion[x.v][-1] == pytest.approx(math.sin(1.0), rel=1e-4)
