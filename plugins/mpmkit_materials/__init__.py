"""Bundled constitutive models, one per file."""

import mpmkit as mpm
from mpmkit_materials.hypoelastic_jaumann import HypoelasticJaumann
from mpmkit_materials.linear_elastic import LinearElastic
from mpmkit_materials.neo_hookean import NeoHookean
from mpmkit_materials.newtonian_fluid import NewtonianFluid
from mpmkit_materials.von_mises import VonMises


@mpm.hookimpl
def mpmkit_components():
    """Constitutive models of this package."""
    return [LinearElastic, HypoelasticJaumann, NeoHookean, VonMises, NewtonianFluid]
