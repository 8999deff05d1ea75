"""The vocabulary: every standard particle and grid field, with its shape, unit and meaning, said once."""

from __future__ import annotations

import attrs


@attrs.frozen
class Field:
    """One quantity that every particle of a body carries.

    Parameters
    ----------
    name : str
        The letter of the literature; the same name in kernels, results and messages.
    unit : str
        SI unit, "1" if dimensionless.
    doc : str
        What it is.
    shape : str
        "scalar", "vector" (one component per space dimension), "symmetric" (xx yy zz xy yz xz) or "tensor" (3 x 3).
    initial : float
        Value at the start, of every component.
    """

    name: str
    unit: str = "1"
    doc: str = ""
    shape: str = attrs.field(default="scalar", validator=attrs.validators.in_(("scalar", "vector", "symmetric", "tensor")))
    initial: float = 0.0


PARTICLE_FIELDS: dict[str, Field] = {
    f.name: f
    for f in (
        Field("x", "m", "position", "vector"),
        Field("X", "m", "position at the start", "vector"),
        Field("v", "m/s", "velocity", "vector"),
        Field("m", "kg", "mass"),
        Field("V0", "m^3", "initial volume"),
        Field("V", "m^3", "current volume, J V0"),
        Field("rho", "kg/m^3", "current density, m / V"),
        Field("F", "1", "deformation gradient", "tensor"),
        Field("J", "1", "determinant of F", "scalar", 1.0),
        Field("L", "1/s", "velocity gradient, L_ab = dv_a / dx_b", "tensor"),
        Field("C", "1/s", "affine velocity matrix of APIC and TPIC (B D^-1)", "tensor"),
        Field("stress", "Pa", "Cauchy stress, tension positive", "symmetric"),
        Field("q", "Pa", "artificial viscous pressure"),
        Field("size", "m", "half of the initial edge lengths of the particle", "vector"),
        Field("size_now", "m", "half of the edge lengths of the particle when the step began", "vector"),
        Field("c", "m/s", "wave speed"),
    )
}
"""Standard particle fields. What a simulation really stores is decided by its composition."""

KERNEL_ARGUMENTS: dict[str, str] = {
    "t": "time [s]",
    "dt": "time step [s]",
    "h": "smallest grid spacing [m]",
    "dim": "number of space dimensions",
}
"""Names a kernel may ask for beside fields and its own parameters."""
