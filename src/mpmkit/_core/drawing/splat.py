"""Spheres into an image with a depth buffer, in plain numpy."""

from __future__ import annotations

import attrs
import numpy as np

EMPTY = -1


@attrs.frozen(eq=False)
class Camera:
    """Parallel projection: image axes `right` and `up`, and `toward` the viewer; unit vectors, float64[3]."""

    right: np.ndarray
    up: np.ndarray
    toward: np.ndarray

    @classmethod
    def orbit(cls, azimuth: float, elevation: float) -> Camera:
        """Look at the origin from `azimuth` around z and `elevation` above the plane z = 0 [degrees]."""
        a, e = np.radians([azimuth, elevation])
        toward = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        return cls(right, np.cross(toward, right), toward)

    @classmethod
    def along(cls, toward: np.ndarray) -> Camera:
        """Look along -`toward`, any roll."""
        toward = toward / np.linalg.norm(toward)
        helper = np.array([0.0, 0.0, 1.0]) if abs(toward[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
        right = np.cross(helper, toward)
        right /= np.linalg.norm(right)
        return cls(right, np.cross(toward, right), toward)

    def project(self, points: np.ndarray) -> np.ndarray:
        """Columns: along right, along up, toward the viewer, float64[n, 3] [m]."""
        return np.asarray(points @ np.stack([self.right, self.up, self.toward], axis=1))


@attrs.frozen(eq=False)
class Raster:
    """The pixels of a picture: `shape` (rows, columns), `pixel` size [m], left and lower edge `origin` [m]."""

    shape: tuple[int, int]
    pixel: float
    origin: tuple[float, float]

    def centres(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions of the pixels along right (columns) and up (rows, from the top) [m]."""
        rows, columns = self.shape
        across = self.origin[0] + (np.arange(columns) + 0.5) * self.pixel
        up = self.origin[1] + (rows - np.arange(rows) - 0.5) * self.pixel
        return across, up


def splat(points: np.ndarray, radius: np.ndarray, raster: Raster) -> tuple[np.ndarray, np.ndarray]:
    """Find the nearest sphere behind each pixel.

    Parameters
    ----------
    points : float64[n, 3]
        Centres as `Camera.project` gives them [m].
    radius : float64[n]
        Radii [m].
    raster : Raster
        The pixels.

    Returns
    -------
    owner : int64[rows, columns]
        Number of the sphere, `EMPTY` where there is none.
    depth : float32[rows, columns]
        Height of its surface toward the viewer [m], -inf where there is none.
    """
    rows, columns = raster.shape
    depth = np.full(rows * columns, -np.inf, dtype=np.float32)
    owner = np.full(rows * columns, EMPTY, dtype=np.int64)
    u = (points[:, 0] - raster.origin[0]) / raster.pixel
    v = rows - (points[:, 1] - raster.origin[1]) / raster.pixel
    # never smaller than a pixel, or a sphere could fall between the pixel centres
    size = np.maximum(radius / raster.pixel, 0.75)
    reaches = np.ceil(size).astype(int)
    many = []
    for reach in np.unique(reaches):
        group = np.flatnonzero(reaches == reach)
        if len(group) < (2 * reach + 1) ** 2:
            _few(group, u, v, size, points[:, 2], raster, depth, owner)
        else:
            many.append((int(reach), group))
    for claim in (False, True):  # first the depth of the nearest surface, then whose it is
        for reach, group in many:
            _many(group, reach, u, v, size, points[:, 2], raster, depth, owner, claim)
    return owner.reshape(rows, columns), depth.reshape(rows, columns)


def _few(
    group: np.ndarray, u: np.ndarray, v: np.ndarray, size: np.ndarray, z: np.ndarray, raster: Raster, depth: np.ndarray, owner: np.ndarray
) -> None:
    """Large spheres, one after the other with all pixels of each at once; to be drawn before the small ones."""
    rows, columns = raster.shape
    depth, owner = depth.reshape(rows, columns), owner.reshape(rows, columns)
    for p in group:
        left, right = max(0, int(u[p] - size[p]) - 1), min(columns, int(u[p] + size[p]) + 2)
        top, bottom = max(0, int(v[p] - size[p]) - 1), min(rows, int(v[p] + size[p]) + 2)
        if left >= right or top >= bottom:
            continue
        inside = size[p] ** 2 - (np.arange(left, right) + 0.5 - u[p])[None, :] ** 2 - (np.arange(top, bottom) + 0.5 - v[p])[:, None] ** 2
        surface = (z[p] + raster.pixel * np.sqrt(np.maximum(inside, 0.0))).astype(np.float32)
        front = (inside > 0) & (surface > depth[top:bottom, left:right])
        depth[top:bottom, left:right][front] = surface[front]
        owner[top:bottom, left:right][front] = p


def _many(
    group: np.ndarray, reach: int, u: np.ndarray, v: np.ndarray, size: np.ndarray, z: np.ndarray,
    raster: Raster, depth: np.ndarray, owner: np.ndarray, claim: bool,
) -> None:  # fmt: skip
    """Small spheres, one pixel of all of them after the other."""
    rows, columns = raster.shape
    gu, gv, gs, gz = u[group], v[group], size[group], z[group]
    left, top = np.floor(gu).astype(int), np.floor(gv).astype(int)
    for j in range(-reach, reach + 1):
        for i in range(-reach, reach + 1):
            across, down = left + i + 0.5 - gu, top + j + 0.5 - gv
            inside = gs * gs - across * across - down * down
            hit = (inside > 0) & (left + i >= 0) & (left + i < columns) & (top + j >= 0) & (top + j < rows)
            if not hit.any():
                continue
            pixel = ((top + j) * columns + left + i)[hit]
            surface = (gz[hit] + raster.pixel * np.sqrt(inside[hit])).astype(np.float32)
            if claim:
                front = surface == depth[pixel]
                owner[pixel[front]] = group[hit][front]
            else:
                np.maximum.at(depth, pixel, surface)
