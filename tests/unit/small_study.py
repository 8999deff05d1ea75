"""A small made-up study with known orders, for tests of what is made of results: fits, sentences, pictures, reports."""

from __future__ import annotations

from typing import Any

from mpmkit.studies.results import StudyResults

STRESS, ENDS = "stress.xx, L1 [Pa]", "final length, absolute error [m]"


def results() -> StudyResults:
    """Three shape functions, four resolutions: "GIMP" of order 2, "Linear" stops at 0.02, "QuadraticBSpline" of order 3 and refused once.

    Time grows as h^-2 and is 1, 1.5 and 2 ms at h = 0.1; the finest GIMP is unstable.
    """
    rows: list[dict[str, Any]] = []
    for shape, cost, error in (
        ("Linear", 1e-3, lambda h: max(h, 0.02)),
        ("GIMP", 1.5e-3, lambda h: h**2),
        ("QuadraticBSpline", 2e-3, lambda h: 2.0 * h**3),
    ):
        for h in (0.1, 0.05, 0.025, 0.0125):
            n, steps = round(1 / h), round(20 / h)
            seconds = cost * (0.1 / h) ** 2
            row: dict[str, Any] = {
                "label": f"{shape}, {h:g}",
                "composition": shape,
                "choices": {"shape": {"kind": shape}, "grid.spacing": h},
                "labels": {"shape": shape, "grid.spacing": f"{h:g}"},
                "resolution": h,
                "particles": n,
            }
            if shape == "GIMP" and h == 0.0125:
                row |= {"status": "unstable", "reason": "energy was created: 0.6 times the largest energy of the run, at step 812"}
            elif shape == "QuadraticBSpline" and h == 0.1:
                row |= {"status": "refused", "reason": "QuadraticBSpline needs at least 12 cells, the grid has 10"}
            else:
                row |= {
                    "errors": {STRESS: error(h), ENDS: 0.1 * error(h)},
                    "seconds": seconds,
                    "seconds_low": 0.95 * seconds,
                    "seconds_high": 1.1 * seconds,
                    "repeats": 3,
                    "steps": steps,
                    "ns_per_particle_step": 1e9 * seconds / (n * steps),
                    "peak_bytes": 120_000_000 + 1000 * n,
                    "reference_seconds": 1e-3,
                }
            rows.append(row)
    meta = {
        "name": "made-up bar",
        "errors": [{"label": STRESS, "unit": "Pa"}, {"label": ENDS, "unit": "m"}],
        "resolution": {"name": "grid.spacing", "unit": "m"},
        "axes": {"shape": ["Linear", "GIMP", "QuadraticBSpline"], "grid.spacing": [0.1, 0.05, 0.025, 0.0125]},
        "machine": {"processor": "made-up processor", "cores": 2, "platform": "Linux"},
        "versions": {"mpmkit": "0.1.0", "numpy": "2.0.0"},
        "scene": "[grid]\nlower = 0.0\nupper = 1.0\nspacing = 0.1\n",
        "reference": {"label": "Linear, 0.1", "seconds": [1e-3, 1.02e-3, 0.99e-3]},
        "complete": True,
    }
    return StudyResults(rows, meta)


def bar(n: int = 8) -> dict[str, Any]:
    """The data of a scene: a bar of `n` cells with a particle each, wave speed 1, fixed at 0 and pulled at 1 by a stress of 1e-3."""
    return {
        "until": 0.75,
        "grid": {"lower": [0.0], "upper": [1.5], "spacing": 1.0 / n, "lateral": "stress"},
        "shape": {"kind": "Linear"},
        "integrator": {"kind": "MUSL", "cfl": 0.5},
        "materials": {"elastic": {"kind": "LinearElastic", "E": 1.0, "nu": 0.0, "rho": 1.0}},
        "bodies": [
            {"name": "bar", "geometry": {"kind": "Box", "lower": [0.0], "upper": [1.0]}, "material": "elastic", "particles_per_cell": 1}
        ],
        "boundaries": [
            {"kind": "Wall", "faces": "xmin", "condition": "no slip"},
            {"kind": "TwoPointTraction", "body": "bar", "traction": [1e-3], "face": "xmax"},
        ],
    }


EXACT = {
    "kind": "Exact",
    "solution": {"kind": "ForcedBar", "L": 1.0, "right": {"kind": "Step", "magnitude": 1e-3}},
    "field": "stress.xx",
    "norm": "L1",
    "scale": 1e-3,
}


class Here:
    """An executor that does every job at once, in this process, and counts them."""

    def __init__(self, interrupt_after: int = 10**9) -> None:
        self.done, self.interrupt_after = 0, interrupt_after

    def submit(self, function: Any, job: dict[str, Any]) -> Any:
        import tempfile
        from concurrent.futures import Future
        from pathlib import Path

        import numpy as np

        from mpmkit.studies.stepping import execute

        if self.done >= self.interrupt_after:
            raise KeyboardInterrupt
        self.done += 1
        future: Future[dict[str, Any]] = Future()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "fields.npz"
            answer = execute({**job, "arrays": str(path)})
            if path.exists():
                with np.load(path) as found:
                    answer["fields"] = dict(found)
        future.set_result(answer)
        return future
