"""Pictures of results: profiles in 1D, particles in 2D, lit spheres in 3D, histories as lines."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from mpmkit.errors import ResultsError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mpmkit.results import Results

ENDINGS = (".png", ".pdf", ".svg", ".jpg", ".webp")
"""Kinds of picture file."""
HISTORY = ("energies", "history")
"""Names that mean the energies over time."""


def view(
    results: Results,
    field: str = "v",
    time: float | str | Sequence[float | str] | None = None,
    path: str | os.PathLike[str] | None = None,
    *,
    component: str | None = None,
    limits: tuple[float, float] | None = None,
    cmap: str | None = None,
    window: Sequence[tuple[float, float]] | None = None,
    marker: str = "square",
    exact: Callable[[np.ndarray, float], np.ndarray] | None = None,
    azimuth: float = -58.0,
    elevation: float = 22.0,
    floor: bool = True,
    axes_box: bool = True,
    softness: float = 0.55,
    dpi: float = 150.0,
) -> Figure:
    """Draw a field of the particles, or the history of the run.

    Parameters
    ----------
    results : Results
        The run.
    field : str
        A recorded field or a component of it ("v", "stress.xx", "F.xy"), "pressure", "displacement", "body"; or
        "energies" or a column of the history. A vector alone means its length, the stress alone von
        Mises' equivalent stress; in 1D both mean their component along x.
    time : float, str or several of them
        Simulated time [s] or text such as "2 ms"; the nearest frames are drawn side by side with one colour scale (1D: in one
        diagram). The last frame if none is given.
    path : path, optional
        Picture file to write, with one of `ENDINGS`; an existing picture is replaced.
    component : str, optional
        The same as ``field.component``.
    limits : (low, high), optional
        Ends of the colours, in the SI unit of the field.
    cmap : str, optional
        Colour map of matplotlib.
    window : sequence of (low, high), optional
        What to show in each direction [m].
    marker : str
        2D: "square" or "disc" of the particle's area, or "deformed": its parallelogram, if "F" and "size" were recorded.
    exact : callable, optional
        1D: a solution ``exact(x, t)`` to draw beside the particles, in SI.
    azimuth, elevation : float
        3D: where the viewer stands [degrees]; around z from +x, and above the ground.
    floor, axes_box : bool
        3D: shadows on the lower face; edges and scales of the box.
    softness : float
        3D: 0 shows single spheres, 1 a smooth surface.
    dpi : float
        Pixels per inch of the picture file.

    Returns
    -------
    matplotlib.figure.Figure
        To add to or to save.

    Raises
    ------
    ResultsError
        If there is nothing to draw under this name, or the picture cannot be written.
    """
    target = _picture(path)
    from mpmkit._core.drawing import style

    figure: Figure
    with style.styled():
        if _means_history(results, field):
            from mpmkit._core.drawing.over_time import draw_history, energy_columns

            columns = energy_columns(results) if field in HISTORY else [field]
            if not columns:
                raise ResultsError(f"the history has no energies (it has {', '.join(results.history)}); name one of its columns")
            figure = draw_history(results, columns)
        else:
            times = [time] if isinstance(time, (int, float, str)) else list(results.times[-1:] if time is None else time)
            if not times or not len(results.times):
                raise ResultsError("there is no frame to draw" + (" yet" if not len(results.times) else ": the list of times is empty"))
            frames = [results.at(t) for t in times]
            from mpmkit._core.drawing.quantity import quantity

            shown, dim = quantity(results, frames[0], field, component), frames[0]["x"].shape[1]
            if window is not None and (len(window) != dim or any(len(w) != 2 or not w[1] > w[0] for w in window)):
                raise ResultsError(f"window must be {dim} pairs (low, high) with low < high, got {window!r}")
            box = tuple((float(a), float(b)) for a, b in window) if window is not None else None
            if dim == 1:
                from mpmkit._core.drawing.profile import draw_profile

                figure = draw_profile(results, frames, shown, exact=exact, window=box)
            elif dim == 2:
                from mpmkit._core.drawing.plane import draw_plane

                figure = draw_plane(results, frames, shown, limits=limits, cmap=cmap, window=box, marker=marker)
            else:
                from mpmkit._core.drawing.space import draw_space

                figure = draw_space(
                    results, frames, shown, limits=limits, cmap=cmap, window=box, azimuth=azimuth, elevation=elevation, floor=floor,
                    axes_box=axes_box, softness=softness,
                )  # fmt: skip
        if target is not None:
            _save(figure, target, dpi)
    return figure


def _means_history(results: Results, field: str) -> bool:
    """A name that is no field but a column of the history, or one of `HISTORY`."""
    from mpmkit._core.drawing.quantity import DERIVED

    if field in HISTORY:
        return True
    name = field.partition(".")[0]
    if name in results.fields or name in DERIVED:
        return False
    try:
        return field in results.history
    except ResultsError:
        return False  # no history beside the file; the error about the field says more


def _picture(path: str | os.PathLike[str] | None) -> Path | None:
    """Check, before drawing, that the picture can be written."""
    if path is None:
        return None
    target = Path(path)
    if target.suffix.lower() not in ENDINGS:
        raise ResultsError(f"{target}: a picture file ends in one of {', '.join(ENDINGS)}")
    if not target.parent.is_dir():
        raise ResultsError(f"{target}: there is no folder {target.parent}; make it or choose another path")
    return target


def _save(figure: Figure, target: Path, dpi: float) -> None:
    try:
        figure.savefig(target, dpi=dpi, facecolor="white", bbox_inches="tight", pad_inches=0.12)
    except OSError as error:
        raise ResultsError(f"{target}: cannot write the picture ({error.strerror or error})") from error
