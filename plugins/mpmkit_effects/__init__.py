"""Effects: what a scene may call for beside bodies, contact and boundaries."""

import mpmkit as mpm
from mpmkit_effects.artificial_viscosity import ArtificialViscosity
from mpmkit_effects.body_force import BodyForce
from mpmkit_effects.damping import Damping
from mpmkit_effects.gravity import Gravity


@mpm.hookimpl
def mpmkit_components():
    """Return the effects of this plugin."""
    return [ArtificialViscosity, BodyForce, Damping, Gravity]
