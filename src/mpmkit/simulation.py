"""`Simulation`: what a scene is composed into; the one class most scripts meet."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from mpmkit.bodies import Body
from mpmkit.errors import CompositionError, MpmkitError, ParameterError, ResultsError, did_you_mean, shown
from mpmkit.grid import Grid
from mpmkit.interfaces import BoundaryLayer, Component, ContactAlgorithm, Discretization, Effect, Integrator, ShapeFunction
from mpmkit.parameters import Spec, convert
from mpmkit.record import Record

if TYPE_CHECKING:
    from mpmkit._core.running.loop import Run
    from mpmkit.explanation import Explanation
    from mpmkit.results import Results

PRECISIONS = ("float64", "float32")
LEAVING = ("stop", "remove", "clamp")


class Simulation:
    """A grid, the components of the method, and with ``+=`` bodies, boundary layers, contact, effects and records.

    Nothing is computed before the first `explain` or `run`; then the composition is checked as a whole, the step is
    generated and compiled, and the simulation can no longer be changed.

    Parameters
    ----------
    grid : Grid
        Domain and cells.
    shape : ShapeFunction, optional
        Required for MPM.
    integrator : Integrator, optional
        Required for MPM; the order of one step and its transfer.
    discretization : Discretization, optional
        Another method in place of MPM; it brings its own shape functions and time integration.
    precision : str
        "float64" or "float32".
    until : float, optional
        Simulated time [s] at which `run` stops if it is given none.
    leaving : str
        What happens to particles that leave the domain: "stop" (the run stops and names one), "remove" (they are taken out, with their
        mass, momentum and energy booked in the history and listed in `Results.left`) or "clamp" (they are held at the face without the
        velocity through it, impulse and energy booked). May be changed between two runs.
    retries : int
        How many times in a row a run with automatic time step may go back to its last good copy and repeat failed steps, each time
        with half the Courant number; 0 stops at the first failure. May be changed between two runs.

    Examples
    --------
    >>> import mpmkit as mpm
    >>> from mpmkit.integrators import MUSL
    >>> from mpmkit.materials import LinearElastic
    >>> from mpmkit.shapes import Linear
    >>> sim = mpm.Simulation(mpm.Grid(0.0, 1.0, 0.1), shape=Linear(), integrator=MUSL())
    >>> sim += mpm.Body(mpm.Box(0.0, 0.5), LinearElastic(E=1e4, nu=0.0, rho=1.0), v=0.1)
    """

    def __init__(
        self,
        grid: Grid,
        shape: ShapeFunction | None = None,
        integrator: Integrator | None = None,
        *,
        discretization: Discretization | None = None,
        precision: str = "float64",
        until: float | str | None = None,
        leaving: str = "stop",
        retries: int = 3,
    ) -> None:
        self.grid = _of(grid, Grid, "grid", "mpm.Grid(lower, upper, spacing)")
        self.shape = _of(shape, ShapeFunction, "shape", "mpmkit.shapes.QuadraticBSpline()", optional=True)
        self.integrator = _of(integrator, Integrator, "integrator", "mpmkit.integrators.MUSL()", optional=True)
        self.discretization = _of(discretization, Discretization, "discretization", "mpmkit.discretizations.FEM()", optional=True)
        if precision not in PRECISIONS:
            raise ParameterError(
                f"Simulation.precision must be one of {', '.join(PRECISIONS)}, got {precision!r}{did_you_mean(str(precision), PRECISIONS)}"
            )
        self.precision = precision
        self.until: float | None = convert(until, float | None, Spec("end of the run", "s", gt=0.0), "Simulation.until")
        self.leaving = leaving
        self.retries = retries
        if self.discretization is None:
            missing = [name for name in ("shape", "integrator") if getattr(self, name) is None]
            if missing:
                example = {"shape": "shape=QuadraticBSpline()", "integrator": "integrator=MUSL()"}
                raise CompositionError(f"MPM needs {' and '.join(missing)}, for example {', '.join(example[m] for m in missing)}")
        self._until_given = self.until is not None
        self.bodies: list[Body] = []
        self.boundaries: list[BoundaryLayer] = []
        self.contacts: list[ContactAlgorithm] = []
        self.effects: list[Effect] = []
        self.records: list[Record] = []
        self._run: Run | None = None

    @property
    def leaving(self) -> str:
        """What happens to particles that leave the domain: "stop", "remove" or "clamp"."""
        return self._leaving

    @leaving.setter
    def leaving(self, value: str) -> None:
        if value not in LEAVING:
            raise ParameterError(
                f"Simulation.leaving must be one of {', '.join(LEAVING)}, got {shown(value)}{did_you_mean(str(value), LEAVING)}"
            )
        if value != "stop" and getattr(self.discretization, "operator", None) == "stored":
            raise CompositionError(
                f"Simulation.leaving = {value!r}: the points of {type(self.discretization).__name__} belong to a mesh and cannot be taken "
                'out or held one by one; use "stop" and a larger grid'
            )
        self._leaving = value

    @property
    def retries(self) -> int:
        """How many times in a row failed steps may be repeated with half the Courant number."""
        return self._retries

    @retries.setter
    def retries(self, value: int) -> None:
        self._retries: int = convert(value, int, Spec("how often failed steps are repeated", ge=0.0, le=20.0), "Simulation.retries")

    def __iadd__(self, parts: Any) -> Simulation:
        """Add a body, boundary layer, contact algorithm, effect or record, or several of them."""
        for part in parts if isinstance(parts, Iterable) and not isinstance(parts, (str, Component, Body, Record)) else (parts,):
            self._add(part)
        return self

    def _add(self, part: Any) -> None:
        if self._run is not None:
            raise CompositionError(
                f"cannot add {type(part).__name__}: the simulation is already composed; add everything before explain() or run()"
            )
        places: Any = (
            (Body, self.bodies),
            (BoundaryLayer, self.boundaries),
            (ContactAlgorithm, self.contacts),
            (Effect, self.effects),
            (Record, self.records),
        )
        for kind, place in places:
            if isinstance(part, kind):
                place.append(part)
                if kind is Body:
                    self._check_names()
                return
        hint = "; give it to Simulation(...)" if isinstance(part, (ShapeFunction, Integrator, Discretization)) else ""
        raise CompositionError(
            f"cannot add {part!r} to a simulation: it is no body, boundary layer, contact algorithm, effect or record{hint}"
        )

    def _check_names(self) -> None:
        names = [self.body_name(b) for b in self.bodies]
        twice = sorted({n for n in names if names.count(n) > 1})
        if twice:
            raise CompositionError(f"two bodies are named {twice[0]!r}; give each its own name")

    def body_name(self, body: Body) -> str:
        """The body's own name, or "body1", "body2" ... in the order of addition."""
        if body.name is not None:
            return body.name
        return f"body{next(k for k, b in enumerate(self.bodies) if b is body) + 1}"

    # --- what it does -------------------------------------------------------------------------------------------
    def explain(self, *, measure: bool = False) -> Explanation:
        """The step that will run: phases and loops, who contributes what, fields and why, time-step rule, generated file.

        Parameters
        ----------
        measure : bool
            Also what each phase and each effect, contact and boundary layer costs at the present state, which takes some seconds
            for each of them; see `Explanation.measure`.
        """
        from mpmkit.explanation import Explanation

        explanation = Explanation(self.compose())
        return explanation.measure() if measure else explanation

    def compose(self) -> Run:
        """Check, sample the bodies, generate the step; done once."""
        if self._run is None:
            from mpmkit._core.running.loop import Run

            self._run = Run(self)
            for text in self._run.warnings:
                warnings.warn(text, stacklevel=2)
        return self._run

    def run(self, until: float | str | None = None, *, quiet: bool = False, threads: int | None = None) -> Results:
        """Run to a simulated time; a second call continues from where the first ended.

        Parameters
        ----------
        until : float or str, optional
            Simulated time [s] or text with a unit; the simulation's own `until` if not given.
        quiet : bool
            No progress on the terminal.
        threads : int, optional
            How many threads step; results are the same to the bit for any number. If not given, the environment variable
            ``MPMKIT_THREADS``, else one thread for every 20,000 particles, at most one for each core.

        Returns
        -------
        results : Results
            Of the first record; in memory (start, end and history) if nothing is recorded.

        Raises
        ------
        StabilityError
            Names particle, body, step, time and rule; the last good state is kept, on disk if there is a record. With an automatic time
            step the steps were repeated with smaller ones before (`Simulation.retries`).
        CompositionError
            If parts of the simulation do not fit together, or there are fewer cores than threads are asked for.
        ResultsError
            If results exist and may not be overwritten, or cannot be written.
        """
        end = convert(until, float | None, Spec("end of the run", "s", gt=0.0), "run(until)") if until is not None else self.until
        if end is None:
            raise ParameterError("run(until) is required: the simulated time [s] to run to, for example sim.run(until=1.0)")
        if not self._until_given:
            self.until = end  # a scene saved from here on says how far it ran
        run = self.compose()
        run.to(end, quiet=quiet, threads=threads)
        return self._results(run)

    def _results(self, run: Run) -> Results:
        from mpmkit.results import Results

        if run.recorders:
            return Results(run.recorders[0].record.path)
        meta = run.meta()
        return Results.in_memory(run.frames, run.history(), meta.pop("bodies"), scene=meta.pop("scene"), meta=meta, left=run.left)

    def resume(self, checkpoint: str | os.PathLike[str]) -> Simulation:
        """Take the state of a checkpoint of this very composition; the next `run` goes on bitwise as if it had never stopped."""
        self.compose().resume(checkpoint)
        return self

    @classmethod
    def from_checkpoint(cls, checkpoint: str | os.PathLike[str]) -> Simulation:
        """Rebuild a simulation from a checkpoint alone.

        Raises
        ------
        ResultsError
            If the file is no checkpoint, or the run was composed with Python functions, which a file cannot hold.
        """
        from mpmkit._core.running import checkpoint as files
        from mpmkit.scene import loads

        _, attributes = files.load(checkpoint)
        scene = attributes.get("scene")
        if not scene:
            raise ResultsError(
                f"{checkpoint}: this run was composed in a script with parts that a scene file cannot hold "
                f"({attributes.get('scene_error', 'Python functions or arrays')}); compose it in the script again and call "
                f"sim.resume({str(checkpoint)!r})"
            )
        return loads(scene).resume(checkpoint)

    def scene_text(self) -> tuple[str | None, str]:
        """Return the simulation as a TOML scene and "", or None and the reason why a file cannot hold it."""
        from mpmkit.scene import dumps

        try:
            return dumps(self), ""
        except MpmkitError as error:
            return None, str(error).split("\n")[0]

    # --- state --------------------------------------------------------------------------------------------------
    @property
    def t(self) -> float:
        """Simulated time [s]."""
        return self.compose().engine.t if self._run is not None else 0.0

    @property
    def step_number(self) -> int:
        """Steps done so far."""
        return self.compose().engine.step_number if self._run is not None else 0

    @property
    def history(self) -> dict[str, Any]:
        """Rows of the ledger so far, as arrays by column."""
        return self.compose().history()

    def particles(self, body: str | Body | None = None) -> dict[str, Any]:
        """Present state of a body's particles: field name -> array, ``x`` (n, dim), ``stress`` (n, 6), ``F`` (n, 9) ...

        Parameters
        ----------
        body : str or Body, optional
            By name; all bodies one after the other if not given (fields that all of them have).
        """
        stores = self.compose().engine.stores
        if body is not None:
            name = self.body_name(body) if isinstance(body, Body) else body
            known = [s.name for s in stores]
            if name not in known:
                raise ParameterError(f"no body is named {name!r}{did_you_mean(name, known)}; bodies: {', '.join(known)}")
            stores = [s for s in stores if s.name == name]
        import numpy as np

        common = [f for f in stores[0].available() if all(f in s.available() for s in stores)]
        return {f: np.concatenate([s.get(f) for s in stores]) for f in common}

    def __repr__(self) -> str:
        parts = [p for p in (self.shape, self.integrator, self.discretization) if p is not None]
        return f"<Simulation {self.grid.space}, {', '.join(map(str, parts))}, {len(self.bodies)} bodies>"


def _of(value: Any, kind: type, name: str, example: str, optional: bool = False) -> Any:
    if value is None and optional:
        return None
    if not isinstance(value, kind):
        made = f"; call it: {value.__name__}()" if isinstance(value, type) else ""
        raise ParameterError(f"Simulation.{name} must be a {kind.__name__}, got {value!r}{made} (for example {example})")
    return value
