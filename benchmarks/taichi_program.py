"""The common problem in Taichi on the CPU: one kernel per phase, a dense grid, atomic additions."""

import numpy as np
import taichi as ti

from benchmarks import problem, program

given = program.options()
real = ti.f64 if given.prec == "f64" else ti.f32
ti.init(arch=ti.cpu, default_fp=real, cpu_max_num_threads=given.threads, offline_cache=True, log_level=ti.ERROR)
given.base = program.resident()

SIZE, DIM, N = given.at, given.at.dim, given.at.cells
H, DT, MASS, VOLUME = SIZE.h, SIZE.dt, SIZE.mass, SIZE.volume
QUADRATIC = given.case != "flip3"
REACH = 3 if QUADRATIC else 2
NEIGHBOURS = ti.ndrange(*((REACH,) * DIM))

x, v = (ti.Vector.field(DIM, real, SIZE.particles) for _ in range(2))
F, C = (ti.Matrix.field(DIM, DIM, real, SIZE.particles) for _ in range(2))
mass = ti.field(real, (N,) * DIM)
velocity, change = (ti.Vector.field(DIM, real, (N,) * DIM) for _ in range(2))
"""Of a node: momentum and force until they become velocity and its change."""


@ti.func
def around(position):
    """First node, distance from it in cells, and the weights per axis (rows: nodes)."""
    first = ti.floor(position / H - (0.5 if ti.static(QUADRATIC) else 0.0), int)
    r = position / H - first
    weights = ti.Matrix.zero(real, REACH, DIM)
    for a in ti.static(range(DIM)):
        if ti.static(QUADRATIC):
            weights[0, a] = 0.5 * (1.5 - r[a]) ** 2
            weights[1, a] = 0.75 - (r[a] - 1.0) ** 2
            weights[2, a] = 0.5 * (r[a] - 0.5) ** 2
        else:
            weights[0, a] = 1.0 - r[a]
            weights[1, a] = r[a]
    return first, r, weights


@ti.func
def weight(weights, node: ti.template()):
    """The product of the weights along the axes."""
    w = weights[node[0], 0]
    for a in ti.static(range(1, DIM)):
        w *= weights[node[a], a]
    return w


@ti.func
def slope(weights, node: ti.template()):
    """Gradient of the product of tents."""
    g = ti.Vector.zero(real, DIM)
    for a in ti.static(range(DIM)):
        g[a] = (2 * node[a] - 1) / H
        for b in ti.static(range(DIM)):
            if ti.static(a != b):
                g[a] *= weights[node[b], b]
    return g


@ti.func
def kirchhoff(B):
    """tau = mu (F F^T - I) + lambda ln J I."""
    one = ti.Matrix.identity(real, DIM)
    return problem.MU * (B @ B.transpose() - one) + problem.LAMBDA * ti.log(B.determinant()) * one


@ti.kernel
def clear():
    for node in ti.grouped(mass):
        mass[node] = 0.0
        velocity[node] = ti.Vector.zero(real, DIM)
        if ti.static(not QUADRATIC):
            change[node] = ti.Vector.zero(real, DIM)


@ti.kernel
def scatter():
    for p in x:
        first, r, weights = around(x[p])
        momentum = MASS * v[p]
        if ti.static(QUADRATIC):
            F[p] += DT * C[p] @ F[p]
            affine = MASS * C[p] - (4.0 * DT * VOLUME / H**2) * kirchhoff(F[p])
            for node in ti.static(ti.grouped(NEIGHBOURS)):
                w = weight(weights, node)
                velocity[first + node] += w * (momentum + affine @ ((node - r) * H))
                mass[first + node] += w * MASS
        else:
            force = -VOLUME * kirchhoff(F[p])
            for node in ti.static(ti.grouped(NEIGHBOURS)):
                w = weight(weights, node)
                velocity[first + node] += w * momentum
                change[first + node] += force @ slope(weights, node)
                mass[first + node] += w * MASS


@ti.kernel
def move():
    for node in ti.grouped(mass):
        m = mass[node]
        if m > 0.0:
            old = velocity[node] / m
            new = old
            if ti.static(not QUADRATIC):  # noqa: SIM102  (one is decided before the other)
                if m > problem.LIGHT * MASS:
                    new += DT * change[node] / m
            new[DIM - 1] -= DT * problem.GRAVITY
            for a in ti.static(range(DIM)):
                if node[a] < problem.WALL:
                    new[a] = ti.max(new[a], 0.0)
                if node[a] > N - problem.WALL:
                    new[a] = ti.min(new[a], 0.0)
            velocity[node] = new
            if ti.static(not QUADRATIC):
                change[node] = new - old


@ti.kernel
def gather():
    for p in x:
        first, r, weights = around(x[p])
        mean, gain = ti.Vector.zero(real, DIM), ti.Vector.zero(real, DIM)
        L = ti.Matrix.zero(real, DIM, DIM)
        for node in ti.static(ti.grouped(NEIGHBOURS)):
            w, u = weight(weights, node), velocity[first + node]
            mean += w * u
            if ti.static(QUADRATIC):
                L += (4.0 * w / H) * u.outer_product(node - r)
            else:
                L += u.outer_product(slope(weights, node))
                gain += w * change[first + node]
        x[p] += DT * mean
        if ti.static(QUADRATIC):
            v[p] = mean
            C[p] = L
        else:
            v[p] = problem.FLIP * (v[p] + gain) + (1.0 - problem.FLIP) * mean
            F[p] += DT * L @ F[p]


def advance(steps):
    for _ in range(steps):
        clear()
        scatter()
        move()
        gather()
    ti.sync()


def main():
    x0, v0 = problem.start(SIZE)
    x.from_numpy(x0.astype(given.dtype))
    v.from_numpy(v0.astype(given.dtype))
    F.from_numpy(np.broadcast_to(np.eye(DIM, dtype=given.dtype), (SIZE.particles, DIM, DIM)).copy())
    program.measure("taichi", given, advance, lambda: (x.to_numpy(), v.to_numpy(), F.to_numpy()))


if __name__ == "__main__":
    main()
