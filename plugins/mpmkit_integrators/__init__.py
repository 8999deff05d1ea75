"""Integrators (the order of one step) and transfers (what a particle's velocity becomes)."""

import mpmkit as mpm
from mpmkit_integrators.apic import APIC
from mpmkit_integrators.flip import FLIP
from mpmkit_integrators.mls import MLS
from mpmkit_integrators.musl import MUSL
from mpmkit_integrators.pic import PIC
from mpmkit_integrators.tpic import TPIC
from mpmkit_integrators.usf import USF
from mpmkit_integrators.usl import USL
from mpmkit_integrators.xpic import XPIC


@mpm.hookimpl
def mpmkit_components():
    """Return the integrators and transfers of this plugin."""
    return [APIC, FLIP, MLS, MUSL, PIC, TPIC, USF, USL, XPIC]
