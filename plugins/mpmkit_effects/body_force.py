"""Body force as a function of position and time."""

import mpmkit as mpm


@mpm.kernel
def given_force(value):
    """b(x_p, t) per mass."""
    return value


@mpm.define
class BodyForce(mpm.Effect):
    """Force per mass on every particle, f_i += sum_p m_p b(x_p, t) N_i (SAND2002-0482 eq 1-17a).

    ``value`` is a vector, texts of formulas in x, y, z (current position), X, Y, Z (initial position) and t, or a
    scalar Python function that asks for any of ``x``, ``X``, ``v``, ``t`` by name and returns the vector.
    """

    references = ("Chen and Brannon (2002), SAND2002-0482, eq 1-17a",)
    value: mpm.Value = mpm.parameter("force per mass", unit="m/s^2", example=(0.0, -9.81))
    body_force = given_force
