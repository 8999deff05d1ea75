"""The common problem as a composition of mpmkit."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks import inside, problem, program


def compose(case: str, size: problem.Size, precision: str = "float64", domain: tuple[int, ...] | None = None) -> Any:
    """The simulation; `domain` in cells, a box of ``size.cells`` along each side if not given."""
    import mpmkit as mpm
    from mpmkit.boundaries import Wall
    from mpmkit.effects import Gravity
    from mpmkit.materials import NeoHookean
    from mpmkit.shapes import Linear, QuadraticBSpline

    dim = size.dim
    cells = domain or (size.cells,) * dim
    grid = mpm.Grid((0.0,) * dim, tuple(n * size.h for n in cells), size.h)
    rubber = NeoHookean(E=problem.E, nu=problem.NU, rho=problem.RHO, form="log")
    lower = tuple(i * size.h for i in size.lower)
    upper = tuple((i + n) * size.h for i, n in zip(size.lower, size.block, strict=True))
    shape = Linear() if case == "flip3" else QuadraticBSpline()
    sim = mpm.Simulation(grid, shape=shape, integrator=integrator(case, size.dt), precision=precision)
    sim += mpm.Body(mpm.Box(lower, upper), rubber, v=problem.velocity, name="block")
    sim += Wall("all", condition="slip"), Gravity((0.0,) * (dim - 1) + (-problem.GRAVITY,))
    return sim


def integrator(case: str, dt: float) -> Any:
    """Update stress last, as the other programs do it: the printed update of F; strains of FLIP limited at light nodes."""
    from mpmkit import integrators

    if case == "flip3":
        return integrators.USL(integrators.FLIP(problem.FLIP), strain="first-order", dt=dt)
    return integrators.USL(integrators.MLS(), limit=0.0, strain="first-order", dt=dt)


def main() -> None:
    """Run as a program of the comparison."""
    given = program.options()
    inside.set_threads(given.threads)
    import mpmkit  # noqa: F401  (its memory belongs to the base)

    given.base = program.resident()
    size = given.at
    sim = compose(given.case, size, "float64" if given.prec == "f64" else "float32")
    steps = inside.stepper(sim)

    def state() -> tuple[Any, Any, Any]:
        now = sim.particles("block")
        F = np.asarray(now["F"]).reshape(-1, 3, 3)[:, : size.dim, : size.dim]
        return now["x"], now["v"], F

    def extra() -> dict[str, Any]:
        return {"phases": steps.shares(), "field_bytes": sum(steps.field_numbers().values()) * given.dtype().itemsize}

    program.measure("mpmkit", given, lambda k: steps.steps(k, size.dt), state, extra)


if __name__ == "__main__":
    main()
