"""Motion and exact gradients of constrained multibody systems in Hamilton's canonical form.

>>> import hamiltonian_adjoint as ha
>>> scene = ha.Scene()
>>> cart = scene.coordinates("cart", ["x"])
>>> mass = scene.design("mass", 2.0)
>>> force = scene.control("force")
>>> scene.kinetic_energy("motion", 0.5 * mass * cart.x.v**2)
>>> scene.force("drive", {cart.x: force - 0.1 * cart.x.v})
>>> scene.cost("end", 0.5 * (cart.x - 1.0) ** 2, sum="terminal")
>>> system = scene.compile()
>>> inputs = system.at_rest(100, 0.01)
>>> inputs[force] = 1.0
>>> gradient = ha.gradient(system, inputs)
>>> round(gradient.value, 4)
0.2843
>>> gradient[force].shape
(101,)
"""

from typing import TYPE_CHECKING as _TYPE_CHECKING

from ._check import Report, check, check_gradient
from ._errors import Error, FileError, InputError, MotionError, MotionWarning, OptimiseError, SceneError
from ._estimate import Derivative, Estimate, estimate
from ._expression import Condition, Expression, Symbol, maximum, minimum, t, where
from ._free import Free, free, step_length
from ._functions_of_time import constant, constant_speed, harmonic
from ._grid import graded_steps, steps_through
from ._hamiltonian_adjoint import __version__
from ._handles import GROUND, Body, Control, Coordinate, Design, Equation, Event, Group, Joint, Marker, Output, Particle, Point, SpaceBody
from ._identify import Table
from ._mechanics import MarkerState, Mechanics
from ._objective import Objective
from ._operating_point import Equilibrium, LinearModel, Sensitivity
from ._optimise import MultipleShooting, Problem, Trials, minimise, solve
from ._names import suggestion as _suggestion
from ._optimum import Attempt, Iterate, Optimum, OptimumDerivative, lowest
from ._robot import JointData, Robot
from ._scene import Scene, cart_pendulum
from ._solver import LongSolver, Motion, Solver, gradient, gradients, simulate
from ._sums import after_event, at_event, node
from ._system import Gradient, Inputs, System

__all__ = [
    "Attempt",
    "Body",
    "Condition",
    "Control",
    "Coordinate",
    "Derivative",
    "Design",
    "Equation",
    "Equilibrium",
    "Error",
    "Estimate",
    "Event",
    "Expression",
    "FileError",
    "Free",
    "GROUND",
    "Gradient",
    "Group",
    "InputError",
    "Inputs",
    "Iterate",
    "Joint",
    "JointData",
    "LinearModel",
    "LongSolver",
    "Marker",
    "MarkerState",
    "Mechanics",
    "Motion",
    "MotionError",
    "MotionWarning",
    "MultipleShooting",
    "Objective",
    "OptimiseError",
    "Optimum",
    "OptimumDerivative",
    "Output",
    "Particle",
    "Point",
    "Problem",
    "Report",
    "Robot",
    "Scene",
    "SceneError",
    "Sensitivity",
    "Solver",
    "SpaceBody",
    "Symbol",
    "System",
    "Table",
    "Trials",
    "__version__",
    "after_event",
    "at_event",
    "cart_pendulum",
    "check",
    "check_gradient",
    "constant",
    "constant_speed",
    "estimate",
    "free",
    "gradient",
    "gradients",
    "graded_steps",
    "harmonic",
    "lowest",
    "maximum",
    "minimise",
    "minimum",
    "node",
    "simulate",
    "solve",
    "step_length",
    "steps_through",
    "t",
    "where",
]

if not _TYPE_CHECKING:

    def __getattr__(name: str) -> object:
        known = [] if name.startswith("_") else __all__
        raise AttributeError(f"module `hamiltonian_adjoint` has no attribute {name!r}{_suggestion(name, known, 0)}")
