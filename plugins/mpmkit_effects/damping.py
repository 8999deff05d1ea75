"""Mass-proportional damping."""

import mpmkit as mpm


@mpm.kernel
def drag(v, rate):
    """a_i = -rate v_i."""
    return (-rate * v[0], -rate * v[1], -rate * v[2])


@mpm.define
class Damping(mpm.Effect):
    """Mass-proportional (viscous) damping, a_i = -rate v_i: motion decays as exp(-rate t).

    For quasi-static solutions; it damps rigid motion too. Its work is counted as dissipated.
    """

    references = ("Rayleigh (1877), The theory of sound, section 81 (mass-proportional part)",)
    rate: float = mpm.parameter("decay rate", unit="1/s", ge=0.0, example=10.0)
    acceleration = drag
    work = "dissipated"

    def rates(self):
        return {"damping": self.rate}
