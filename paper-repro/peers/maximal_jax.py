"""JAX, the same scheme reduced to (v, sigma)."""

from jax_tools import jax, jnp, report, root

from common import HALF_STEP as h, TARGET_ANGLE, Maximal

x = Maximal()
n, m = x.n, x.m


# Products with Phi_q instead of the matrix itself, for 20 tangents at once.
def phi_q_times(q, v):
    return x.a @ v - x.c @ (jnp.sin(q) * v) + x.s @ (jnp.cos(q) * v)


def sigma_phi_q(q, sigma):
    return sigma @ x.a - (sigma @ x.c) * jnp.sin(q) + (sigma @ x.s) * jnp.cos(q)


def force(q, v, sigma, u):
    """L_q + Q."""
    bend = -(sigma @ x.c) * jnp.cos(q) - (sigma @ x.s) * jnp.sin(q)
    return (x.weight - x.damping @ v + v * bend).at[0].add(u)


def step(state, u):
    q, p, now, before, g = state
    q_start, p_start = q + h * now[:n], p + h * g

    def residual(z):
        v, sigma, q = z[:n], z[n:], q_start + h * z[:n]
        momentum = x.mass * v + sigma_phi_q(q, sigma) - p_start - h * force(q, v, sigma, u)
        return jnp.concatenate([momentum, phi_q_times(q, v)])

    z = root(residual, 2 * now - before)
    q = q_start + h * z[:n]
    g = force(q, z[:n], z[n:], u)
    return (q, p_start + h * g, z, now, g), None


def cost(u):
    rest = jnp.zeros(n + m)
    q = jnp.asarray(x.start)
    start = (q, jnp.zeros(n), rest, rest, force(q, rest[:n], rest[n:], u[0]))
    (q, *_), _ = jax.lax.scan(step, start, u[1:])
    error = q[x.angles] - TARGET_ANGLE
    return 0.5 * error @ error


report("maximal, n + m, the same scheme", cost)
