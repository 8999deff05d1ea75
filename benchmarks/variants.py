"""Compositions whose cost is measured: one component of the base replaced or added at a time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

DT = 1e-7
"""Time step [s]: so short that hundreds of steps change nothing that would change the work of a step."""


@dataclass(frozen=True)
class Variant:
    """One composition.

    Attributes
    ----------
    name, group : str
        What is different, and the heading it stands under.
    shape, integrator, material
        Components in place of the base's.
    parts : tuple
        Effects, layers and contact added.
    bodies : int
        1, or 2 halves of the block.
    gap : int
        Cells between the halves.
    base : str
        Name of the variant that it is compared with.
    compressing : bool
        The block is being compressed, so that yield and viscosity are at work in every particle.
    """

    name: str
    group: str
    shape: Any
    integrator: Any
    material: Any
    parts: tuple[Any, ...] = ()
    bodies: int = 1
    gap: int = 0
    base: str = "base"
    compressing: bool = True


def variants() -> list[Variant]:
    """The base first: quadratic B-splines, update stress last in its plain form, FLIP, neo-Hookean."""
    from mpmkit import contacts, effects, integrators, materials, shapes
    from mpmkit._core.registry import registry
    from mpmkit.parameters import example_arguments

    base_shape, elastic = shapes.QuadraticBSpline(), {"E": 1e6, "nu": 0.3, "rho": 1000.0}
    rubber = materials.NeoHookean(**elastic, form="log")

    def usl(transfer: Any) -> Any:
        return integrators.USL(transfer, limit=0.0, dt=DT)

    plain = usl(integrators.FLIP())

    def made(name: str, group: str, shape: Any = base_shape, integrator: Any = plain, material: Any = rubber, **more: Any) -> Variant:
        return Variant(name, group, shape, integrator, material, **more)

    out = [made("base", "base")]
    out += [made(name, "shape", cls()) for name, cls in _all(registry, "shape").items() if name != "QuadraticBSpline"]
    out += [
        made(name, "transfer", integrator=usl(cls())) for name, cls in _all(registry, "transfer").items() if name not in ("FLIP", "XPIC")
    ]
    out += [made(f"XPIC({m})", "transfer", integrator=usl(integrators.XPIC(m))) for m in (2, 3, 4, 5)]
    flip = integrators.FLIP()
    out += [made(name, "integrator", integrator=getattr(integrators, name)(flip, dt=DT)) for name in ("USF", "USL", "MUSL")]
    for name, cls in _all(registry, "material").items():
        if name != "NeoHookean":
            out.append(made(name, "material", material=cls(**(example_arguments(cls) | ({} if name == "NewtonianFluid" else elastic)))))
    halves = {"bodies": 2, "compressing": False}
    out += [made("two bodies", "contact", **halves), made("two bodies apart", "contact", gap=6, **halves)]
    touch, apart = {"base": "two bodies"}, {"base": "two bodies apart", "gap": 6}
    rough = (contacts.FrictionalContact(friction=0.3),)
    out += [
        made("contact, touching", "contact", parts=rough, **halves, **touch),
        made("contact, apart", "contact", parts=rough, **halves, **apart),
    ]
    down = (0.0, 0.0, -9.81)
    added = {"Gravity": effects.Gravity(down), "BodyForce": effects.BodyForce(down), "Damping": effects.Damping(rate=1.0)}
    out += [made(name, "effect", parts=(effect,)) for name, effect in added.items()]
    viscosity = (effects.ArtificialViscosity(),)
    out += [made("ArtificialViscosity, compressing", "effect", parts=viscosity)]
    out += [made("ArtificialViscosity, stretching", "effect", parts=viscosity, compressing=False)]
    return out


def _all(registry: Any, kind: str) -> dict[str, type]:
    """Our components of a kind by name."""
    return {name: e.component for name, e in sorted(registry().of(kind).items()) if e.distribution == "mpmkit"}


def compose(variant: Variant, side: int) -> Any:
    """The simulation of a variant: a cube of `side` cells in a box of twice its side."""
    import mpmkit as mpm

    h, lower = 1.0 / (2 * side), side // 2
    extent = 2 * side + variant.gap
    sim = mpm.Simulation(mpm.Grid((0.0, 0.0, 0.0), (extent * h, 1.0, 1.0), h), shape=variant.shape, integrator=variant.integrator)
    rate = -1.0 if variant.compressing else 1.0
    v = tuple(f"{rate} * ({a} - 0.5)" for a in "xyz")
    cut, end = lower + side // 2, lower + side
    spans = [(lower, end)] if variant.bodies == 1 else [(lower, cut), (cut + variant.gap, end + variant.gap)]
    for number, (low, high) in enumerate(spans):
        box = mpm.Box((low * h, lower * h, lower * h), (high * h, end * h, end * h))
        sim += mpm.Body(box, variant.material, v=v, name=f"part{number}")
    sim += variant.parts
    return sim
