"""What a wall remembers from step to step, where the recipe asks for it (`Composition.remembers`): which nodes it holds."""

from __future__ import annotations

from typing import Any

import numpy as np


class Held:
    """Flags of the nodes of one layer in one velocity field; they stay with the nodes when particles are sorted anew.

    Attributes
    ----------
    keys : int64[n]
        Which node of the grid, and on which face: a node at an edge of the domain is listed once for each of its faces.
    flags : bool[n]
        Whether the layer held it in the last step.
    """

    def __init__(self) -> None:
        self.keys: Any = np.zeros(0, dtype=np.int64)
        self.flags: Any = np.zeros(0, dtype=np.bool_)

    def of(self, nodes: Any, normals: Any) -> Any:
        """The flags of these nodes, for loops to read and to write; nodes that were not listed before are free.

        Parameters
        ----------
        nodes : int64[n]
            Numbers that belong to the nodes wherever they are stored.
        normals : float[n, 3]
            Normals of the faces they are listed for, zero off the faces.
        """
        faces = 1 + 2 * np.abs(normals).argmax(axis=1) + (normals.sum(axis=1) > 0.0)
        keys = 8 * nodes + np.where(normals.any(axis=1), faces, 0)
        if not np.array_equal(keys, self.keys):
            held = self.keys[self.flags]
            self.keys, self.flags = keys, np.isin(keys, held)
        return self.flags

    def state(self) -> dict[str, Any]:
        """What a run that goes on from here must know."""
        return {"keys": self.keys, "flags": self.flags}

    def restore(self, keys: Any, flags: Any) -> None:
        """Take over what `state` has given."""
        self.keys, self.flags = np.array(keys), np.array(flags)
