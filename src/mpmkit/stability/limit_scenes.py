"""Small scenes whose parameter is raised until they fail: bodies at many places between the nodes at once, stepped without guards."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np

from mpmkit.stability.case import Composition, simulation

if TYPE_CHECKING:
    from mpmkit._core.running.engine import Engine
    from mpmkit.simulation import Simulation

Array = Any
AMPLITUDE = 1e-3
"""Velocity of the smooth vibration [c]; particles move by a few thousandths of a cell."""
OFFSETS = (0.0, 0.005, 0.03, 0.1, 0.2, 0.3, 0.4, 0.47)
"""Shifts of a body against the grid [cells] at which no lattice of 1 to 4 particles per cell and direction has a particle on a node.

The small ones bring particles close to where the support of a smooth function ends, so that there are nodes of almost no mass. A particle
on a node changes its cell at the least motion; that is flight through cells and has its own limit.
"""
EVERY, FAR = 5, 3.0
"""Steps between two looks at the energy; how often the energy of the start it may become before a run ends."""
GAP = 5
"""Empty cells between two bodies: more than any shape function reaches."""
NOISE = 1e-3
"""Random part of the velocities, relative to the smooth one: energy of 1e-6, so that a mode that grows by 0.7 % per step shows within
1000 steps whichever it is."""


def material(dim: int) -> Any:
    """Hooke's law with c = rho = 1; small vibrations are all it is used for."""
    from mpmkit.materials import LinearElastic

    nu = 0.0 if dim == 1 else 0.3
    return LinearElastic(E=(1.0 + nu) * (1.0 - 2.0 * nu) / (1.0 - nu), nu=nu, rho=1.0)


@attrs.frozen
class Bodies:
    """Equal blocks of particles side by side along x.

    Attributes
    ----------
    x : float64[n, dim]
        Positions [cells].
    which : int[n]
        Number of the block.
    local : float64[n, dim]
        Positions in the block, relative to its edge, 0 to 1.
    per_cell : int
        Particles per cell and direction.
    length : float
        From the lower face of the domain to behind the last block [cells].
    """

    x: Array
    which: Array
    local: Array
    per_cell: int
    length: float


def blocks(dim: int, per_cell: int, cells: int, offsets: tuple[float, ...], *, room: float = 0.0, start: float = GAP) -> Bodies:
    """Blocks of `cells` in each direction, the k-th shifted by the k-th offset along x and by others along y and z."""
    ticks = (np.arange(cells * per_cell) + 0.5) / per_cell
    unit = np.stack(np.meshgrid(*[ticks] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
    placed, at = [], start
    for k in range(len(offsets)):
        shift = np.array([offsets[(k * (1 + 2 * a) + a) % len(offsets)] for a in range(dim)])
        placed.append(unit + shift + np.array([at] + [float(GAP)] * (dim - 1)))
        at += np.ceil(cells + 1) + GAP + room
    which = np.repeat(np.arange(len(offsets)), len(unit))
    return Bodies(np.concatenate(placed), which, np.tile(unit / cells, (len(offsets), 1)), per_cell, at)


@attrs.define
class Stepped:
    """A composed scene that can be put back to its start and stepped with any dt, with nobody watching over it."""

    sim: Simulation
    engine: Engine
    start: dict[str, Array]
    speed: float
    """c + |v| at the start, as the time step rule sees it."""

    @property
    def stress_first(self) -> bool:
        """Whether the forces of a step come from stresses of the same step (USF)."""
        verbs = self.engine.c.verbs
        return verbs.index("stress") < verbs.index("forces")

    @classmethod
    def of(cls, sim: Simulation) -> Stepped:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # what is doubtful is what is looked for
            engine = sim.compose().engine
        return cls(sim, engine, {name: array.copy() for name, array in engine.state().items()}, float(engine.outs[:, 0].max()))

    def rewind(self) -> None:
        """The state of the start."""
        self.engine.restore({name: array.copy() for name, array in self.start.items()}, 0.0, 0)
        self.engine.flags[:] = False

    def step(self, dt: float) -> bool:
        """One step; False if it has left particles that are inverted, outside, too wide, or not a number."""
        self.engine.step(dt)
        return not self.engine.flags.any() and bool(np.isfinite(self.engine.outs[:, 0]).all())

    def particles(self, *names: str) -> list[Array]:
        """Fields of all bodies, one after the other, each body's particles in the order they were given."""
        return [np.concatenate([store.get(name) for store in self.engine.stores]) for name in names]


@attrs.define
class Vibration:
    """Free elastic blocks with their lowest mode and noise, at rest or flying through the cells.

    Attributes
    ----------
    composition : Composition
        Components; contact plays no part.
    dim, per_cell : int
        Dimensions of the space; particles per cell and direction.
    flight : float
        Speed of flight [c].
    held : bool
        The first block begins at a wall that holds it.
    steps : int
        Length of a run.
    reach : float
        Largest Courant number that will be tried in flight, for the size of the domain.
    """

    composition: Composition
    dim: int
    per_cell: int
    flight: float = 0.0
    held: bool = False
    steps: int = 1000
    reach: float = 1.0
    scene: Stepped = attrs.field(init=False)
    bodies: Bodies = attrs.field(init=False)
    law: Any = attrs.field(init=False)

    @property
    def cells(self) -> int:
        """Edge of a block."""
        return {1: 8, 2: 5, 3: 3}[self.dim]

    def __attrs_post_init__(self) -> None:
        import mpmkit as mpm
        from mpmkit.boundaries import Wall

        self.law = material(self.dim)
        self.bodies = b = blocks(self.dim, self.per_cell, self.cells, OFFSETS, start=0.0 if self.held else GAP)
        way = np.array([1.0, 0.37, 0.23][: self.dim])
        way *= self.flight / np.linalg.norm(way)
        v = AMPLITUDE * np.cos(np.pi * b.local)
        v += NOISE * AMPLITUDE * np.random.default_rng(1).standard_normal(v.shape)
        for k in range(b.which[-1] + 1):
            v[b.which == k] -= v[b.which == k].mean(axis=0)
        travel = self.steps * self.reach * way / (1.0 + self.flight)
        upper = np.ceil(np.array([b.length] + [2.0 * GAP + self.cells + 1] * (self.dim - 1)) + travel)
        sim = simulation(self.composition, mpm.Grid((0.0,) * self.dim, tuple(map(float, upper)), 1.0))
        half = 0.5 / self.per_cell
        sim += mpm.Body.from_arrays(b.x, (2.0 * half) ** self.dim, self.law, v=v + way, name="blocks", size=(half,) * self.dim)
        sim += Wall("xmin", condition="no slip")
        self.scene = Stepped.of(sim)

    def created(self, courant: float) -> float:
        """Largest energy made in any block, relative to that of the start, without that of flight; inf if a run breaks off.

        Velocities and stresses of an explicit step are half a step apart, so that their plain energy swings with each vibration, the more
        the longer the step. What a leapfrog keeps exactly in small vibrations is m v . v' / 2 + W, with v and v' before and after a step
        and W at the stresses that made the difference. A run ends early once an energy is far above.
        """
        dt = courant / self.scene.speed
        late = self.scene.stress_first
        made = 0.0
        self.scene.rewind()
        start = None
        with np.errstate(all="ignore"):
            for n in range(self.steps):
                looked_at = n % EVERY == 0
                if looked_at:
                    before, stored = self.scene.particles("v")[0], self._stored()
                if not self.scene.step(dt):
                    return float("inf")
                if not looked_at:
                    continue
                energy = self._kinetic(before, self.scene.particles("v")[0]) + (self._stored() if late else stored)
                start = energy if start is None else start
                made = max(made, float((energy / start).max() - 1.0))
                if not (energy < FAR * start).all():
                    return float("inf")
        return made

    def _stored(self) -> Array:
        """Stored energy of each block."""
        F, m = self.scene.particles("F", "m")
        return np.bincount(self.bodies.which, self.law.energy(tuple(F.T), self.law.lam, self.law.mu) * m / self.law.rho)

    def _kinetic(self, v: Array, after: Array) -> Array:
        """Kinetic energy m v . v' / 2 of each block; of one that flies, in the frame that flies with it."""
        m, which = self.scene.particles("m")[0], self.bodies.which
        mass = np.bincount(which, m)
        total = np.bincount(which, m * (v * after).sum(axis=1))
        if not self.flight:
            return 0.5 * total
        flight = [np.bincount(which, m * v[:, a]) * np.bincount(which, m * after[:, a]) / mass for a in range(self.dim)]
        return 0.5 * (total - sum(flight))


def separation(composition: Composition, per_cell: int, top: float = 4.0, wrong: float = 0.5) -> float | None:
    """Stretch at which a bar comes apart that is drawn out by a uniform velocity gradient: a stress in its middle third is wrong by half.

    The bar of 60 cells flies apart at 9 c at its ends, so that sound from the ends does not come to the middle third before the stretch
    is 4, but runs ten cells: gaps between particles have time to show. None if it stays whole up to `top`.
    """
    import mpmkit as mpm
    from mpmkit.boundaries import Wall

    cells, time, law = 60, 10.0, material(1)
    b = blocks(1, per_cell, cells, (0.0, 0.1, 0.3, 0.47), room=cells * (top - 1.0) + 10.0, start=cells * top)
    v = (top - 1.0) / time * cells * (b.local - 0.5)
    sim = simulation(composition, mpm.Grid(0.0, float(b.length) + cells * top, 1.0))
    sim += mpm.Body.from_arrays(b.x, 1.0 / per_cell, law, v=v, name="bars", size=(0.5 / per_cell,))
    sim += Wall("xmin", condition="no slip")
    scene = Stepped.of(sim)
    dt, t = 0.2 / scene.speed, 0.0
    middle = np.abs(b.local[:, 0] - 0.5) < 1.0 / 6.0
    while t < time:
        whole, t = scene.step(dt), t + dt
        stretch = 1.0 + (top - 1.0) * t / time
        stress = scene.particles("stress")[0][middle, 0]
        if not whole or not (np.abs(stress - law.E * (stretch - 1.0)) < wrong * law.E * max(stretch - 1.0, 0.1)).all():
            return float(stretch)
    return None


def meeting(composition: Composition, stiffness: float, density: float) -> bool:
    """Whether a bar meets one that is stiffer or denser by these ratios: energy made below 5 %, never half a cell into each other.

    Two bars of 8 cells, 2.5 cells apart; the first flies at 0.1 of its speed of sound. The time is that until they meet and 4 transits of
    sound through the first.
    """
    import mpmkit as mpm
    from mpmkit._core.running.ledger import Ledger
    from mpmkit.materials import LinearElastic

    cells, per_cell, v = 8, 2, 0.1
    x = (np.arange(cells * per_cell) + 0.5) / per_cell
    sim = simulation(composition, mpm.Grid(0.0, 2.0 * cells + 20.0, 1.0))
    size = 0.5 / per_cell
    sim += mpm.Body.from_arrays(x + 6.3, 2.0 * size, LinearElastic(E=1.0, nu=0.0, rho=1.0), v=v, name="soft", size=(size,))
    other = LinearElastic(E=stiffness, nu=0.0, rho=density)
    sim += mpm.Body.from_arrays(x + 6.3 + cells + 2.5, 2.0 * size, other, name="hard", size=(size,))
    if composition.contact is not None:
        sim += composition.contact
    scene = Stepped.of(sim)
    ledger, engine = Ledger(scene.engine), scene.engine
    ledger.row(0.0)
    time, cfl = 2.5 / v + 4.0 * cells, 0.4
    every = max(1, int(time * scene.speed / cfl) // 200)
    while engine.t < time:
        dt = cfl / float(engine.outs[:, 0].max())
        if not scene.step(dt):
            return False
        if engine.step_number % every == 0:
            a, b = engine.stores
            ends = [(one.get("x")[:, 0], size * one.get("F")[:, 0]) for one in (a, b)]
            gap = (ends[1][0] - ends[1][1]).min() - (ends[0][0] + ends[0][1]).max()
            balance = ledger.row(dt)["balance"]
            if not (balance < 0.05 and gap > -0.5):
                return False
    return True
