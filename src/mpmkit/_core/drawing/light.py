"""Light and shadow on the surface that a depth buffer holds.

A key light with soft shadows from its own depth buffer, a sky that is brighter above than below, and
corners darkened by how far the surface lies behind its surroundings.

References
----------
Luft, Colditz and Deussen (2006), Image enhancement by unsharp masking the depth buffer, doi:10.1145/1141911.1142016.
Reeves, Salesin and Cook (1987), Rendering antialiased shadows with depth maps, doi:10.1145/37401.37435.
"""

from __future__ import annotations

import numpy as np

from mpmkit._core.drawing.splat import Camera, Raster, splat

_SHADOW_PIXELS = 700
_TAPS = [(i, j) for i in (-2, -1, 0, 1, 2) for j in (-2, -1, 0, 1, 2) if i * i + j * j <= 4]


def normals(points: np.ndarray, radius: np.ndarray, owner: np.ndarray, depth: np.ndarray, raster: Raster, softness: float) -> np.ndarray:
    """Directions of the surface in camera axes at the pixels that have an owner, float32[k, 3].

    A mixture of each sphere's own direction and that of the smoothed surface, which shows the body's shape.

    Parameters
    ----------
    softness : float
        0 spheres only, 1 smooth surface only.
    """
    filled = owner >= 0
    row, column = np.nonzero(filled)
    across, up = raster.centres()
    k = owner[filled]
    centre, size = points.astype(np.float32)[k], np.maximum(radius, 0.75 * raster.pixel).astype(np.float32)[k]
    here = np.stack([across.astype(np.float32)[column], up.astype(np.float32)[row], depth[filled]], axis=1)
    own = (here - centre) / size[:, None]
    width = 1.1 * float(np.median(radius)) / raster.pixel if len(radius) else 1.0
    smooth, weight = np.where(filled, depth, np.float32(0)), filled.astype(np.float32)
    for _ in range(2):  # the second pass takes off what the first leaves of the single spheres
        smooth, cover = blur(smooth * weight, width), blur(weight, width)
        smooth = np.where(filled, smooth / np.maximum(cover, 1e-3), np.float32(0))
    # differences that stay inside the body, since outside there is no depth
    whole = np.ones_like(own)
    whole[:, 0] = -_slope(smooth, filled, 1)[filled] / raster.pixel
    whole[:, 1] = _slope(smooth, filled, 0)[filled] / raster.pixel
    whole /= np.sqrt((whole * whole).sum(axis=1, keepdims=True))
    mixed = (1 - softness) * own + softness * whole
    return np.asarray(mixed / np.maximum(np.sqrt((mixed * mixed).sum(axis=1, keepdims=True)), 1e-6))


def _slope(image: np.ndarray, filled: np.ndarray, axis: int) -> np.ndarray:
    """Difference per pixel, central inside and one-sided at the edge of what is filled."""
    ahead, behind = np.zeros_like(image), np.zeros_like(image)
    cut_low = tuple(slice(None, -1) if a == axis else slice(None) for a in (0, 1))
    cut_high = tuple(slice(1, None) if a == axis else slice(None) for a in (0, 1))
    both = filled[cut_low] & filled[cut_high]
    step = np.where(both, image[cut_high] - image[cut_low], np.float32(0))
    ahead[cut_low], behind[cut_high] = step, step
    count = np.zeros_like(image)
    count[cut_low] += both
    count[cut_high] += both
    return np.asarray((ahead + behind) / np.maximum(count, 1))


def occlusion(depth: np.ndarray, filled: np.ndarray, unit: float, raster: Raster) -> np.ndarray:
    """How open each pixel of the particles is, 0 to 1: darker where the smoothed depth lies in front of it.

    `unit` is the particles' radius [m].
    """
    base = float(depth[filled].min()) if filled.any() else 0.0
    height = np.where(filled, depth, np.float32(base)).astype(np.float32)
    shade = np.zeros_like(height)
    for width, strength in ((2.0, 0.30), (6.0, 0.30), (16.0, 0.25)):  # in units of the particle radius
        behind = blur(height, width * unit / raster.pixel) - height
        shade += strength * np.clip(behind / (width * unit), 0.0, 1.0)
    return np.asarray(np.exp(-1.6 * shade))


def blur(image: np.ndarray, width: float) -> np.ndarray:
    """Gaussian blur of `width` pixels; wide ones are made on a coarser image, where they cost the same as narrow ones."""
    from scipy.ndimage import gaussian_filter

    n = int(width / 3)
    if n < 2:
        return np.asarray(gaussian_filter(image, width))
    rows, columns = image.shape
    padded = np.pad(image, ((0, -rows % n), (0, -columns % n)), mode="edge")
    coarse = padded.reshape(padded.shape[0] // n, n, padded.shape[1] // n, n).mean(axis=(1, 3))
    coarse = gaussian_filter(coarse, width / n)
    return _stretch(_stretch(coarse, rows, n).T, columns, n).T


def _stretch(coarse: np.ndarray, rows: int, n: int) -> np.ndarray:
    """Interpolate between coarse rows, n fine ones each."""
    at = np.clip((np.arange(rows, dtype=np.float32) + 0.5) / n - 0.5, 0, len(coarse) - 1)
    below = np.minimum(at.astype(int), max(0, len(coarse) - 2))
    part = (at - below).astype(np.float32)[:, None]
    return np.asarray(coarse[below] * (1 - part) + coarse[np.minimum(below + 1, len(coarse) - 1)] * part)


class Shadow:
    """What the key light sees; asked later whether a point is lit.

    Parameters
    ----------
    points : float64[n, 3]
        Centres in space [m].
    radius : float64[n]
        Radii [m].
    light : float64[3]
        Direction toward the light, in space.
    """

    def __init__(self, points: np.ndarray, radius: np.ndarray, light: np.ndarray) -> None:
        self._camera = Camera.along(light)
        seen = self._camera.project(points)
        low, high = (seen - radius[:, None]).min(axis=0), (seen + radius[:, None]).max(axis=0)
        pixel = float((high - low)[:2].max()) / _SHADOW_PIXELS
        shape = tuple(int(np.ceil(n)) + 1 for n in ((high - low)[1] / pixel, (high - low)[0] / pixel))
        self._raster = Raster((shape[0], shape[1]), pixel, (float(low[0]), float(low[1])))
        _, self._depth = splat(seen, radius, self._raster)
        self._bias = 1.2 * float(np.median(radius)) + 2 * pixel
        # a penumbra about a radius wide, so that single particles do not draw dots
        self._step = max(1.0, 0.6 * float(np.median(radius)) / pixel)

    def lit(self, where: np.ndarray) -> np.ndarray:
        """Share of the light that reaches each point, float32[k] from 0 to 1; `where` is [k, 3] [m]."""
        seen = self._camera.project(where).astype(np.float32)
        rows, columns = self._raster.shape
        # a margin of open sky around the map spares the question whether a tap lies inside
        reach = 2 * self._step + 1
        sky = int(2 * reach) + 2
        depth = np.pad(self._depth, sky, constant_values=-np.inf).ravel()
        wide = columns + 2 * sky
        i = np.clip((seen[:, 0] - self._raster.origin[0]) / self._raster.pixel, -reach, columns + reach)
        j = np.clip(rows - (seen[:, 1] - self._raster.origin[1]) / self._raster.pixel, -reach, rows + reach)
        limit = seen[:, 2] + np.float32(self._bias)
        total = np.zeros(len(seen), dtype=np.float32)
        for a, b in _TAPS:
            column, row = (i + (a * self._step + sky)).astype(np.int32), (j + (b * self._step + sky)).astype(np.int32)
            total += depth[row * wide + column] <= limit
        return np.asarray(total / len(_TAPS))
