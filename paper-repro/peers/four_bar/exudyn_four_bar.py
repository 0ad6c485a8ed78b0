"""Exudyn: three rigid bodies in the plane with revolute joints; trapezoidal rule with constraints on velocities (index 2).

There are no derivatives of motions; the gradient consists of central difference quotients, as `exudyn.processing.ComputeSensitivities` computes.
"""

import exudyn as exu
import numpy as np
from exudyn import itemInterface as items

import task

STEPS = 7000
WIDTH = 1e-4  # m or N m, of difference quotients


# begin
def linkage(torques, coupler):
    """The assembled system and the node of the rocker."""
    system = exu.SystemContainer().AddSystem()
    ground = system.AddObject(items.ObjectGround())
    angle, of_rocker = task.closure(task.START, coupler)

    def rod(x, y, length, angle):
        """Node and body of a rod that begins at a point; both ends are markers."""
        centre = [x + length / 2 * np.cos(angle), y + length / 2 * np.sin(angle), angle]
        mass = task.DENSITY * length
        node = system.AddNode(items.NodeRigidBody2D(referenceCoordinates=centre))
        body = system.AddObject(items.ObjectRigidBody2D(mass=mass, inertia=mass * length**2 / 12, nodeNumber=node))
        weight = system.AddMarker(items.MarkerBodyMass(bodyNumber=body))
        system.AddLoad(items.LoadMassProportional(markerNumber=weight, loadVector=[0.0, -task.GRAVITY, 0.0]))
        ends = [system.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=[x, 0.0, 0.0])) for x in (-length / 2, length / 2)]
        return node, ends

    _, (a, b) = rod(0.0, 0.0, task.CRANK, task.START)
    _, (b_rod, c_rod) = rod(task.CRANK * np.cos(task.START), task.CRANK * np.sin(task.START), coupler, angle)
    rocker, (d, c) = rod(task.GROUND, 0.0, task.ROCKER, of_rocker)
    fixed = [system.AddMarker(items.MarkerBodyRigid(bodyNumber=ground, localPosition=[x, 0.0, 0.0])) for x in (0.0, task.GROUND)]
    for pair in ([fixed[0], a], [b, b_rod], [c, c_rod], [fixed[1], d]):
        system.AddObject(items.ObjectJointRevolute2D(markerNumbers=pair))
    torque = lambda system, t, load: [0.0, 0.0, np.interp(t, task.KNOTS, torques)]
    system.AddLoad(items.LoadTorqueVector(markerNumber=a, loadVectorUserFunction=torque))
    system.Assemble()
    return system, rocker, of_rocker


def value(torques, coupler):
    system, rocker, start = linkage(torques, coupler)
    settings = exu.SimulationSettings()
    settings.timeIntegration.numberOfSteps, settings.timeIntegration.endTime = STEPS, task.DURATION
    settings.timeIntegration.newton.relativeTolerance = settings.timeIntegration.newton.absoluteTolerance = 1e-10
    settings.solution.file.write = False
    settings.show.computationTime = False
    system.SolveDynamic(settings, solverType=exu.DynamicSolverType.TrapezoidalIndex2)
    return task.cost(start + system.GetNodeOutput(rocker, exu.OutputVariableType.Coordinates)[2])


def gradient(torques, coupler):
    difference = lambda J: (J(WIDTH) - J(-WIDTH)) / (2 * WIDTH)
    by_torque = [difference(lambda change: value(torques + change * knot, coupler)) for knot in np.eye(len(torques))]
    return value(torques, coupler), np.array(by_torque), difference(lambda change: value(torques, coupler + change))
# end


if __name__ == "__main__":
    task.main([("trapezoidal rule", STEPS, lambda: (value, gradient))])
