"""The common problem in JAX on the CPU: arrays over all particles, one compiled step, sums at nodes by ``.at[].add``."""

import itertools
import os

from benchmarks import problem, program

given = program.options()
if given.threads == 1:  # XLA has no number of threads to set, but it asks the system on how many processors it may run
    os.environ["XLA_FLAGS"] = os.environ.get("XLA_FLAGS", "") + " --xla_cpu_multi_thread_eigen=false"
os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[: given.threads])

import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402

jax.config.update("jax_enable_x64", given.prec == "f64")
jax.config.update("jax_platforms", "cpu")
given.base = program.resident()

SIZE, DIM, N = given.at, given.at.dim, given.at.cells
H, DT, MASS, VOLUME = SIZE.h, SIZE.dt, SIZE.mass, SIZE.volume
QUADRATIC = given.case != "flip3"
NEIGHBOURS = list(itertools.product(range(3 if QUADRATIC else 2), repeat=DIM))
ONE = jnp.eye(DIM, dtype=given.dtype)


def matrices(A, B):
    """Product of small matrices of all particles; written out it is several times faster than as a reduction or a batched product."""
    return sum(A[:, :, a, None] * B[:, a, None, :] for a in range(DIM))


def times(A, d):
    """Matrix times vector of all particles."""
    return sum(A[:, :, a] * d[:, a, None] for a in range(DIM))


def determinant(F):
    if DIM == 2:
        return F[:, 0, 0] * F[:, 1, 1] - F[:, 0, 1] * F[:, 1, 0]
    return (jnp.cross(F[:, 0], F[:, 1]) * F[:, 2]).sum(1)


def kirchhoff(F):
    volumetric = problem.LAMBDA * jnp.log(determinant(F))
    return problem.MU * (matrices(F, F.transpose(0, 2, 1)) - ONE) + volumetric[:, None, None] * ONE


def around(x):
    """Number of the first node, distance from it in cells, weights of the nodes along each axis."""
    first = jnp.floor(x / H - (0.5 if QUADRATIC else 0.0)).astype(jnp.int32)
    r = x / H - first
    tents = (1.0 - r, r)
    splines = (0.5 * (1.5 - r) ** 2, 0.75 - (r - 1.0) ** 2, 0.5 * (r - 0.5) ** 2)
    number = first[:, 0]
    for a in range(1, DIM):
        number = number * N + first[:, a]
    return number, r, splines if QUADRATIC else tents


def shift(node):
    """Distance of a neighbour in the numbering of nodes."""
    number = 0
    for i in node:
        number = number * N + i
    return number


def weight(weights, node, without=None):
    """Product of the weights along all axes, or all but one."""
    product = 1.0
    for a, i in enumerate(node):
        if a != without:
            product = product * weights[i][:, a]
    return product


def slope(weights, node):
    return jnp.stack([(2 * i - 1) / H * weight(weights, node, without=a) for a, i in enumerate(node)], axis=1)


def walls(u):
    u = u.reshape((N,) * DIM + (DIM,))
    for a in range(DIM):
        index = jnp.arange(N).reshape([-1 if b == a else 1 for b in range(DIM)])
        component = jnp.where(index < problem.WALL, jnp.maximum(u[..., a], 0.0), u[..., a])
        u = u.at[..., a].set(jnp.where(index > N - problem.WALL, jnp.minimum(component, 0.0), component))
    return u.reshape(-1, DIM)


def fall(u):
    return u.at[:, -1].add(-DT * problem.GRAVITY)


def mls_step(x, v, C, F):
    number, r, weights = around(x)
    F = F + DT * matrices(C, F)
    affine = MASS * C - (4.0 * DT * VOLUME / H**2) * kirchhoff(F)
    sums = jnp.zeros((N**DIM, DIM + 1), given.dtype)
    for node in NEIGHBOURS:
        d = (jnp.array(node, given.dtype) - r) * H
        values = jnp.concatenate([MASS * v + times(affine, d), jnp.full_like(x[:, :1], MASS)], axis=1)
        sums = sums.at[number + shift(node)].add(weight(weights, node)[:, None] * values)
    m = sums[:, DIM:]
    u = walls(jnp.where(m > 0.0, fall(sums[:, :DIM] / jnp.where(m > 0.0, m, 1.0)), 0.0))
    v, C = jnp.zeros_like(v), jnp.zeros_like(C)
    for node in NEIGHBOURS:
        share = weight(weights, node)[:, None] * u[number + shift(node)]
        v = v + share
        C = C + (4.0 / H) * share[:, :, None] * (jnp.array(node, given.dtype) - r)[:, None, :]
    return x + DT * v, v, C, F


def flip_step(x, v, C, F):
    number, _, weights = around(x)
    push = -VOLUME * kirchhoff(F)
    sums = jnp.zeros((N**DIM, 2 * DIM + 1), given.dtype)
    for node in NEIGHBOURS:
        w = MASS * weight(weights, node)[:, None]
        values = jnp.concatenate([w * v, times(push, slope(weights, node)), w], axis=1)
        sums = sums.at[number + shift(node)].add(values)
    m = sums[:, 2 * DIM :]
    safe = jnp.where(m > 0.0, m, 1.0)
    old = sums[:, :DIM] / safe
    new = old + jnp.where(m > problem.LIGHT * MASS, DT * sums[:, DIM : 2 * DIM] / safe, 0.0)
    new = walls(jnp.where(m > 0.0, fall(new), 0.0))
    both = jnp.concatenate([new, jnp.where(m > 0.0, new - old, 0.0)], axis=1)
    mean, L = jnp.zeros_like(both[: len(v)], shape=(len(v), 2 * DIM)), jnp.zeros_like(F)
    for node in NEIGHBOURS:
        values = both[number + shift(node)]
        mean = mean + weight(weights, node)[:, None] * values
        L = L + values[:, :DIM, None] * slope(weights, node)[:, None, :]
    moved, gain = mean[:, :DIM], mean[:, DIM:]
    v = problem.FLIP * (v + gain) + (1.0 - problem.FLIP) * moved
    return x + DT * moved, v, C, F + DT * matrices(L, F)


def main():
    n = SIZE.particles
    x, v = (jnp.asarray(a.astype(given.dtype)) for a in problem.start(SIZE))
    state = [x, v, jnp.zeros((n, DIM, DIM), given.dtype), jnp.tile(ONE, (n, 1, 1))]
    step = jax.jit(mls_step if QUADRATIC else flip_step, donate_argnums=(0, 1, 2, 3))

    def advance(steps):
        for _ in range(steps):
            state[:] = step(*state)
        jax.block_until_ready(state)

    program.measure("jax", given, advance, lambda: (state[0], state[1], state[3]))


if __name__ == "__main__":
    main()
