"""Check of constitutive models in a scene that turns a body inside out: it must be refused, not computed."""

from __future__ import annotations

from typing import Any

from mpmkit.errors import StabilityError
from mpmkit.interfaces import ConstitutiveModel
from mpmkit.testing.collect import check, expect
from mpmkit.testing.scenes import plain_python, standard_space, wave_speed


@check("material", "inversion is refused")
def inversion_is_refused(material: ConstitutiveModel, rng: Any) -> None:
    """A body that is led to F_xx = -1/2 in a step stops the run with a `StabilityError` that names the material.

    A logarithm or root of the negative J, which is NaN when compiled and raises an arithmetic error in plain Python, does not hide it.
    """
    import mpmkit as mpm
    from mpmkit import boundaries, integrators, shapes

    space = standard_space(material)
    dim = {"1D": 1, "3D": 3}.get(space, 2)
    h = 0.25
    dt = 0.5 * h / wave_speed(material)
    low = (1.0, 0.0, 0.0)[:dim] if space == "axisymmetric" else (0.0,) * dim
    middle = low[0] + 0.5
    velocity = (f"{-1.5 / dt!r}*(x - {middle!r})", "0", "0")[:dim]
    with plain_python():
        grid = mpm.Grid(low, tuple(a + 1.0 for a in low), h, coordinates="axisymmetric" if space == "axisymmetric" else "cartesian")
        sim = mpm.Simulation(grid, shapes.Linear(), integrators.MUSL(dt=dt, strain="first-order"))
        sim += mpm.Body(mpm.Box((middle - h, *low[1:]), (middle + h, *(a + h for a in low[1:]))), material)
        sim += boundaries.PrescribedVelocity(velocity, region=mpm.Box((-9.0,) * dim, (9.0,) * dim))
        try:
            sim.run(until=dt, quiet=True, threads=1)
        except StabilityError as error:
            said = str(error)
            expect("inverted" in said or "NaN" in said, f"a body that is turned inside out is refused for another reason: {said}")
            expect(type(material).__name__ in said, f"the refusal does not name {type(material).__name__}: {said}")
            return
        except (ArithmeticError, ValueError) as error:
            expect(
                isinstance(error, ArithmeticError) or "math domain error" in str(error),
                f"inversion ends in {type(error).__name__}: {error}",
            )
            return
    raise AssertionError(f"a body turned inside out, J = {sim.particles()['J'].min():g}, is computed as if nothing had happened")
