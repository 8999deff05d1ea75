"""Sizes of particles that follow F: stretch, rotation, and a body that is turned."""

import numpy as np
import pytest
from mpmkit_shapes import ContiguousGIMP

import mpmkit as mpm
from mpmkit._core.composing.sizes import half_sizes
from mpmkit.integrators import MUSL, USF
from mpmkit.materials import NeoHookean

pytestmark = pytest.mark.usefixtures("plain_python")

EPS = np.finfo(float).eps


def turn(angle, axes=(0, 1)):
    """A rotation in the plane of two axes, float64[3, 3]."""
    a, b = axes
    R = np.eye(3)
    R[a, a] = R[b, b] = np.cos(angle)
    R[b, a], R[a, b] = np.sin(angle), -np.sin(angle)
    return R


def test_pure_stretch_stretches_and_a_rotation_turns():
    """Rounding: products of a few numbers of order 1."""
    size = np.array([[0.5, 0.25, 0.125]])
    assert half_sizes(size, np.diag([2.0, 0.5, 3.0])[None]) == pytest.approx(np.array([[1.0, 0.125, 0.375]]), rel=4 * EPS)
    assert half_sizes(size, turn(np.pi / 2)[None]) == pytest.approx(np.array([[0.25, 0.5, 0.125]]), rel=8 * EPS)
    assert half_sizes(size, turn(np.pi, (1, 2))[None]) == pytest.approx(size, rel=8 * EPS)
    F = np.array([[1.2, 0.3, 0.0], [0.1, 0.8, 0.0], [0.0, 0.0, 1.1]])
    cube, R = np.full((1, 3), 0.25), turn(0.7, (0, 2))
    assert half_sizes(cube, (F @ R)[None]) == pytest.approx(half_sizes(cube, F[None]), rel=8 * EPS)  # R before F is not felt
    rng = np.random.default_rng(0)
    corners = (F[:2, :2] @ (rng.uniform(-1.0, 1.0, (2, 200_000)) * size[0, :2, None])).var(axis=1)
    box = half_sizes(size[:, :2], F[None])[0] ** 2 / 3.0
    assert corners == pytest.approx(box, rel=0.01)  # the second moments of the parallelogram; standard error of the sample 0.3 %


def turned(angle, axes, integrator, oblong=False, dim=2):
    """A square body without stress that has been turned, in a field of velocities that stretches it; the simulation."""
    sim = mpm.Simulation(mpm.Grid((0.0,) * dim, (1.0,) * dim, 0.1), shape=ContiguousGIMP(), integrator=integrator)
    box = mpm.Box((0.31,) * dim, (0.51,) * dim)
    plain = mpm.Body(box, NeoHookean(E=1e3, nu=0.3, rho=1.0), particles_per_cell=2**dim).sample(sim.grid)
    v = np.zeros((len(plain.x), dim))
    v[:, 0] = plain.x[:, 0] - 0.47
    size = plain.size * (np.array([1.5, 0.75, 1.0])[:dim] if oblong else 1.0)
    F = np.tile(turn(angle, axes), (len(v), 1, 1))
    sim += mpm.Body.from_arrays(plain.x, plain.V0, NeoHookean(E=1e3, nu=0.3, rho=1.0), v=v, F=F, size=size, name="body")
    return sim


@pytest.mark.parametrize(("integrator", "dim", "axes"), [(MUSL(), 2, (0, 1)), (USF(), 3, (1, 2))], ids=str)
def test_a_body_that_has_been_turned_moves_as_one_that_has_not(integrator, dim, axes):
    """Square boxes and an isotropic law know of no rotation before. Rounding: 5 steps of stresses over E, against motions of order 1."""
    first, *others = [turned(angle, axes, integrator, dim=dim) for angle in (0.0, 0.5 * np.pi, 2.0, np.pi)]
    first.run(until=0.002, quiet=True)
    for sim in others:
        sim.run(until=0.002, quiet=True)
        for name in ("x", "v"):
            assert sim.particles("body")[name] == pytest.approx(first.particles("body")[name], abs=1e-12)


def test_the_loops_take_the_sizes_of_the_rule():
    """USF keeps the sizes with which a step began. Rounding."""
    sim = turned(2.0, (0, 1), USF(dt=1e-4), oblong=True)
    sim.run(until=3e-4, quiet=True)
    store = sim.compose().engine.stores[0]
    before = half_sizes(store.get("size"), store.get("F"))
    sim.run(until=4e-4, quiet=True)
    assert store.get("size_now") == pytest.approx(before, rel=16 * EPS)


def test_a_body_that_begins_stretched_too_far_is_refused():
    sim = mpm.Simulation(mpm.Grid((0.0, 0.0), (1.0, 1.0), 0.1), shape=ContiguousGIMP(), integrator=MUSL())
    F = turn(1.5) @ np.diag([5.0, 0.5, 1.0])
    sim += mpm.Body(mpm.Box((0.4, 0.4), (0.6, 0.6)), NeoHookean(E=1e3, nu=0.3, rho=1.0), F=F, name="body")
    with pytest.raises(mpm.CompositionError, match=r"'body': particles are 2\.\d+ cells wide, ContiguousGIMP allows 2"):
        sim.run(until=1e-3, quiet=True)
