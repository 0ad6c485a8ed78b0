"""JAX and diffrax: the crank's angle as the only coordinate, the loop closed by a formula, Tsit5 with steps that end at the knots.

The equation of motion is M w' = torque - V_a - M_a w^2 / 2; JAX differentiates M and V. The gradient is that of the discrete
motion (`RecursiveCheckpointAdjoint`).
"""

import diffrax
import jax
import numpy as np
from jax import numpy as jnp

import task

STEPS = 100


# begin
def pose(crank, coupler):
    """Centres and angles of the rods."""
    angle, rocker = task.closure(crank, coupler, jnp)
    along = lambda length, angle: length * jnp.array([jnp.cos(angle), jnp.sin(angle)])
    centres = jnp.array([along(task.CRANK / 2, crank), along(task.CRANK, crank) + along(coupler / 2, angle),
                         jnp.array([task.GROUND, 0.0]) + along(task.ROCKER / 2, rocker)])
    return centres, jnp.array([crank, angle, rocker])


def mass_and_potential(crank, coupler):
    """M(a) and V(a), where M(a) w^2 / 2 is the kinetic energy."""
    lengths = jnp.array([task.CRANK, coupler, task.ROCKER])
    mass = task.DENSITY * lengths
    (centres, _), (by_crank, turns) = jax.jvp(lambda crank: pose(crank, coupler), (crank,), (1.0,))
    return mass @ (by_crank**2).sum(1) + (mass * lengths**2 / 12) @ turns**2, task.GRAVITY * mass @ centres[:, 1]


def rate(t, state, arguments):
    torques, coupler = arguments
    crank, speed = state
    (mass, _), (mass_a, potential_a) = jax.jvp(lambda crank: mass_and_potential(crank, coupler), (crank,), (1.0,))
    return jnp.array([speed, (jnp.interp(t, task.KNOTS, torques) - potential_a - 0.5 * mass_a * speed**2) / mass])


def final_cost(torques, coupler):
    start = jnp.array([task.START, 0.0])
    found = diffrax.diffeqsolve(diffrax.ODETerm(rate), diffrax.Tsit5(), 0.0, task.DURATION, task.DURATION / STEPS, start, (torques, coupler),
                                adjoint=diffrax.RecursiveCheckpointAdjoint(), max_steps=STEPS + 1)
    return task.cost(task.closure(found.ys[0, 0], coupler, jnp)[1])


def functions():
    jax.config.update("jax_enable_x64", True)
    value, both = jax.jit(final_cost), jax.jit(jax.value_and_grad(final_cost, (0, 1)))

    def gradient(torques, coupler):
        cost, (by_torque, by_length) = both(torques, coupler)
        return float(cost), np.asarray(by_torque), float(by_length)

    return lambda torques, coupler: float(value(torques, coupler)), gradient
# end


if __name__ == "__main__":
    task.main([("Tsit5", STEPS, functions)])
