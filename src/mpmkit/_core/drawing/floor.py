"""The floor of a 3D picture: where it is seen, and how things standing on it darken it."""

from __future__ import annotations

import attrs
import numpy as np

from mpmkit._core.drawing.light import blur
from mpmkit._core.drawing.splat import Camera, Raster, splat

_PIXELS = 400


@attrs.frozen(eq=False)
class Floor:
    """The lower face of a box from `lower` to `upper`, float64[3] each [m]."""

    lower: np.ndarray
    upper: np.ndarray

    def depth(self, camera: Camera, raster: Raster) -> tuple[np.ndarray, np.ndarray]:
        """Depth of the floor behind each pixel, and whether the pixel looks at it."""
        across, up = raster.centres()
        depth = np.broadcast_to(((self.lower[2] - up * camera.up[2]) / camera.toward[2])[:, None], raster.shape)
        px = across[None, :] * camera.right[0] + up[:, None] * camera.up[0] + depth * camera.toward[0]
        py = across[None, :] * camera.right[1] + up[:, None] * camera.up[1] + depth * camera.toward[1]
        inside = (px >= self.lower[0]) & (px <= self.upper[0]) & (py >= self.lower[1]) & (py <= self.upper[1])
        return depth, inside

    def contact(self, x: np.ndarray, radius: np.ndarray, where: np.ndarray) -> np.ndarray:
        """How much the sky is covered by what is just above each point of the floor, from 0 (open) to 1; `where` is [k, 3] [m]."""
        below = Camera(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, -1.0]))
        size = self.upper - self.lower
        pixel = float(max(size[:2])) / _PIXELS
        raster = Raster((int(size[1] / pixel) + 1, int(size[0] / pixel) + 1), pixel, (float(self.lower[0]), float(self.lower[1])))
        _, height = splat(below.project(x), radius, raster)
        reach = 8.0 * float(np.median(radius))
        gap = np.maximum(-height - self.lower[2], 0.0)
        cover = blur(np.exp(-gap / reach), 0.3 * reach / pixel)
        rows, columns = raster.shape
        column = np.clip((where[:, 0] - raster.origin[0]) / pixel, 0, columns - 1).astype(int)
        row = np.clip(rows - (where[:, 1] - raster.origin[1]) / pixel, 0, rows - 1).astype(int)
        return np.asarray(cover[row, column])
