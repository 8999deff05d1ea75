"""Exact solutions: closed forms to compare simulations with. Nothing here uses the simulation code.

Positions are reference positions, stresses are positive in tension, all units are SI or any consistent set.
"""

from mpmkit.exact.bars import BarImpact, ForcedBar
from mpmkit.exact.cellcross import SHAPES, Shape1D, cell_crossing_force, gimp, nodal_force
from mpmkit.exact.column import Column, SuddenColumn
from mpmkit.exact.cylinder import PlasticCylinder, ThickCylinder
from mpmkit.exact.hyperelastic import lame
from mpmkit.exact.incline import BlockOnIncline, DiskOnIncline
from mpmkit.exact.manufactured import AxisAligned, Vortex
from mpmkit.exact.plastic_bar import PlasticBarImpact
from mpmkit.exact.spinning_disk import SpinningDisk
from mpmkit.exact.tractions import Pulse, SmoothPulse, Step, Traction
from mpmkit.exact.vibrating_bar import VibratingBar
from mpmkit.exact.waves import Interface, impedance

__all__ = [
    "SHAPES",
    "AxisAligned",
    "BarImpact",
    "BlockOnIncline",
    "Column",
    "DiskOnIncline",
    "ForcedBar",
    "Interface",
    "PlasticBarImpact",
    "PlasticCylinder",
    "Pulse",
    "Shape1D",
    "SmoothPulse",
    "SpinningDisk",
    "Step",
    "SuddenColumn",
    "ThickCylinder",
    "Traction",
    "VibratingBar",
    "Vortex",
    "cell_crossing_force",
    "gimp",
    "impedance",
    "lame",
    "nodal_force",
]
