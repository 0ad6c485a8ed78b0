"""A chain of implicit steps in JAX: Newton in a loop, its derivative by the implicit function theorem."""

import os

os.environ.setdefault("XLA_FLAGS", "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1")

import jax
import jax.numpy as jnp
import numpy as np

from common import FORCE, REFERENCE_GRADIENT, REFERENCE_VALUE, STEPS, row, time_ms

jax.config.update("jax_enable_x64", True)

PAPER = (REFERENCE_VALUE, REFERENCE_GRADIENT)


def root(residual, guess):
    """x with residual(x) = 0."""

    def newton(f, x):
        def iterate(state):
            x, _, count = state
            delta = jnp.linalg.solve(jax.jacfwd(f)(x), -f(x))
            return x + delta, jnp.abs(delta).max() / jnp.abs(x).max(), count + 1

        return jax.lax.while_loop(lambda s: (s[1] > 1e-8) & (s[2] < 20), iterate, (x, jnp.inf, 0))[0]

    def solve_linear(g, y):
        return jnp.linalg.solve(jax.jacfwd(g)(y), y)

    return jax.lax.custom_root(residual, guess, newton, solve_linear)


def report(scheme, cost, reference=PAPER):
    value, both = jax.jit(cost), jax.jit(jax.value_and_grad(cost))
    u = jnp.full(STEPS + 1, FORCE)
    j, dj = both(u)
    times = time_ms(lambda: value(u).block_until_ready()), time_ms(lambda: both(u)[1].block_until_ready())
    row("JAX, compiled", scheme, *times, float(j), np.asarray(dj), "derivatives and adjoint automatic", reference)
