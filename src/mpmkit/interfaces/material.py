"""The contract of a constitutive model: stress and new state at one material point."""

from __future__ import annotations

from typing import ClassVar

from mpmkit.interfaces.component import Component
from mpmkit.kernels import Kernel


class ConstitutiveModel(Component):
    """Stress at one point from its deformation, with wave speed, energy and dissipation.

    Every constitutive model has a parameter ``rho``, the reference density [kg/m^3].

    Attributes
    ----------
    stress : Kernel
        Returns the new Cauchy stress (xx, yy, zz, xy, yz, xz) [Pa]; with ``state`` declared, returns
        ``(stress, s_1, s_2, ...)`` with the new state in the order of declaration. May ask for F, J, L (of this
        step), ``stress`` (of the last step), its state, ``dt`` and its parameters. F and L come as nine numbers,
        always as 3 x 3, whatever the dimension.
    wave_speed : Kernel
        Returns the fastest speed [m/s] of a small wave in the current state, an upper bound over all directions: it
        sets the time step. May ask for F, J, stress, state (all after the update).
    energy : Kernel, optional
        Stored energy per initial volume [J/m^3].
    dissipation : Kernel, optional
        Energy dissipated so far per initial volume [J/m^3], a function of state and parameters.
    diffusivity : Kernel, optional
        Kinematic viscosity [m^2/s] that limits an explicit time step, for viscous laws.
    yield_function : Kernel, optional
        Of stress and state [Pa]: negative inside the yield surface, zero on it; the conformance suite checks that it is never positive.
    bar_stress, bar_wave_speed, bar_energy, bar_dissipation : Kernel, optional
        The same under uniaxial stress (a slender bar in 1D, ``Grid(..., lateral="stress")``): F, L and stress keep
        their shapes, only the xx components count.
    finite_strain : bool
        False for a small-strain measure, which is not objective under large rotation.
    stretches : tuple of two float
        Smallest and largest principal stretch for which the law is meant. The conformance suite goes there, in all directions: stress,
        energies and wave speed must be finite, and the wave speed a bound.
    """

    kind: ClassVar[str] = "material"
    finite_strain: ClassVar[bool] = True
    stretches: ClassVar[tuple[float, float]] = (0.7, 1.4)
    stress: ClassVar[Kernel]
    wave_speed: ClassVar[Kernel]
    energy: ClassVar[Kernel | None] = None
    dissipation: ClassVar[Kernel | None] = None
    diffusivity: ClassVar[Kernel | None] = None
    yield_function: ClassVar[Kernel | None] = None
    bar_stress: ClassVar[Kernel | None] = None
    bar_wave_speed: ClassVar[Kernel | None] = None
    bar_energy: ClassVar[Kernel | None] = None
    bar_dissipation: ClassVar[Kernel | None] = None

    rho: float

    @classmethod
    def capabilities(cls) -> dict[str, object]:
        more: dict[str, object] = {
            "finite strain": cls.finite_strain,
            "energy": cls.energy is not None,
            "uniaxial stress": cls.bar_stress is not None,
        }
        more["stretches"] = list(cls.stretches)
        return super().capabilities() | more
