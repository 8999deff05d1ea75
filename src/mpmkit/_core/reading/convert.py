"""Results as objects of other libraries, which are imported only here."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from mpmkit._core.reading.components import component_names
from mpmkit.errors import ResultsError

if TYPE_CHECKING:
    from mpmkit._core.reading.frame import Frame
    from mpmkit.results import Results


def to_pandas(frame: Frame, bodies: Sequence[str]) -> Any:
    """A row per particle, a column per component, body names as a category."""
    pandas = _import("pandas", "to_pandas", "frames")
    table = pandas.DataFrame(dict(_columns(frame)))
    if "body" in table and bodies:
        table["body"] = pandas.Categorical.from_codes(table["body"].astype(int), categories=list(bodies))
    table.attrs.update(time=frame.time, step=frame.step)
    return table


def to_xarray(results: Results) -> Any:
    """Variables (time, particle) and (time, particle, component); components are labelled x, y, z or xx, yy ...

    Raises
    ------
    ResultsError
        If particles were lost on the way: then rows do not belong together.
    """
    xarray = _import("xarray", "to_xarray", "frames")
    counts = {frame.n_particles for frame in results.frames}
    if len(counts) != 1:
        raise ResultsError(
            f"to_xarray needs the same particles in all frames, their number varies ({sorted(counts)}); use to_pandas(time) for each frame"
        )
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {"time": ("time", results.times, {"units": "s"}), "step": ("time", [f.step for f in results.frames])}
    for name in results.fields:
        array = np.stack([frame[name] for frame in results.frames])
        units = {"units": results.meta.get("units", {}).get(name, "")}
        if array.ndim == 2:
            variables[name] = (("time", "particle"), array, units)
        else:
            axis = f"component{array.shape[2]}"
            coordinates[axis] = list(component_names(array.shape[2]))
            variables[name] = (("time", "particle", axis), array, units)
    return xarray.Dataset(variables, coordinates)


def to_pyvista(frame: Frame) -> Any:
    """A vertex per particle, all fields as point data."""
    pyvista = _import("pyvista", "to_pyvista", "vis")
    x = frame["x"]
    cloud = pyvista.PolyData(np.pad(x, ((0, 0), (0, 3 - x.shape[1]))))
    for name in frame:
        if name != "x":
            array = frame[name]
            missing = 3 - array.shape[1] if array.ndim == 2 and array.shape[1] < 3 else 0
            cloud.point_data[name] = np.pad(array, ((0, 0), (0, missing))) if missing else array
    cloud.field_data["time"] = [frame.time]
    return cloud


def _columns(frame: Frame) -> Iterator[tuple[str, np.ndarray]]:
    for name in frame:
        array = frame[name]
        if array.ndim == 1:
            yield name, array
        else:
            rows = array.reshape(len(array), -1)
            for k, component in enumerate(component_names(rows.shape[1])):
                yield f"{name}.{component}", rows[:, k]


def _import(module: str, method: str, extra: str) -> Any:
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError:
        raise ResultsError(f"Results.{method} needs {module}, which is not installed: pip install 'mpmkit[{extra}]'") from None
