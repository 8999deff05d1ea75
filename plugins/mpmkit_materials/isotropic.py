"""What all laws with isotropic elasticity have in common."""

import mpmkit as mpm


@mpm.define
class IsotropicElastic(mpm.ConstitutiveModel):
    """Young's modulus, Poisson's ratio and reference density, with the Lame constants made from them."""

    E: float = mpm.parameter("Young's modulus", unit="Pa", gt=0.0, example=1e7)
    nu: float = mpm.parameter("Poisson's ratio", gt=-1.0, lt=0.5, example=0.3)
    rho: float = mpm.parameter("reference density", unit="kg/m^3", gt=0.0, example=1000.0)

    @property
    def lam(self):
        """Lame's first constant [Pa]."""
        return self.E * self.nu / ((1.0 + self.nu) * (1.0 - 2.0 * self.nu))

    @property
    def mu(self):
        """Shear modulus [Pa]."""
        return self.E / (2.0 * (1.0 + self.nu))
