"""Text of one loop: local names for fields and parameters, calls of kernels with their arguments resolved by name."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import attrs

from mpmkit._core.composing.composition import Composition, Group
from mpmkit._core.composing.layout import LANES, NodeLayout, Slots, lane
from mpmkit.errors import FieldContractError, ParameterError, did_you_mean
from mpmkit.fields import KERNEL_ARGUMENTS, PARTICLE_FIELDS
from mpmkit.kernels import Kernel

AXES = range(3)


@attrs.define(eq=False)
class Parameters:
    """Run-time parameters of one kind of loop: slot number -> how to get the number from the components by role."""

    slots: dict[str, int] = attrs.field(factory=dict)
    getters: list[Callable[[dict[str, Any]], float]] = attrs.field(factory=list)

    def slot(self, name: str, getter: Callable[[dict[str, Any]], float]) -> int:
        if name not in self.slots:
            self.slots[name] = len(self.getters)
            self.getters.append(getter)
        return self.slots[name]

    def values(self, roles: dict[str, Any], dtype: type) -> Any:
        """The numbers, in their slots.

        Raises
        ------
        ParameterError
            If the precision in use cannot hold one.
        """
        import numpy as np

        exact = np.array([getter(roles) for getter in self.getters] or [0.0], dtype=float)
        with np.errstate(over="ignore"):
            out: Any = exact.astype(dtype)
        lost = np.flatnonzero(np.isfinite(exact) & ~np.isfinite(out))
        if lost.size:
            role, _, name = next(name for name, slot in self.slots.items() if slot == lost[0]).rpartition("_")
            whose = type(roles[role]).__name__ if role in roles else role or "the grid"
            raise ParameterError(
                f"{name} of {whose} is {exact[lost[0]]:g}, {np.dtype(dtype).name} holds up to {float(np.finfo(dtype).max):.2g}. "
                'To fix: a smaller number, other units, or precision="float64"'
            )
        return out


@attrs.define(eq=False)
class Names:
    """All global names of the generated module: component functions by the name they have in its text."""

    functions: dict[str, Any] = attrs.field(factory=dict)

    def of(self, name: str, function: Any) -> str:
        """Register a component function under `name` (made unique), return the name."""
        for known, f in self.functions.items():
            if f is function:
                return known
        unique, n = name, 2
        while unique in self.functions:
            unique, n = f"{name}_{n}", n + 1
        self.functions[unique] = function
        return unique


def _of_grid(quantity: str, axis: int, roles: dict[str, Any]) -> float:
    grid = roles["grid"]
    if quantity in ("h", "inv_h"):
        return float(grid.spacing[axis] if quantity == "h" else 1.0 / grid.spacing[axis])
    if quantity == "last":
        return float(grid.cells[axis] - 1)
    return float(getattr(grid, quantity)[axis])


def _slack(axis: int, precision: str, roles: dict[str, Any]) -> float:
    """How far outside the domain [m] a particle may have got by rounding.

    As near to a face as the square root of the last digit, in cells, a particle has the weights at that distance (`face`), with which it
    may pass the face. Zero at an axis of revolution, on which no particle can lie.
    """
    import numpy as np

    grid = roles["grid"]
    if axis == 0 and grid.space == "axisymmetric" and grid.lower[0] == 0.0:
        return 0.0
    farthest = max(abs(grid.lower[axis]), abs(grid.upper[axis]))
    eps = float(np.finfo(precision).eps)
    return float(max(eps**0.5 * grid.spacing[axis], 4.0 * eps * farthest))


def _component_of(role: str, name: str, k: int, roles: dict[str, Any]) -> float:
    return float(getattr(roles[role], name)[k])


def _constant_of(role: str, name: str, dim: int, k: int, roles: dict[str, Any]) -> float:
    from mpmkit.expression import as_function

    constant: Any = as_function(getattr(roles[role], name), dim)
    return float(constant[k])


class Text:
    """Lines of a function under construction, in sections, and the names it has used."""

    def __init__(self, composition: Composition, parameters: Parameters, names: Names) -> None:
        self.composition = composition
        self.parameters = parameters
        self.names = names
        self.used: dict[str, int] = {}  # local name of a parameter -> slot

    # --- parameters ---------------------------------------------------------------------------------------------
    def parameter(self, name: str, getter: Callable[[dict[str, Any]], float]) -> str:
        self.used[name] = self.parameters.slot(name, getter)
        return name

    def along(self, quantity: str, axis: int) -> str:
        """A number of the grid along one axis: "lower", "upper", "h", "inv_h", "last" (cell) or "slack" (for rounding)."""
        if quantity == "slack":
            return self.parameter(f"slack{axis}", partial(_slack, axis, self.composition.sim.precision))
        return self.parameter(f"{quantity}{axis}", partial(_of_grid, quantity, axis))

    def parameter_lines(self) -> list[str]:
        return [f"    {name} = par[{slot}]" for name, slot in self.used.items()]

    # --- calls --------------------------------------------------------------------------------------------------
    def call(self, hook: str, kernel: Kernel, role: str, group: Group | None, special: dict[str, str]) -> str:
        """Text that calls a component's kernel, its arguments resolved by name."""
        component = group.material if role == "material" and group is not None else self.composition.roles()[role]
        name = self.names.of(f"{group.name}_{hook}" if role == "material" and group is not None else f"{role}_{hook}", kernel.function)
        arguments = [self.argument(a, component, role, hook, special) for a in kernel.arguments]
        return f"{name}({', '.join(arguments)})"

    def argument(self, name: str, component: Any, role: str, hook: str, special: dict[str, str]) -> str:
        if name in special:
            return special[name]
        if name in ("t", "dt"):
            return name
        if name == "h":
            return self.parameter("h_min", lambda roles: roles["grid"].h)
        if name == "dim":
            return str(self.composition.dim)
        value = getattr(component, name, None)
        if name in getattr(component, "values", ()):  # first: a vector of one component may be given as a number
            return self.value(name, component, role, special)
        if isinstance(value, (bool, int, float)):
            return self.parameter(f"{role}_{name}", lambda roles: float(getattr(roles[role], name)))
        if isinstance(value, tuple) and all(isinstance(v, (int, float)) for v in value):
            parts = [self.parameter(f"{role}_{name}_{k}", partial(_component_of, role, name, k)) for k in range(len(value))]
            return f"({', '.join(parts + ['zero'] * (3 - len(parts)))})"
        found = self.field(name)
        if found is None:
            known = [*special, *PARTICLE_FIELDS, *KERNEL_ARGUMENTS, *vars(component)]
            raise FieldContractError(
                f"{type(component).__name__}: its kernel {hook!r} asks for {name!r}, which is no parameter, no state and no field "
                f"of this composition{did_you_mean(name, known)}"
            )
        return found

    def value(self, name: str, component: Any, role: str, special: dict[str, str]) -> str:
        """A `Value` parameter: a constant vector, or a call of the user's function."""
        from mpmkit.expression import as_function

        made = as_function(getattr(component, name), self.composition.dim)
        if callable(made):
            function = self.names.of(f"{role}_{name}", made)
            arguments = [self.argument(a, component, role, name, special) for a in made.__code__.co_varnames[: made.__code__.co_argcount]]
            return f"{function}({', '.join(arguments)})"

        parts = [self.parameter(f"{role}_{name}_{k}", partial(_constant_of, role, name, self.composition.dim, k)) for k in AXES]
        return f"({', '.join(parts)})"

    def field(self, name: str) -> str | None:
        """Local name of a field, made available; None if this loop knows no such field."""
        return None


class ParticleLoop(Text):
    """One loop over the particles of a body: what it sums over the nodes, computes, adds to the nodes, and stores.

    Verbs only state sums and terms; how nodes are visited is the operator's business.
    """

    def __init__(self, composition: Composition, parameters: Parameters, names: Names, group: Group, nodes: NodeLayout) -> None:
        super().__init__(composition, parameters, names)
        self.group, self.nodes = group, nodes
        self.dim = composition.dim
        self.have: set[str] = set()
        self.lines: list[str] = []
        self.sums: dict[tuple[str, str], None] = {}  # (channel, factor): sum_i channel_i factor_i, in the order asked for
        self.terms: dict[str, dict[tuple[str, int], list[str]]] = {}  # channel -> (factor, a) -> coefficients to be added
        self.accounts: dict[str, str] = {}  # name -> kind of reduction over the particles: "max", "sum" or "watch"
        self.store_lines: list[str] = []
        self.first = False  # of the step: particles have the sizes that all its loops will use
        self.asks_weights = False  # the computation itself reads weights
        self.asks_slopes = False
        self.most_slots = 0  # rows of lanes that the loop takes in the scratch array
        self.verbs: tuple[str, ...] = ()
        self.titles: list[str] = []

    # --- sums over nodes and terms for nodes --------------------------------------------------------------------
    def summed(self, channel: str, factor: str) -> list[str]:
        """Names of sum_i u_i N_i ("w": one for each component a), sum_i u_i dN_i/dx_b ("g") or sum_i u_i N_i k_b ("k"), at [dim a + b].

        k_b is the number of node i along axis b, counted from the particle's first node: with f_b, the particle's own
        place in that count, sum_i u_i N_i (x_i - x_p)_b = h_b (sum_k - f_b sum_w).
        """
        self.sums[channel, factor] = None
        if factor == "w":
            return [f"{channel}_w{a}" for a in range(self.dim)]
        return [f"{channel}_{factor}{a}{b}" for a in range(self.dim) for b in range(self.dim)]

    def add(self, channel: str, a: int, factor: str, *coefficients: str) -> None:
        """Add to component `a` of a channel, at every node: c N_i ("w"), c_b dN_i/dx_b ("g") or c_b N_i (x_i - x_p)_b ("r")."""
        rows = self.terms.setdefault(channel, {})
        if factor == "w":
            rows.setdefault(("w", a), []).append(coefficients[0])
        else:
            for b, text in enumerate(coefficients):
                rows.setdefault((f"{factor}{b}", a), []).append(text)

    def place(self, b: int) -> str:
        """f_b, the particle's own place along axis b, counted in cells from its first node."""
        self.asks_weights = True
        return lane(self._slots.f(b))

    def second_moment(self, b: int) -> str:
        """sum_i N_i (x_i - x_p)_b^2 / h_b^2."""
        f = self.place(b)
        nodes = range(self._slots.nodes)
        return "(" + " + ".join(f"{lane(self._slots.w(b, k))} * (T({k}) - {f}) * (T({k}) - {f})" for k in nodes) + ")"

    @property
    def _slots(self) -> Slots:
        shape = self.composition.shape
        assert shape is not None
        return Slots(self.dim, shape.nodes)

    # --- accounts -----------------------------------------------------------------------------------------------
    def maximum(self, account: str, value: str) -> None:
        """Keep the largest value over the particles."""
        self.accounts[account] = "max"
        self.line(f"${account} = {value} if not ({value} <= ${account}) else ${account}")

    def total(self, account: str, value: str) -> None:
        """Sum over the particles."""
        self.accounts[account] = "sum"
        self.line(f"${account} += {value}")

    def watch(self, account: str, value: str, sign: str = ">") -> None:
        """Remember for good if `value` is not greater than zero (or not a number); the test that ends a run."""
        self.accounts[account] = f"watch {sign}"
        self.line(f"${account} = {value} if ${account} {sign} zero else ${account}")

    # --- emitting -----------------------------------------------------------------------------------------------
    def line(self, text: str) -> None:
        self.lines.append(text)

    def at(self, name: str, component: int = 0) -> str:
        return f"P[U(b + {(self.group.layout.start[name] + component) * LANES} + l)]"

    def field(self, name: str) -> str | None:
        layout = self.group.layout
        if name not in PARTICLE_FIELDS and name not in layout.fields:
            return None
        if name not in self.have:
            if name in layout.fields:
                self._load(name)
            elif name == "J" and "F" in layout.fields:
                self.line(f"J = det({self.field('F')})")
            elif name == "V":
                self.line(f"V = {self.field('J')} * {self.field('V0')}")
            elif name == "rho":
                self.line(f"rho = {self.field('m')} / {self.field('V')}")
            elif name in layout.derived:
                call = self.material(name)
                self.line(f"{name} = {call}")
            else:
                return None
            self.have.add(name)
        return self.local(name)

    @staticmethod
    def local(name: str) -> str:
        """The variable that holds a field: its letter, or for a law's own state a name that no other variable has."""
        return name if name in PARTICLE_FIELDS else f"state_{name}"

    def _load(self, name: str) -> None:
        layout = self.group.layout
        field, stored, local = layout.fields[name], layout.stored(name), self.local(name)
        if field.shape == "scalar":
            self.line(f"{local} = {self.at(name)}")
            return
        full = {"vector": 3, "symmetric": 6, "tensor": 9}[field.shape]
        parts = []
        for k in range(full):
            if k in stored:
                self.line(f"{local}{k} = {self.at(name, stored.index(k))}")
                parts.append(f"{local}{k}")
            else:
                diagonal = (field.shape == "tensor" and k in (0, 4, 8)) or (field.shape == "symmetric" and k < 3)
                parts.append("one" if diagonal and field.initial == 1.0 else "zero")
        self.line(f"{local} = ({', '.join(parts)})")

    def store(self, name: str) -> None:
        """Store the local of a field (a scalar, or a tuple in full form) at the end of the loop."""
        layout, local = self.group.layout, self.local(name)
        if layout.fields[name].shape == "scalar":
            self.store_lines.append(f"{self.at(name)} = {local}")
        else:
            for k, full in enumerate(layout.stored(name)):
                self.store_lines.append(f"{self.at(name, k)} = {local}[{full}]")
        self.have.add(name)

    def forget(self, *names: str) -> None:
        """Derived values that must be computed anew after F or J changed."""
        self.have -= set(names)

    def material(self, hook: str, special: dict[str, str] | None = None) -> str:
        return self.call(hook, self.group.hooks[hook], "material", self.group, special or {})
