"""This package: three rods with four hinges, the start assembled with the crank held, discrete adjoint."""

import functools

import hamiltonian_adjoint as ha

import task

SCHEMES = {"ESDIRK4": 140, "trapezoidal rule": 2100}  # steps; the trapezoidal rule is the default


# begin
def scene():
    """The mechanism with the torque and the length of the coupler as inputs."""
    scene = ha.Scene()
    scene.gravity(0.0, -task.GRAVITY)
    coupler_length = scene.design("coupler", task.COUPLER)

    def rod(name, length, place):
        mass = task.DENSITY * length
        return scene.body(name, mass, mass * length**2 / 12, place), length / 2

    (crank, a), (coupler, b), (rocker, c) = (
        rod("crank rod", task.CRANK, (0.05, 0.08, task.START)),
        rod("coupler rod", coupler_length, (0.4, 0.3, 0.5)),  # roughly: the start is assembled
        rod("rocker rod", task.ROCKER, (0.7, 0.2, 2.0)),
    )
    scene.revolute("A", ha.GROUND.at(0.0, 0.0), crank.at(-a, 0.0))
    scene.revolute("B", crank.at(a, 0.0), coupler.at(-b, 0.0))
    scene.revolute("C", coupler.at(b, 0.0), rocker.at(c, 0.0))
    scene.revolute("D", ha.GROUND.at(task.GROUND, 0.0), rocker.at(-c, 0.0))
    torque = scene.control("torque")
    scene.torque_actuator("motor", ha.GROUND, crank, torque)
    scene.cost("angle", task.cost(rocker.phi), sum="terminal")
    return scene.compile(), crank, coupler_length, torque


def functions(steps, **settings):
    system, crank, length, torque = scene()
    solver = ha.Solver(system, **settings)
    inputs = system.at_rest(steps, task.DURATION / steps).assemble(crank.phi)
    at_nodes = task.interpolation(inputs.times)

    def change(torques, coupler):
        inputs[torque] = at_nodes @ torques
        inputs[length] = coupler
        return inputs

    def value(torques, coupler):
        solver.simulate(change(torques, coupler))
        return solver.cost()

    def gradient(torques, coupler):
        found = solver.gradient(change(torques, coupler))
        return found.value, found[torque] @ at_nodes, found[length]

    return value, gradient
# end


if __name__ == "__main__":
    task.main([(scheme, steps, functools.partial(functions, steps, scheme=scheme)) for scheme, steps in SCHEMES.items()])
