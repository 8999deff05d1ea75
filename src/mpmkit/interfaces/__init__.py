"""The interfaces: one file per kind of component, the class docstring is the contract."""

from mpmkit.interfaces.boundary import BoundaryLayer
from mpmkit.interfaces.component import SPACES, Component
from mpmkit.interfaces.contact import ContactAlgorithm
from mpmkit.interfaces.discretization import Discretization
from mpmkit.interfaces.effect import Effect
from mpmkit.interfaces.integrator import ExplicitIntegrator, Integrator, Transfer
from mpmkit.interfaces.material import ConstitutiveModel
from mpmkit.interfaces.shape import ShapeFunction

KINDS: dict[str, type[Component]] = {
    c.kind: c for c in (ShapeFunction, ConstitutiveModel, ContactAlgorithm, BoundaryLayer, Integrator, Transfer, Effect, Discretization)
}
"""Kinds of component by name."""

__all__ = [
    "KINDS",
    "SPACES",
    "BoundaryLayer",
    "Component",
    "ConstitutiveModel",
    "ContactAlgorithm",
    "Discretization",
    "Effect",
    "ExplicitIntegrator",
    "Integrator",
    "ShapeFunction",
    "Transfer",
]
