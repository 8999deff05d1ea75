"""What is composed: the components of a simulation, sorted into roles, and its bodies into groups of one law."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import attrs

from mpmkit._core.composing.jit import plain
from mpmkit._core.composing.layout import ParticleLayout
from mpmkit.fields import Field
from mpmkit.interfaces import BoundaryLayer, Component, ConstitutiveModel, ContactAlgorithm, Effect, Integrator, ShapeFunction
from mpmkit.interfaces.recipe import Recipe
from mpmkit.kernels import Kernel

if TYPE_CHECKING:
    from mpmkit.simulation import Simulation

LAW_HOOKS = ("stress", "wave_speed", "energy", "dissipation", "diffusivity")


@attrs.define(eq=False)
class Group:
    """Bodies that share kernels and layout, so that they share compiled loops; parameters may differ."""

    name: str
    material: ConstitutiveModel
    hooks: dict[str, Kernel]
    state: tuple[Field, ...]
    layout: ParticleLayout
    bodies: list[int] = attrs.field(factory=list)

    @property
    def keeps_stress(self) -> bool:
        """Whether the stress depends on more than the deformation and has to be kept; else it is computed where it is asked for."""
        law = self.hooks["stress"]
        given = {name for name in law.arguments if not isinstance(getattr(self.material, name, None), (bool, int, float, tuple))}
        return bool(self.state) or not given <= {"F", "J", "V", "V0", "m", "rho", "h", "dim"}


@attrs.define(eq=False)
class Composition:
    """Components of one simulation in the order the scheduler looks at them."""

    sim: Simulation
    shape: ShapeFunction | None
    integrator: Integrator | None
    transfer: Any
    discretization: Any
    effects: dict[str, Effect]
    layers: dict[str, BoundaryLayer]
    contact: ContactAlgorithm | None
    groups: list[Group]
    verbs: list[str]
    fraction: float = 0.0

    @property
    def grid(self) -> Any:
        return self.sim.grid

    @property
    def dim(self) -> int:
        return int(self.grid.dim)

    @property
    def stored_operator(self) -> bool:
        return self.discretization is not None and self.discretization.operator == "stored"

    @property
    def reference(self) -> bool:
        return self.discretization is not None and self.discretization.configuration == "reference"

    @property
    def keeps_size(self) -> bool:
        """Particles that stretch with F, and a recipe that changes F before the step's last use of the weights.

        A step must see one set of weights: were they formed anew with the changed F, the nodes that received a
        particle's mass would not be those that give it its velocity, and momentum would be lost.
        """
        stretched = self.shape is not None and self.shape.particle_size == "current" and {"strain", "advect"} <= set(self.verbs)
        return stretched and self.verbs.index("strain") < self.verbs.index("advect")

    @property
    def strains_first(self) -> bool:
        """Strains and stresses come before the momentum update (USF)."""
        return {"strain", "momentum"} <= set(self.verbs) and self.verbs.index("strain") < self.verbs.index("momentum")

    def remembers(self, layer: BoundaryLayer) -> bool:
        """The layer keeps, from step to step, which nodes it holds.

        Where strains come before the forces of the step are known, only the step before can tell whether a wall holds a node.
        Were it told by the velocity alone, a wall would let go as soon as the body turns back: its stress would push and not be
        relieved, and energy would be made in every bounce.
        """
        return layer.hold is not None and self.strains_first and not self.stored_operator

    @property
    def loaded(self) -> bool:
        """Some layer of particles carries loads."""
        return any(layer.load is not None for layer in self.layers.values())

    @property
    def softens(self) -> bool:
        """The affine matrix is formed with velocities limited at light nodes.

        There kinked shape functions have full slopes; and where the recipe limits what the strain sees, stress could not act against
        gradients that only the affine matrix has: energy would be made.
        """
        kinked_or_limited = self.shape is not None and (not self.shape.smooth or self.fraction > 0.0)
        return kinked_or_limited and self.transfer is not None and self.transfer.affine != "none"

    @property
    def limits_velocities(self) -> bool:
        """Velocities are reduced at nodes with little mass: by the recipe, or for the affine matrix with kinked shape functions."""
        return self.fraction > 0.0 or self.softens

    @property
    def merges(self) -> bool:
        """Momentum and forces go to the nodes as one sum, m v + dt f: nothing in the scene asks for the velocity before the update.

        FLIP, XPIC, contact, damping, friction and velocities limited at light nodes do. So does the work of accelerations
        that differ from place to place; that of a uniform one is the same, because internal forces add up to zero.
        """
        t = self.transfer
        if t is None or self.stored_operator or self.contact is not None or self.loaded or self.limits_velocities:
            return False
        if set(t.velocity.arguments) & {"dv_grid", "v_smooth"} or t.passes > 1 or getattr(self.integrator, "mass", "lumped") != "lumped":
            return False
        one_sum = t.affine == "none" or t.gradient == "moment"  # else a channel would have terms with slopes and with distances
        local = any(e.body_force is not None or _varies(e, self.dim) for e in self.effects.values())
        # radial internal forces of rings do not add up to zero
        local |= self.grid.space == "axisymmetric" and any(e.acceleration is not None for e in self.effects.values())
        rubs = any(layer.rub is not None for layer in self.layers.values())
        return one_sum and not local and not rubs and self.verbs[:3] == ["p2g", "forces", "momentum"]

    @property
    def first_loop_asks_dt(self) -> bool:
        """What particles give to the nodes at the start of a step depends on the step's length."""
        return self.merges or any(e.body_force is not None and "dt" in e.body_force.arguments for e in self.effects.values())

    def roles(self, material: ConstitutiveModel | None = None) -> dict[str, Component]:
        """Components by role; the generated names are made from the roles."""
        out: dict[str, Any] = {"material": material, "shape": self.shape, "transfer": self.transfer, "contact": self.contact}
        return {k: v for k, v in (out | self.effects | self.layers).items() if v is not None}

    def group_of(self, body: int) -> Group:
        return next(g for g in self.groups if body in g.bodies)


def _varies(effect: Effect, dim: int) -> bool:
    """Whether an acceleration depends on place or velocity."""
    if effect.acceleration is None:
        return False
    from mpmkit._core.composing.sweep import needs_of

    return bool(needs_of(effect, effect.acceleration, dim) & {"x", "v"})


def law(material: ConstitutiveModel, bar: bool) -> dict[str, Kernel]:
    """The kernels of a constitutive model, those for uniaxial stress if `bar`."""
    prefix = "bar_" if bar else ""
    found = {hook: getattr(material, prefix + hook, None) for hook in LAW_HOOKS}
    if bar:
        found["diffusivity"] = material.diffusivity
    return {hook: k for hook, k in found.items() if k is not None}


def collect(sim: Simulation) -> Composition:
    """Sort the components of `sim`; nothing is checked here (see `contract`)."""
    grid = sim.grid
    bar = grid.lateral == "stress"
    space = "bar" if bar else grid.space
    groups: dict[Any, Group] = {}
    for k, body in enumerate(sim.bodies):
        hooks = law(body.material, bar)
        key = (type(body.material), *(id(plain(h)) for h in hooks.values()))
        if key not in groups:
            name = type(body.material).__name__
            same = sum(g.name.split("_")[0] == name for g in groups.values())
            groups[key] = Group(
                name if not same else f"{name}_{same + 1}",
                body.material,
                hooks,
                tuple(body.material.state),
                ParticleLayout(space, grid.dim),
            )
        groups[key].bodies.append(k)
    recipe = Recipe()
    stepper = sim.discretization if sim.discretization is not None else sim.integrator
    stepper.step(recipe)
    return Composition(
        sim=sim,
        shape=sim.shape,
        integrator=sim.integrator,
        transfer=getattr(sim.integrator, "transfer", None),
        discretization=sim.discretization,
        effects=_named(sim.effects),
        layers=_named(sim.boundaries),
        contact=sim.contacts[0] if sim.contacts else None,
        groups=list(groups.values()),
        verbs=recipe.verbs,
        fraction=recipe.fraction,
    )


def _named(components: list[Any]) -> dict[str, Any]:
    """Components by unique names: Gravity, Wall, Wall_2 ..."""
    out: dict[str, Any] = {}
    for component in components:
        name = type(component).__name__
        n = sum(type(c) is type(component) for c in out.values())
        out[name if not n else f"{name}_{n + 1}"] = component
    return out
