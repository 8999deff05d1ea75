"""`Results`: read a run back, from its file or from memory."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit._core.reading.frame import Frame, Frames, History
from mpmkit._core.reading.sources import FileSource, MemorySource
from mpmkit.errors import ResultsError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mpmkit._core.reading.sources import Source


class Results:
    """What a run left: frames over time, history, scene. Nothing is read before it is asked for.

    Parameters
    ----------
    path : path
        The .vtkhdf or .hdf file of a run, finished, interrupted or still going on.

    Raises
    ------
    ResultsError
        If the file is missing, truncated, or not one of mpmkit's; the message says which.

    Examples
    --------
    >>> results = Results("disks.vtkhdf")  # doctest: +SKIP
    >>> results.frames[-1]["stress"]  # doctest: +SKIP
    >>> results.history.kinetic  # doctest: +SKIP
    >>> results.plot("stress", time=2.0, path="disks.png")  # doctest: +SKIP
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path: Path | None = Path(path)
        self._source: Source = FileSource(self.path)

    @classmethod
    def in_memory(
        cls,
        frames: Sequence[tuple[float, int, Mapping[str, np.ndarray]]],
        history: Mapping[str, Any],
        bodies: Sequence[str],
        *,
        meta: Mapping[str, Any] | None = None,
        scene: str | None = None,
        left: Sequence[Mapping[str, float]] = (),
    ) -> Results:
        """Results of a run without a record.

        Parameters
        ----------
        frames : sequence of (time, step, mapping of field to array)
            Kept as they are, not copied.
        history : mapping of column to array
            The ledger's rows.
        bodies : sequence of str
            Names; the field "body" holds their numbers.
        meta : mapping
            Facts as in `ParticleFile.create`.
        scene : str
            The scene as text.
        left : sequence of mapping
            Particles that were taken out of the domain.
        """
        made = cls.__new__(cls)
        made.path = None
        made._source = MemorySource(frames, history, {**(meta or {}), "bodies": list(bodies)}, scene, left)
        return made

    @property
    def frames(self) -> Frames:
        """All frames in the order of time."""
        return Frames(len(self._source.times), self._frame)

    @property
    def times(self) -> np.ndarray:
        """Times of the frames [s]."""
        return self._source.times

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of the arrays that a frame holds."""
        return tuple(self._source.names(0)) if len(self.times) else ()

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies; the field "body" holds their numbers."""
        return tuple(self._source.meta.get("bodies", ()))

    @property
    def meta(self) -> Mapping[str, Any]:
        """Facts about the run: versions, space, units ..."""
        return self._source.meta

    @property
    def scene(self) -> str | None:
        """The scene file's text; None if the run came from a script that no scene file can say."""
        return self._source.scene

    @property
    def history(self) -> History:
        """The ledger over time: ``history["kinetic"]`` or ``history.kinetic``."""
        return self._source.history()

    @property
    def left(self) -> History:
        """Particles that left the domain and were taken out (`Simulation.leaving`): step, t, id, body, m, x, y, z, vx, vy, vz of each."""
        return self._source.left()

    def at(self, time: float | str) -> Frame:
        """The frame nearest to a time.

        Parameters
        ----------
        time : float or str
            Seconds, or text with a unit such as "2 ms".

        Raises
        ------
        ResultsError
            If there is no frame, or the time is not a number.
        """
        if isinstance(time, str):
            from mpmkit.units import to_si

            time = to_si(time, "s", "time")
        if not len(self.times):
            raise ResultsError(f"{self._source.where} holds no frame yet")
        if not np.isfinite(time):
            raise ResultsError(f"time must be a number of seconds, got {time!r} (frames go from {self.times[0]:g} to {self.times[-1]:g} s)")
        return self.frames[int(np.argmin(np.abs(self.times - time)))]

    def refresh(self) -> Results:
        """Look again for frames of a run that is still going on."""
        if isinstance(self._source, FileSource):
            self._source.refresh()
        return self

    def plot(
        self,
        field: str = "v",
        time: float | str | Sequence[float | str] | None = None,
        path: str | os.PathLike[str] | None = None,
        component: str | None = None,
        **options: Any,
    ) -> Figure:
        """Draw a field, or the history; see `mpmkit.views.view` for the options.

        Parameters
        ----------
        field : str
            A field ("v", "stress", "stress.xx", "pressure"), "energies", or a column of the history.
        time : float, str or several of them
            Nearest frames are drawn side by side; the last frame if none is given.
        path : path
            Picture file to write, by its ending .png, .pdf or .svg.
        component : str
            "xx", "x" ...; the same as ``"stress.xx"``.

        Returns
        -------
        matplotlib.figure.Figure
            To add to or to save.
        """
        from mpmkit.views import view

        return view(self, field, time, path, component=component, **options)

    def to_pandas(self, time: float | str | None = None) -> Any:
        """One frame (the last if no time is given) as a pandas DataFrame, a row per particle, columns such as ``stress.xx``."""
        from mpmkit._core.reading.convert import to_pandas

        return to_pandas(self._chosen(time), self.bodies)

    def to_xarray(self) -> Any:
        """All frames as an xarray Dataset with dimensions time, particle and component."""
        from mpmkit._core.reading.convert import to_xarray

        return to_xarray(self)

    def to_pyvista(self, time: float | str | None = None) -> Any:
        """One frame (the last if no time is given) as a pyvista PolyData."""
        from mpmkit._core.reading.convert import to_pyvista

        return to_pyvista(self._chosen(time))

    def _chosen(self, time: float | str | None) -> Frame:
        return self.at(self.times[-1] if time is None and len(self.times) else (time or 0.0))

    def _frame(self, k: int) -> Frame:
        source = self._source
        where = f"frame {k} of {source.where}"
        return Frame(source.times[k], source.steps[k], k, source.names(k), lambda name: source.array(k, name), self.bodies, where)

    def __repr__(self) -> str:
        span = f"t = {self.times[0]:g} to {self.times[-1]:g} s" if len(self.times) else "none yet"
        where = f"{self._source.where}: {len(self.times)} frames ({span})"
        return f"<Results {where}, fields {', '.join(self.fields)}, bodies {', '.join(self.bodies)}>"

    def _repr_html_(self) -> str:
        span = f"{self.times[0]:g} to {self.times[-1]:g} s" if len(self.times) else "none yet"
        rows = {
            "frames": f"{len(self.times)} ({span})",
            "fields": ", ".join(self.fields),
            "bodies": ", ".join(self.bodies),
            "written by": ", ".join(f"{k} {v}" for k, v in self.meta.get("versions", {}).items()),
        }
        body = "".join(
            f"<tr><th style='text-align:left'>{k}</th><td style='text-align:left'>{escape(v)}</td></tr>" for k, v in rows.items() if v
        )
        return f"<b>{escape(self._source.where)}</b><table>{body}</table>"
