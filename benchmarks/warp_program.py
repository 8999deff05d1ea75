"""The common problem in Warp on its CPU device, which has one thread: one kernel per phase, a dense grid, atomic additions."""

import numpy as np
import warp as wp

from benchmarks import problem, program

given = program.options()
if given.threads != 1:
    raise SystemExit("Warp runs on one thread of a CPU: --threads must be 1")
wp.config.quiet = True
wp.init()
wp.set_device("cpu")
wp.set_module_options({"enable_backward": False, "fast_math": True})
given.base = program.resident()

SIZE, DIM, N = given.at, given.at.dim, given.at.cells
QUADRATIC = given.case != "flip3"
real = wp.float64 if given.prec == "f64" else wp.float32
Vector = wp.types.vector(length=DIM, dtype=real)
Matrix = wp.types.matrix(shape=(DIM, DIM), dtype=real)
Cell = wp.types.vector(length=DIM, dtype=int)
REACH = 3 if QUADRATIC else 2
Weights = wp.types.matrix(shape=(DIM, REACH), dtype=real)
DEEP = REACH if DIM == 3 else 1  # nodes along the third axis

H, INVERSE_H, DT, MASS, VOLUME = (wp.constant(real(a)) for a in (SIZE.h, 1.0 / SIZE.h, SIZE.dt, SIZE.mass, SIZE.volume))
MU, LAMBDA, FLIP = (wp.constant(real(a)) for a in (problem.MU, problem.LAMBDA, problem.FLIP))
LIGHT, FALL = wp.constant(real(problem.LIGHT * SIZE.mass)), wp.constant(real(SIZE.dt * problem.GRAVITY))
MLS = wp.constant(real(4.0 * SIZE.dt * SIZE.volume / SIZE.h**2))
ZERO, ONE, HALF, MIDDLE, THREE_HALVES, FOUR = (wp.constant(real(a)) for a in (0.0, 1.0, 0.5, 0.75, 1.5, 4.0))
COUNT, LAST, LAYERS, EDGE = wp.constant(N), wp.constant(DIM - 1), wp.constant(N - problem.WALL), wp.constant(problem.WALL)

if DIM == 3:

    @wp.func
    def node_number(c: Cell, i: int, j: int, k: int):
        return ((c[0] + i) * COUNT + c[1] + j) * COUNT + c[2] + k

    @wp.func
    def weight(w: Weights, i: int, j: int, k: int):
        return w[0, i] * w[1, j] * w[2, k]

    @wp.func
    def offset(i: int, j: int, k: int):
        return Vector(real(i), real(j), real(k))

    @wp.func
    def slope(w: Weights, i: int, j: int, k: int):
        a, b, c = real(2 * i - 1), real(2 * j - 1), real(2 * k - 1)
        return INVERSE_H * Vector(a * w[1, j] * w[2, k], w[0, i] * b * w[2, k], w[0, i] * w[1, j] * c)

else:

    @wp.func
    def node_number(c: Cell, i: int, j: int, k: int):
        return (c[0] + i) * COUNT + c[1] + j

    @wp.func
    def weight(w: Weights, i: int, j: int, k: int):
        return w[0, i] * w[1, j]

    @wp.func
    def offset(i: int, j: int, k: int):
        return Vector(real(i), real(j))


@wp.func
def first_node(r: Vector):
    c = Cell()
    for a in range(DIM):
        c[a] = int(r[a] - HALF) if wp.static(QUADRATIC) else int(r[a])
    return c


@wp.func
def weights_at(r: Vector, c: Cell):
    w = Weights()
    for a in range(DIM):
        f = r[a] - real(c[a])
        if wp.static(QUADRATIC):
            w[a, 0] = HALF * (THREE_HALVES - f) * (THREE_HALVES - f)
            w[a, 1] = MIDDLE - (f - ONE) * (f - ONE)
            w[a, REACH - 1] = HALF * (f - HALF) * (f - HALF)
        else:
            w[a, 0] = ONE - f
            w[a, 1] = f
    return w


@wp.func
def distance(c: Cell, r: Vector):
    d = Vector()
    for a in range(DIM):
        d[a] = real(c[a]) - r[a]
    return d


@wp.func
def kirchhoff(F: Matrix):
    one = wp.identity(n=DIM, dtype=real)
    return MU * (F * wp.transpose(F) - one) + LAMBDA * wp.log(wp.determinant(F)) * one


@wp.kernel
def scatter_mls(
    x: wp.array(dtype=Vector), v: wp.array(dtype=Vector), C: wp.array(dtype=Matrix), F: wp.array(dtype=Matrix),
    mass: wp.array(dtype=real), velocity: wp.array(dtype=Vector),
):  # fmt: skip
    p = wp.tid()
    r = x[p] * INVERSE_H
    c = first_node(r)
    w, d = weights_at(r, c), distance(c, r)
    stretched = F[p] + DT * (C[p] * F[p])
    F[p] = stretched
    affine = MASS * C[p] - MLS * kirchhoff(stretched)
    momentum = MASS * v[p]
    for i in range(REACH):
        for j in range(REACH):
            for k in range(DEEP):
                share, node = weight(w, i, j, k), node_number(c, i, j, k)
                wp.atomic_add(velocity, node, share * (momentum + affine * (H * (d + offset(i, j, k)))))
                wp.atomic_add(mass, node, share * MASS)


@wp.kernel
def gather_mls(x: wp.array(dtype=Vector), v: wp.array(dtype=Vector), C: wp.array(dtype=Matrix), velocity: wp.array(dtype=Vector)):
    p = wp.tid()
    r = x[p] * INVERSE_H
    c = first_node(r)
    w, d = weights_at(r, c), distance(c, r)
    mean, moment = Vector(), Matrix()
    for i in range(REACH):
        for j in range(REACH):
            for k in range(DEEP):
                u = weight(w, i, j, k) * velocity[node_number(c, i, j, k)]
                mean += u
                moment += wp.outer(u, d + offset(i, j, k))
    v[p] = mean
    C[p] = (FOUR * INVERSE_H) * moment
    x[p] = x[p] + DT * mean


if not QUADRATIC:

    @wp.kernel
    def scatter_flip(
        x: wp.array(dtype=Vector), v: wp.array(dtype=Vector), F: wp.array(dtype=Matrix),
        mass: wp.array(dtype=real), velocity: wp.array(dtype=Vector), change: wp.array(dtype=Vector),
    ):  # fmt: skip
        p = wp.tid()
        r = x[p] * INVERSE_H
        c = first_node(r)
        w = weights_at(r, c)
        push, momentum = -VOLUME * kirchhoff(F[p]), MASS * v[p]
        for i in range(REACH):
            for j in range(REACH):
                for k in range(DEEP):
                    share, node = weight(w, i, j, k), node_number(c, i, j, k)
                    wp.atomic_add(velocity, node, share * momentum)
                    wp.atomic_add(change, node, push * slope(w, i, j, k))
                    wp.atomic_add(mass, node, share * MASS)

    @wp.kernel
    def gather_flip(
        x: wp.array(dtype=Vector), v: wp.array(dtype=Vector), F: wp.array(dtype=Matrix),
        velocity: wp.array(dtype=Vector), change: wp.array(dtype=Vector),
    ):  # fmt: skip
        p = wp.tid()
        r = x[p] * INVERSE_H
        c = first_node(r)
        w = weights_at(r, c)
        mean, gain, L = Vector(), Vector(), Matrix()
        for i in range(REACH):
            for j in range(REACH):
                for k in range(DEEP):
                    share, node = weight(w, i, j, k), node_number(c, i, j, k)
                    mean += share * velocity[node]
                    gain += share * change[node]
                    L += wp.outer(velocity[node], slope(w, i, j, k))
        v[p] = FLIP * (v[p] + gain) + (ONE - FLIP) * mean
        x[p] = x[p] + DT * mean
        F[p] = F[p] + DT * (L * F[p])


@wp.kernel
def move(mass: wp.array(dtype=real), velocity: wp.array(dtype=Vector), change: wp.array(dtype=Vector)):
    node = wp.tid()
    m = mass[node]
    if m > ZERO:
        old = velocity[node] / m
        u = old
        if wp.static(not QUADRATIC):  # noqa: SIM102  (one is decided before the other)
            if m > LIGHT:
                u += (DT / m) * change[node]
        u[LAST] = u[LAST] - FALL
        rest = node
        for b in range(DIM):
            a = LAST - b
            index = rest % COUNT
            rest = rest // COUNT
            if index < EDGE:
                u[a] = wp.max(u[a], ZERO)
            if index > LAYERS:
                u[a] = wp.min(u[a], ZERO)
        velocity[node] = u
        if wp.static(not QUADRATIC):
            change[node] = u - old


def main():
    n, nodes = SIZE.particles, N**DIM
    x0, v0 = problem.start(SIZE)
    x, v = (wp.array(a.astype(given.dtype), dtype=Vector) for a in (x0, v0))
    F = wp.array(np.broadcast_to(np.eye(DIM, dtype=given.dtype), (n, DIM, DIM)).copy(), dtype=Matrix)
    C = wp.zeros(n if QUADRATIC else 1, dtype=Matrix)
    mass, velocity = wp.zeros(nodes, dtype=real), wp.zeros(nodes, dtype=Vector)
    change = wp.zeros(1 if QUADRATIC else nodes, dtype=Vector)

    def advance(steps):
        for _ in range(steps):
            for array in (mass, velocity, change):
                array.zero_()
            if QUADRATIC:
                wp.launch(scatter_mls, n, [x, v, C, F, mass, velocity])
            else:
                wp.launch(scatter_flip, n, [x, v, F, mass, velocity, change])
            wp.launch(move, nodes, [mass, velocity, change])
            if QUADRATIC:
                wp.launch(gather_mls, n, [x, v, C, velocity])
            else:
                wp.launch(gather_flip, n, [x, v, F, velocity, change])
        wp.synchronize()

    program.measure("warp", given, advance, lambda: (x.numpy(), v.numpy(), F.numpy()))


if __name__ == "__main__":
    main()
