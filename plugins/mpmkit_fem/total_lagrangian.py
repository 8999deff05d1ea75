"""Total-Lagrangian finite elements with one integration point."""

import attrs

import mpmkit as mpm
from mpmkit.interfaces.discretization import StoredPoints


@mpm.define
class FEM(mpm.Discretization):
    """Two-node bars in 1D, four-node quadrilaterals in plane strain; one Gauss point, lumped mass, central differences.

    The elements are the cells of the grid whose centre lies in the body, so the grid only says how fine the mesh is.
    f_i = -sum_p V0_p P_p grad_X N_i with the first Piola-Kirchhoff stress P; nodes keep their velocities, and
    gradients with respect to X are formed once, so nothing is remapped and no cell is crossed. Bodies do not see each
    other (no contact), and quadrilaterals have no hourglass control: keep to motions that do not excite it.
    """

    references = (
        "Belytschko, Liu, Moran and Elkhodary (2014), Nonlinear finite elements for continua and structures, 2nd ed., "
        "box 4.5 and section 6.2",
        "Chen and Brannon (2002), SAND2002-0482, section 4 (comparison with single-point finite elements)",
    )
    spaces = ("1D", "plane strain")
    operator = "stored"
    configuration = "reference"
    time_order = 1
    cfl: float = mpm.parameter("time step as a fraction of h / (|v| + c)", gt=0.0, le=1.0, default=0.5, kw_only=True)
    dt: float | None = mpm.parameter("fixed time step; automatic if not given", unit="s", gt=0.0, default=None, kw_only=True)

    def step(self, s):
        s.carry()  # v_i^(n-1/2), f_i = 0
        s.forces()  # f_i = -sum_p V0 P grad_X N_i
        s.momentum()  # v_i^(n+1/2) = v_i^(n-1/2) + dt f_i / m_i
        s.contact()  # bodies share no nodes: refused when a scene asks for it
        s.boundary()
        s.g2p()  # velocity of the element's centre, for output
        s.advect()
        s.strain()  # F += dt grad_X v
        s.stress()

    def nodes_per_point(self, dim):
        return 2**dim

    def mesh(self, grid, body):
        import numpy as np

        points = attrs.evolve(body, particles_per_cell=1, lattice="grid").sample(grid)
        dim, h = grid.dim, np.asarray(grid.spacing)
        corners = np.stack(np.meshgrid(*[(-1, 1)] * dim, indexing="ij"), axis=-1).reshape(-1, dim)
        lattice = np.rint((points.x[:, None, :] + 0.5 * corners * h - grid.lower) / h).astype(np.int64)
        unique, connectivity = np.unique(lattice.reshape(-1, dim), axis=0, return_inverse=True)
        n, m = len(points.x), len(corners)
        return StoredPoints(
            x=points.x,
            V0=points.V0,
            size=points.size,
            v=points.v,
            nodes=np.asarray(grid.lower) + unique * h,
            connectivity=connectivity.reshape(n, m).astype(np.int64),
            N=np.full((n, m), 0.5**dim),
            dN=np.broadcast_to(corners / h * 0.5 ** (dim - 1), (n, m, dim)).copy(),
            F=points.F,
            stress=points.stress,
        )
