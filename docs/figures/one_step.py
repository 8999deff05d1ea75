"""Draws docs/images/one-step.svg: how data flows from the scene through one step of MUSL to the results.

Run it with ``python docs/figures/one_step.py``.
"""

from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

INK, SOFT, LINE = "#22262b", "#6b7280", "#9aa1a9"
ONCE, PARTICLES, NODES, RESULTS = "#e8eef7", "#fdebdd", "#e3f1ea", "#efe9f6"


def box(axis, x, y, width, height, title, text="", colour="white"):
    """A rounded box with its lower left corner at (x, y)."""
    style = "round,pad=0,rounding_size=0.09"
    axis.add_patch(FancyBboxPatch((x, y), width, height, boxstyle=style, facecolor=colour, edgecolor=LINE, linewidth=0.9))
    if not text:
        axis.text(x + width / 2, y + height / 2, title, ha="center", va="center", fontsize=8.6, weight="bold", color=INK)
        return
    axis.text(x + width / 2, y + height - 0.13, title, ha="center", va="top", fontsize=8.6, weight="bold", color=INK)
    axis.text(x + width / 2, y + height - 0.38, text, ha="center", va="top", fontsize=7.1, color=INK, linespacing=1.35)


def arrow(axis, start, end, text="", colour=INK, shift=(0.0, 0.0)):
    """An arrow with an optional label at its middle."""
    axis.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=9, linewidth=1.0, color=colour))
    if text:
        middle = ((start[0] + end[0]) / 2 + shift[0], (start[1] + end[1]) / 2 + shift[1])
        plain = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
        axis.text(*middle, text, ha="center", va="center", fontsize=7, color=colour, bbox=plain)


def before(axis):
    """The upper row: what happens once, before the first step."""
    row = [
        ("scene", "script or TOML:\ngrid, bodies, materials,\nlayers, effects, integrator"),
        ("composition", "components by role,\nbodies in groups of one law;\ncontract: refuse what\ncannot work, and say why"),
        ("plan", "recipe → phases, fields\nwith their reasons,\nlayout of particles\nand nodes"),
        ("generated module", "step.py in the cache folder,\nnamed by the digest of all\nsources and versions;\ncompiled by numba"),
    ]
    for k, (title, text) in enumerate(row):
        box(axis, 0.15 + 2.98 * k, 5.62, 2.3, 1.12, title, text, ONCE)
        if k:
            arrow(axis, (0.15 + 2.98 * k - 0.66, 6.18), (0.15 + 2.98 * k - 0.02, 6.18))
    axis.text(0.15, 6.86, "once, before the first step", fontsize=8, color=SOFT, style="italic")


def step(axis):
    """The middle: phases of one MUSL step, particles above and nodes below."""
    style = "round,pad=0,rounding_size=0.12"
    axis.add_patch(FancyBboxPatch((0.05, 1.62), 11.42, 3.52, boxstyle=style, facecolor="none", edgecolor=LINE, linestyle=(0, (4, 3))))
    title = "one step of MUSL: each box is made of loops of the generated module; what no component contributes to is not there"
    axis.text(0.15, 5.22, title, fontsize=8, color=SOFT, style="italic")
    axis.text(0.3, 4.87, "particles", fontsize=8.2, color="#b4622a", weight="bold")
    axis.text(0.3, 2.5, "nodes", fontsize=8.2, color="#2d7a55", weight="bold")
    up, low, height = 3.72, 2.06, 0.98
    to_nodes = "shape function: $N_{ip}$, $G_{ip}$\nstress, body forces,\nloads of particle layers"
    back = "transfer: $v_p$ (and $C_p$);\nupdated momenta\nback to the nodes"
    law = "$x_p$, $L_p$, $F_p$; constitutive model:\nstress, state, wave speed;\nartificial viscosity"
    motion = "$v_i = (mv)_i / m_i$,  $v_i$ += $\\Delta t\\, f_i / m_i$\nnodal accelerations; impulses;\nwalls, symmetry, given velocities"
    again = "on the velocities of the\nsecond mapping, which only\nthe strain sees"
    box(axis, 0.25, up, 2.2, height, "p2g, forces", to_nodes, PARTICLES)
    box(axis, 4.5, up, 2.3, height, "g2p, remap", back, PARTICLES)
    box(axis, 8.75, up, 2.55, height, "advect, strain, stress", law, PARTICLES)
    box(axis, 2.0, low, 2.9, height, "momentum · contact · boundary", motion, NODES)
    box(axis, 6.35, low, 2.8, height, "contact · boundary", again, NODES)
    arrow(axis, (1.6, up), (2.55, low + height), "$m_i$, $(mv)_i$, $f_i$")
    arrow(axis, (4.2, low + height), (5.0, up), "$v_i$")
    arrow(axis, (6.1, up), (6.95, low + height), "$(mv)_i$")
    arrow(axis, (8.6, low + height), (9.4, up), "$v_i$")
    axis.plot([11.3, 11.38, 11.38, 0.13, 0.13], [4.2, 4.2, 1.7, 1.7, 4.2], color=SOFT, linewidth=1.0)
    arrow(axis, (0.13, 4.2), (0.25, 4.2), colour=SOFT)
    axis.text(10.35, 1.83, "next step: new $\\Delta t$, nodes cleared", ha="center", va="bottom", fontsize=7, color=SOFT)


def after(axis):
    """The lower row: what comes up from the state."""
    row = [
        ("store", "particles of each body,\nonly the fields of the plan"),
        ("guards, ledger", "NaN, J ≤ 0, outside, energy;\nmass, momentum, works, balance"),
        ("records", "VTKHDF, history, checkpoint:\nwhole after every frame"),
        ("Results", "frames, history, pictures;\npandas, xarray, pyvista"),
    ]
    for k, (title, text) in enumerate(row):
        box(axis, 0.15 + 2.98 * k, 0.1, 2.3, 0.82, title, text, RESULTS)
        if k:
            arrow(axis, (0.15 + 2.98 * k - 0.66, 0.51), (0.15 + 2.98 * k - 0.02, 0.51))


def main(path):
    """Draw the picture to `path`."""
    plt.rcParams.update({"svg.hashsalt": "mpmkit", "svg.fonttype": "path", "mathtext.fontset": "dejavusans"})
    figure, axis = plt.subplots(figsize=(11.6, 7.1))
    before(axis)
    step(axis)
    after(axis)
    arrow(axis, (10.24, 5.62), (10.24, 5.16), "phases, layout", colour=SOFT, shift=(0.62, 0.0))
    arrow(axis, (1.3, 1.6), (1.3, 0.95), "data come up once", colour=SOFT, shift=(0.72, 0.0))
    axis.set(xlim=(-0.02, 11.54), ylim=(0.0, 7.06), aspect="equal")
    axis.axis("off")
    figure.subplots_adjust(0, 0, 1, 1)
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


if __name__ == "__main__":
    main(Path(__file__).parents[1] / "images" / "one-step.svg")
