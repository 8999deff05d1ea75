"""APIC with gradients by moving least squares."""

import mpmkit as mpm
from mpmkit_integrators.apic import APIC


@mpm.define
class MLS(APIC):
    """MLS-MPM: APIC whose forces and strains use the affine matrix in place of the slopes of the shape functions.

    The gradient of a linear fit to the nodal values, weighted by the shape functions, is sum_i u_i N_i (x_i - x_p) D^-1;
    of the velocities it is the matrix C that APIC carries anyway, so that one set of sums less is gathered and scattered.
    For quadratic B-splines it is a good approximation of the slopes; the order of convergence is theirs. Needs three
    nodes or more in each direction: with two, D vanishes where a particle lies on a node.
    """

    references = (
        "Hu, Fang, Ge, Qu, Zhu, Pradhana and Jiang (2018), A moving least squares material point method with displacement "
        "discontinuity and two-way rigid body coupling, doi:10.1145/3197517.3201293",
    )
    gradient = "moment"
