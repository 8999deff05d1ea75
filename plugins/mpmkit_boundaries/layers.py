"""Which particles of a body form its boundary layer at a face, or in a region."""

import mpmkit as mpm
from mpmkit.interfaces.boundary import Selection


def face_layer(points, face, thickness, who):
    """Particles within `thickness` of the body's own face ("xmin" ...), with outward normals and vectors to the face."""
    import numpy as np

    axis, sign = "xyz".index(face[0]), (-1.0 if face.endswith("min") else 1.0)
    if axis >= points.x.shape[1]:
        raise mpm.CompositionError(f"{who}: a {points.x.shape[1]}D body has no face {face!r}")
    outer = sign * points.x[:, axis] + points.size[:, axis]
    surface = outer.max()
    depth = surface - sign * points.x[:, axis]
    tolerance = 1e-9 * np.ptp(outer) + 1e-12 * abs(surface)
    chosen = np.flatnonzero(
        depth < thickness - tolerance if thickness is not None else surface - outer < tolerance + 0.5 * points.size[:, axis]
    )
    if chosen.size == 0:
        raise mpm.CompositionError(
            f"{who}: no particle lies within {thickness:g} m of the face {face!r}; the layer is thinner than half a particle"
        )
    normals, arms = np.zeros((chosen.size, 3)), np.zeros((chosen.size, 3))
    normals[:, axis] = sign
    arms[:, axis] = sign * depth[chosen]
    return chosen, normals, arms


def selection(chosen, area, normals, arms):
    """A `Selection` with particle numbers of the type the loops expect."""
    import numpy as np

    return Selection(chosen.astype(np.int64), area, normals, arms)
