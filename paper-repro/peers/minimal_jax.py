"""JAX in minimal coordinates (x, phi_1, phi_2, phi_3): the trapezoidal rule on (q, p) with p = T_v."""

from jax_tools import jax, jnp, report, root

from common import (CART_MASS, GRAVITY, HALF_LENGTH, HALF_STEP as h, HINGE_FRICTION, LINK_INERTIA, LINK_MASS, LINKS,
                    RAIL_FRICTION, START_ANGLE, TARGET_ANGLE)
from minimal_reference import reference

n = LINKS + 1


def lagrangian(q, v):
    """T - V."""
    sin, cos = jnp.sin(q[1:]), jnp.cos(q[1:])
    before = lambda ends: jnp.concatenate([jnp.zeros(1), jnp.cumsum(2 * ends)[:-1]])
    along_x, along_y, up = -HALF_LENGTH * sin * v[1:], HALF_LENGTH * cos * v[1:], HALF_LENGTH * sin
    speed_x, speed_y, height = v[0] + before(along_x) + along_x, before(along_y) + along_y, before(up) + up
    kinetic = 0.5 * CART_MASS * v[0] ** 2 + 0.5 * LINK_MASS * (speed_x @ speed_x + speed_y @ speed_y)
    return kinetic + 0.5 * LINK_INERTIA * v[1:] @ v[1:] - LINK_MASS * GRAVITY * height.sum()


def rate(q, v, u):
    """T_q - V_q + Q."""
    friction = jnp.zeros(n).at[0].set(RAIL_FRICTION * v[0]).at[1].set(HINGE_FRICTION * v[1])
    return (jax.grad(lagrangian)(q, v) - friction).at[0].add(u)


def step(state, u):
    q, p, now, before, g = state
    q_start, p_start = q + h * now, p + h * g

    def residual(v):
        q = q_start + h * v
        return jax.grad(lagrangian, 1)(q, v) - p_start - h * rate(q, v, u)

    v = root(residual, 2 * now - before)
    q = q_start + h * v
    g = rate(q, v, u)
    return (q, p_start + h * g, v, now, g), None


def cost(u):
    q, rest = jnp.array([0.0] + [START_ANGLE] * LINKS), jnp.zeros(n)
    (q, *_), _ = jax.lax.scan(step, (q, rest, rest, rest, rate(q, rest, u[0])), u[1:])
    error = q[1:] - TARGET_ANGLE
    return 0.5 * error @ error


report("minimal, trapezoidal on (q, p)", cost, reference())
