"""Averages of tent functions over a particle, by the shares of the particle in the cells it covers."""

TINY = 1e-30
"""Keeps a particle of size zero from giving 0 / 0; representable in single precision."""


def share_below(node, f, half):
    """Share in [0, 1] of the particle [f - half, f + half] that lies below `node`.

    The difference of the tent's integrals at both ends would lose all digits for a small particle; this share does
    not, because node - f is exact near the node.
    """
    return min(1.0, max(0.0, 0.5 + 0.5 * (node - f) / (half + TINY)))


def centre(below, above, f, half):
    """Centre of the part of a particle between the shares `below` and `above`."""
    return f + half * (below + above - 1.0)
