"""The scene of viscosity_study.toml: a bar of rubber meets a wall at a quarter of its wave speed, and a shock runs back."""

import numpy as np

import mpmkit as mpm
from mpmkit.boundaries import Symmetry
from mpmkit.effects import ArtificialViscosity
from mpmkit.exact import lame
from mpmkit.integrators import FLIP, MUSL
from mpmkit.materials import NeoHookean
from mpmkit.shapes import QuadraticBSpline

L, E, NU, RHO, MACH, WAY = 1.0, 1e4, 0.3, 1.0, 0.25, 0.7
MODULUS = lame(E, NU)[0] + 2 * lame(E, NU)[1]
WAVE = np.sqrt(MODULUS / RHO)


class Shock:
    """A plane shock in a bar 0 <= X <= L that meets a wall at X = 0, until the shock reaches the free end.

    P = (M / 2) (J - 1 / J) in uniaxial strain; mass and momentum across the front, U (1 - J) = V and rho U V = -P (U its speed in the
    reference), give (V / c)^2 = (1 - J)^2 (1 + J) / (2 J).
    """

    def __init__(self, mach=MACH):
        self.V = mach * WAVE
        roots = np.roots([1.0, -1.0, -1.0 - 2.0 * mach**2, 1.0])
        self.J = min(r.real for r in roots if abs(r.imag) < 1e-9 and 0.0 < r.real <= 1.0)
        self.behind = 0.5 * MODULUS * (self.J - 1.0 / self.J)
        self.speed = self.V / (1.0 - self.J)

    def stress(self, x, t):
        """Stress [Pa] at reference positions x [m]."""
        return np.where(np.asarray(x) < self.speed * t, self.behind, 0.0)


def solution():
    """The shock of this scene."""
    return Shock()


def scene(N, linear, quadratic):
    """N cells along the bar, two particles in each, until the shock has gone through 70 % of it."""
    exact, h = Shock(), L / N
    sim = mpm.Simulation(mpm.Grid(0.0, 1.2 * L, h), shape=QuadraticBSpline(), integrator=MUSL(FLIP(), cfl=0.3), until=WAY * L / exact.speed)
    sim += mpm.Body(mpm.Box(0.0, L), NeoHookean(E=E, nu=NU, rho=RHO, form="quadratic"), v=-exact.V, particles_per_cell=2, name="bar")
    sim += Symmetry("xmin")
    if linear or quadratic:
        sim += ArtificialViscosity(linear=linear, quadratic=quadratic)
    return sim


def _profile(facts):
    """Reference positions from the wall, in order, and the stress at the end over that behind the shock."""
    X, end = facts.samples[0].bodies["bar"]["x"][:, 0], facts.samples[-1].bodies["bar"]
    order = X.argsort()
    return X[order], end["stress"][order, 0] / Shock().behind


def front_width(facts):
    """Distance between the last place with 90 % and the first with 10 % of the stress behind the shock, in cells."""
    X, stress = _profile(facts)
    inside, outside = X[stress > 0.9].max(), X[stress > 0.1].max()
    return (outside - inside) / (2.0 * (X[1] - X[0]))


def overshoot(facts):
    """Largest stress beyond that behind the shock, as a share of it; without the fifth of the bar where the shock began."""
    X, stress = _profile(facts)
    return max(0.0, stress[X > 0.2 * L].max() - 1.0)
