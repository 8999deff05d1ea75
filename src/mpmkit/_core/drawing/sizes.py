"""How large particles are drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from mpmkit._core.reading.frame import Frame
    from mpmkit.results import Results


def half_edges(results: Results, frame: Frame) -> np.ndarray:
    """Half the edge of a square or cube of each particle's present size, float64[n] [m].

    Known from the field "V" (or "V0"), else from "size" with "J" if it was kept, else from the distance to
    the nearest neighbour of the same body at the start. The volume is not used in axisymmetric runs, where
    it grows with the radius.
    """
    x = frame["x"]
    dim = x.shape[1]
    if results.meta.get("space") != "axisymmetric":
        for name in ("V", "V0"):
            if name in frame:
                return np.asarray(0.5 * np.abs(frame[name].astype(float)) ** (1 / dim))
    if "size" in frame:
        mean = np.prod(frame["size"][:, :dim].astype(float), axis=1) ** (1 / dim)
        return np.asarray(mean * np.abs(frame["J"].astype(float)) ** (1 / dim) if "J" in frame else mean)
    return _from_neighbours(results, frame)


def _from_neighbours(results: Results, frame: Frame) -> np.ndarray:
    from scipy.spatial import cKDTree

    first = results.frames[0]
    body = first["body"] if "body" in first else np.zeros(first.n_particles)
    now = frame["body"] if "body" in frame else np.zeros(frame.n_particles)
    half = np.zeros(frame.n_particles)
    x = first["x"].astype(float)
    extent = float(np.ptp(x, axis=0).max()) if len(x) else 1.0
    for number in np.unique(now):
        own = x[body == number]
        # median, since particles at a curved edge may lie closer
        distance = float(np.median(cKDTree(own).query(own, k=2)[0][:, 1])) if len(own) > 1 else 0.02 * (extent or 1.0)
        half[now == number] = 0.5 * distance
    return half


def deformed(frame: Frame) -> np.ndarray:
    """Corners of each particle's parallelogram, from "size" and "F", float64[n, 4, 2] [m]."""
    x = frame["x"].astype(float)[:, :2]
    flat = frame["F"].reshape(len(x), -1).astype(float)
    # nine components in three dimensions, else those of the plane
    gradient = flat.reshape(-1, 3, 3)[:, :2, :2] if flat.shape[1] == 9 else flat[:, :4].reshape(-1, 2, 2)
    edges = gradient * frame["size"].astype(float)[:, None, :2]
    corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)], dtype=float)
    return np.asarray(x[:, None, :] + np.einsum("nab,kb->nka", edges, corners))
