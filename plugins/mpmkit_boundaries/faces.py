"""Faces of the domain by name."""

import mpmkit as mpm

FACES = ("xmin", "xmax", "ymin", "ymax", "zmin", "zmax")


def resolve(faces, grid, who):
    """Names of faces, with "all" spelled out; `CompositionError` for a face the grid does not have."""
    out = []
    for face in faces:
        if face == "all":
            # the axis of an axisymmetric domain is no face: nothing can be behind it
            out += [f for f in grid.faces if not (grid.space == "axisymmetric" and f == "xmin" and grid.lower[0] == 0.0)]
        elif face in grid.faces:
            out.append(face)
        else:
            raise mpm.CompositionError(f"{who}: the {grid.dim}D grid has no face {face!r}; it has {', '.join(grid.faces)}")
    return tuple(dict.fromkeys(out))
