"""Scenes of the tests."""

import math

import hamiltonian_adjoint as ha
import numpy as np

# J of the paper's example with three links, 100 steps of 0.02 s and a force of 10 N, as the Rust library computes it (its documentation asserts it, too).
PAPER = 15.18353832472497


def cart_with_links(links=3, cost="formula"):
    """The paper's example; its cost as a formula, as a function, or none."""
    scene = ha.Scene()
    scene.gravity(0.0, -9.81)
    force = scene.control("force on the cart")
    cart = scene.body("cart", 0.8, 0.034)
    ground, centre = ha.GROUND.at(0.0, 0.0), cart.at(0.0, 0.0)
    scene.prismatic("rail", ground, centre, axis=0.0, angle=0.0)
    scene.sliding_friction("rail friction", ground, centre, axis=0.0, damping=0.5)
    scene.actuator("drive", ground, centre, axis=0.0, force=force)
    inner, hinge, angles = cart, centre, []
    for j in range(1, links + 1):
        along = (2 * j - 1) * 0.5
        start = -math.pi / 2
        link = scene.body(f"link {j}", 0.4, 0.083, (along * math.cos(start), along * math.sin(start), start))
        scene.revolute(f"hinge {j}", hinge, link.at(-0.5, 0.0))
        if j == 1:
            scene.joint_friction("friction in hinge 1", inner, link, damping=0.2)
        inner, hinge = link, link.at(0.5, 0.0)
        angles.append(link.phi)
    for j, phi in enumerate(angles, 1):
        if cost == "formula":
            error = phi - math.pi / 2
            scene.cost(f"angle of link {j}", error * error * 0.5, sum="terminal")
        elif cost == "function":
            scene.cost(f"angle of link {j}", half_square, sum="terminal", q=[phi], b=[math.pi / 2])
    return scene, force, angles


def half_square(at):
    error = at.q[0] - at.b[0]
    return error * error * 0.5


def pushed(system, force=10.0, steps=100, dt=0.02):
    inputs = system.at_rest(steps, dt)
    inputs.controls[:] = force
    return inputs


def differences(f, x, h=1e-5):
    """Central differences of fourth order."""
    x = np.asarray(x, dtype=float)
    gradient = np.empty_like(x)
    for i in np.ndindex(x.shape):
        e = np.zeros_like(x)
        e[i] = h
        gradient[i] = (8 * (f(x + e) - f(x - e)) - (f(x + 2 * e) - f(x - 2 * e))) / (12 * h)
    return gradient


def block_on_a_spring():
    """A block of 1 kg that begins at 1 m on a spring, and the stiffness of the spring with a guess."""
    scene = ha.Scene()
    x = scene.coordinates("block", ["x"], [1.0]).x
    stiffness = scene.design("stiffness", 3.0)
    scene.kinetic_energy("motion", 0.5 * x.v**2)
    scene.potential_energy("spring", 0.5 * stiffness * x**2)
    return scene, x, stiffness


def rope_of_a_design():
    """A point on a rope whose length is a design variable: changes of it violate the start."""
    scene = ha.Scene()
    arm = scene.design("arm", 1.0)
    bob = scene.particle("bob", 1.0, (1.0, 0.0))
    scene.distance("rope", ha.GROUND.at(0, 0), bob, length=arm)
    scene.cost("end", bob.x**2, sum="terminal")
    return scene
