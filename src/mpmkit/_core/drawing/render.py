"""A lit picture of particles in space, as an image with transparency."""

from __future__ import annotations

import numpy as np

from mpmkit._core.drawing.floor import Floor
from mpmkit._core.drawing.light import Shadow, blur, normals, occlusion
from mpmkit._core.drawing.splat import Camera, Raster, splat

GAMMA = 2.2
_FLOOR = 0.90  # brightness of the lit floor, in linear light
_KEY = np.array([-0.36, 0.72, 0.59])  # toward the light, in camera axes: from the upper left, in front


def render(
    x: np.ndarray,
    radius: np.ndarray,
    colours: np.ndarray,
    camera: Camera,
    raster: Raster,
    *,
    floor: Floor | None = None,
    softness: float = 0.55,
    oversample: int = 2,
) -> np.ndarray:
    """Draw particles as lit spheres.

    Parameters
    ----------
    x : float64[n, 3]
        Positions [m].
    radius : float64[n]
        Radii [m].
    colours : float64[n, 3]
        Red, green, blue from 0 to 1.
    camera, raster : Camera, Raster
        From where, and the pixels of the picture.
    floor : Floor, optional
        Where shadows fall; not seen from below.
    softness : float
        0 shows single spheres, 1 a smooth surface.
    oversample : int
        Fine pixels per pixel and direction, against stairs at the edges.

    Returns
    -------
    float32[rows, columns, 4]
        Red, green, blue, alpha.
    """
    fine = Raster((raster.shape[0] * oversample, raster.shape[1] * oversample), raster.pixel / oversample, raster.origin)
    seen = camera.project(x)
    owner, surface = splat(seen, radius, fine)
    filled = owner >= 0
    cover = filled
    if floor is not None and camera.toward[2] > 0.05:
        level, on_floor = floor.depth(camera, fine)
        cover = filled | on_floor
        surface = np.where(on_floor & ~filled, level, surface).astype(np.float32)
    body = filled[cover]  # of the covered pixels: particle or floor
    base = np.full((len(body), 3), _FLOOR, dtype=np.float32)
    base[body] = colours.astype(np.float32)[owner[filled]] ** np.float32(GAMMA)
    direction = np.empty_like(base)
    direction[~body] = camera.project(np.array([[0.0, 0.0, 1.0]]))[0]
    direction[body] = normals(seen, radius, owner, surface, fine, softness)
    lit, opened = np.ones((2, len(body)), dtype=np.float32)
    covered = np.zeros(int((~body).sum()), dtype=np.float32)
    if len(x):
        light = _KEY[0] * camera.right + _KEY[1] * camera.up + _KEY[2] * camera.toward
        where = _positions(cover, surface, camera, fine)
        lit = Shadow(x, radius, light).lit(where)
        opened[body] = occlusion(surface, filled, float(np.median(radius)), fine)[filled]
        if floor is not None and not body.all():
            covered = floor.contact(x, radius, where[~body])
            lit[~body] = _softened(lit, cover & ~filled, cover, 1.5 * float(np.median(radius)) / fine.pixel)
    shaded = _shade(base, direction, lit, opened, camera)
    # the floor is paper: of all light on it only what is missing shows
    shaded[~body] = (_FLOOR * (1 - 0.30 * (1 - lit[~body])) * (1 - 0.45 * covered))[:, None]
    return _reduce(shaded, cover, oversample)


def _positions(cover: np.ndarray, surface: np.ndarray, camera: Camera, raster: Raster) -> np.ndarray:
    """Points in space seen at the covered pixels, float32[k, 3] [m]."""
    row, column = np.nonzero(cover)
    across, up = (c.astype(np.float32) for c in raster.centres())
    axes = np.stack([camera.right, camera.up, camera.toward]).astype(np.float32)
    return np.asarray(np.stack([across[column], up[row], surface[cover]], axis=1) @ axes)


def _softened(lit: np.ndarray, chosen: np.ndarray, cover: np.ndarray, width: float) -> np.ndarray:
    """Light on the chosen pixels, blurred among themselves by `width` pixels."""
    image, weight = np.zeros(cover.shape, dtype=np.float32), chosen.astype(np.float32)
    image[cover] = lit
    return np.asarray((blur(image * weight, width) / np.maximum(blur(weight, width), 1e-3))[chosen])


def _shade(base: np.ndarray, direction: np.ndarray, lit: np.ndarray, opened: np.ndarray, camera: Camera) -> np.ndarray:
    """Linear brightness of each pixel from the key light, a gleam and the sky."""
    key = (_KEY / np.linalg.norm(_KEY)).astype(np.float32)
    facing = np.clip(direction @ key, 0.0, 1.0)
    # the sky is brighter above: how far the surface looks up
    sky = 0.32 + 0.13 * (direction @ np.array([camera.right[2], camera.up[2], camera.toward[2]], dtype=np.float32))
    half = key + np.array([0.0, 0.0, 1.0], dtype=np.float32)
    gleam = np.clip(direction @ (half / np.linalg.norm(half)), 0.0, 1.0) ** 40
    shadowed = 0.25 + 0.75 * lit  # light that other surfaces send into the shadow
    return np.asarray(
        base * ((0.66 * facing * shadowed + sky * opened) * (0.6 + 0.4 * opened))[:, None] + (0.05 * gleam * lit * opened)[:, None]
    )


def _reduce(shaded: np.ndarray, cover: np.ndarray, n: int) -> np.ndarray:
    """Average blocks of n x n fine pixels in linear light; back to display values."""
    rows, columns = cover.shape[0] // n, cover.shape[1] // n
    image = np.zeros((*cover.shape, 4), dtype=np.float32)
    image[cover, :3], image[cover, 3] = np.clip(shaded, 0.0, 1.0), 1.0
    image = image.reshape(rows, n, columns, n, 4).mean(axis=(1, 3))
    image[..., :3] = (image[..., :3] / np.maximum(image[..., 3:], 1e-6)) ** np.float32(1 / GAMMA)
    return np.asarray(image)
