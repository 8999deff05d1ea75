"""The compositions that cases are run under: products of what is registered, and those that a plugin's components take part in."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import product
from typing import Any

import attrs

from mpmkit.errors import PluginError
from mpmkit.stability.case import Case, Composition, told

FIRST = {"shape": "QuadraticBSpline", "integrator": "MUSL", "transfer": "FLIP", "contact": "FrictionalContact"}
"""What the documentation recommends to begin with; the first of its axis."""
BESIDES = ("GIMP", "USF", "APIC")
"""In quick runs, one other choice on each axis."""
AXES = {"shape": "shapes", "integrator": "integrators", "transfer": "transfers", "contact": "contacts", "material": "materials"}


@attrs.frozen
class Axes:
    """The choices that compositions are made of; the first of each is the default."""

    shapes: tuple[Any, ...]
    integrators: tuple[Any, ...]
    transfers: tuple[Any, ...]
    contacts: tuple[Any, ...]
    precisions: tuple[str, ...] = ("float64", "float32")
    materials: tuple[Any, ...] = (None,)
    extras: tuple[tuple[Any, ...], ...] = ((),)

    def one(self, shape: Any = None, integrator: Any = None, transfer: Any = None, **more: Any) -> Composition:
        """The default composition with some choices replaced."""
        choices = {"contact": self.contacts[0], "precision": self.precisions[0], "material": self.materials[0], "extra": self.extras[0]}
        stepper = _with(integrator or self.integrators[0], transfer or self.transfers[0])
        return Composition(shape or self.shapes[0], stepper, **(choices | more))


def registered() -> Axes:
    """The axes of all that is registered, built from the examples of their parameters; bodies may also share one field."""
    return Axes(_all("shape"), _all("integrator"), _all("transfer"), (*_all("contact"), None))


def default() -> Composition:
    """The composition that the documentation recommends to begin with."""
    return registered().one()


def quick(axes: Axes | None = None) -> list[Composition]:
    """The default and one other choice on each axis."""
    a = axes or registered()
    out = [a.one()]
    for axis, argument in (("shapes", "shape"), ("integrators", "integrator"), ("transfers", "transfer")):
        choices = getattr(a, axis)[1:]
        other = next((c for c in choices if type(c).__name__ in BESIDES), choices[0] if choices else None)
        if other is not None:
            out.append(a.one(**{argument: other}))
    return unique(out)


def published(axes: Axes | None = None) -> list[Composition]:
    """Every shape function under every integrator; every transfer with every integrator; other precisions and contacts for the default.

    Further, where the axes are those of all that is registered, forms that are offered for study and known to be unstable.
    """
    a = axes or registered()
    out: list[Composition] = [a.one(None, integrator, transfer) for integrator in a.integrators for transfer in a.transfers]
    out += [a.one(precision=precision) for precision in a.precisions]
    out += [a.one(contact=contact) for contact in a.contacts]
    out += [a.one(shape, integrator) for shape in a.shapes for integrator in a.integrators]
    out += studied(a) if axes is None else []
    return unique(out)


def everything(axes: Axes | None = None) -> list[Composition]:
    """The full product, as far as its parts can be composed at all."""
    a = axes or registered()
    steppers = [_with(i, t) for i, t in product(a.integrators, a.transfers)]
    parts = product(a.precisions, a.contacts, a.shapes, steppers, a.materials, a.extras)
    return unique([Composition(s, i, c, p, m, e) for p, c, s, i, m, e in parts] + (studied(a) if axes is None else []))


def studied(a: Axes) -> list[Composition]:
    """Forms that the documentation warns of: they show what the suite can see."""
    from mpmkit import integrators, shapes

    return [a.one(shapes.Linear(), integrators.USL(limit=0.0)), a.one(None, integrators.MUSL(strain="first-order"))]


def of_plugin(name: str, *, every: bool = False, few: bool = False) -> list[Composition]:
    """Compositions in which each component of a plugin takes part, in the place of the axis it belongs to.

    Parameters
    ----------
    name : str
        Of a plugin, distribution or component, as for ``mpmkit check``.
    every, few : bool
        The full product, or as few as in a quick run.

    Raises
    ------
    PluginError
        If nothing has that name, the plugin cannot be loaded, or none of its components belongs to an axis.
    """
    base, out, left = registered(), [], []
    for component in components(name):
        if component.kind in AXES:
            axes = attrs.evolve(base, **{AXES[component.kind]: (component,)})
        elif component.kind in ("effect", "boundary"):
            axes = attrs.evolve(base, extras=((component,),))
        else:
            left.append(f"{type(component).__name__} ({component.kind})")
            continue
        out += (everything if every else quick if few else published)(axes)
    if not out:
        raise PluginError(
            f"the hard cases say nothing about {', '.join(left) or name}: they vary {', '.join((*AXES, 'effect', 'boundary'))}; "
            f"mpmkit check {name} runs the conformance checks"
        )
    return unique(out)


def components(name: str) -> list[Any]:
    """The components that a name means, built from the examples of their parameters."""
    from mpmkit.testing.suite import _find as find

    entries, broken = find(name)
    if broken:
        raise PluginError(
            f"the plugin {broken[0].plugin!r} ({broken[0].distribution} {broken[0].version}) cannot be loaded: {broken[0].reason}"
        ) from broken[0].error
    return [_example(entry.component) for entry in entries]


def unique(compositions: Iterable[Composition]) -> list[Composition]:
    """Each composition once, in the order of first appearance."""
    out: list[Composition] = []
    for one in compositions:
        if one not in out:
            out.append(one)
    return out


def applied(case: Case, composition: Composition) -> Composition | None:
    """The composition as the case sees it; None if the case says nothing about it.

    Bodies that never meet need no contact; a constitutive model under test takes part only where it can take the place of the case's own.
    """
    if composition.material is not None and not case.material:
        return None
    seen = composition if case.contact else attrs.evolve(composition, contact=None)
    return None if case.applies(seen) else seen


def heading(composition: Composition) -> tuple[str, str]:
    """Group (the shape function) and short label of a composition, as the table and the picture name it."""
    usual = registered()
    c = composition
    transfer = getattr(c.integrator, "transfer", None)
    parts = [told(c.integrator) + (f"/{told(transfer)}" if transfer is not None else "")]
    if c.contact is None:
        parts.append("one field")
    elif c.contact != usual.contacts[0]:
        parts.append(told(c.contact))
    parts += [told(one) for one in ((c.material,) if c.material is not None else ()) + c.extra]
    parts += [c.precision] if c.precision != usual.precisions[0] else []
    return told(c.shape), " · ".join(parts)


def _with(integrator: Any, transfer: Any) -> Any:
    """An integrator with another transfer, if it has one to choose."""
    return attrs.evolve(integrator, transfer=transfer) if "transfer" in attrs.fields_dict(type(integrator)) else integrator


def _all(kind: str) -> tuple[Any, ...]:
    """One component of each registered class of a kind, the recommended one first, the others by name."""
    from mpmkit._core.registry import registry

    names = sorted(registry().of(kind), key=lambda name: (name != FIRST[kind], name))
    return tuple(_example(registry().get(name, kind).component) for name in names)


def _example(cls: Any) -> Any:
    """A component from the examples of its required parameters."""
    from mpmkit.testing.calling import variants

    return next(iter(variants(cls)))[1]
