"""MJX: the model of `mujoco_four_bar.py` on JAX, RK4, reverse-mode derivatives through all steps.

Reverse mode needs one iteration of the solver per step (more are a loop that JAX cannot reverse); one is enough here, because an equality constraint
is a linear problem. The quantities of the model that depend on the length are replaced by functions of it.

The acceleration that version 3.17 demands of a loop lacks the term dJ/dt v, which MuJoCo 4.0 has. Therefore the loop opens by an error of the
order of the time constant squared.
"""

import jax
import numpy as np
from jax import numpy as jnp
from mujoco import mjx

import mujoco_four_bar
import task

STEPS = 2000
TIME_CONSTANT = 0.001  # s, of errors of the constraint; the shortest for these steps


# begin
def of_length(model, coupler):
    """The model with another length of the coupler."""
    rod = 2
    mass = task.DENSITY * coupler
    across = mass * coupler**2 / 12
    return model.replace(
        body_mass=model.body_mass.at[rod].set(mass),
        body_inertia=model.body_inertia.at[rod, 1:].set(across),
        body_ipos=model.body_ipos.at[rod, 0].set(coupler / 2),
        eq_data=model.eq_data.at[0, 0].set(coupler),
    )


def final_cost(torques, coupler, model, data):
    angle, rocker = task.closure(task.START, coupler, jnp)
    model = of_length(model, coupler)
    data = data.replace(qpos=jnp.array([task.START, angle - task.START, rocker]))

    @jax.checkpoint
    def step(data, torque):
        return mjx.step(model, data.replace(ctrl=torque[None])), None

    data, _ = jax.lax.scan(step, data, task.middle_torques(torques, STEPS))
    return task.cost(data.qpos[2])


def functions():
    jax.config.update("jax_enable_x64", True)
    model, data = mujoco_four_bar.linkage(task.COUPLER, STEPS, True, TIME_CONSTANT)
    model.opt.iterations, model.opt.ls_iterations = 1, 4
    model, data = mjx.put_model(model), mjx.put_data(model, data)
    value = jax.jit(lambda torques, coupler: final_cost(torques, coupler, model, data))
    both = jax.jit(jax.value_and_grad(lambda torques, coupler: final_cost(torques, coupler, model, data), (0, 1)))

    def gradient(torques, coupler):
        cost, (by_torque, by_length) = both(torques, coupler)
        return float(cost), np.asarray(by_torque), float(by_length)

    return lambda torques, coupler: float(value(torques, coupler)), gradient
# end


if __name__ == "__main__":
    task.main([("RK4", STEPS, functions)])
