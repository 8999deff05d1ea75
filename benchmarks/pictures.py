"""Pictures of the results: speeds by program and case, cost of components, scaling."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

LOOK = Path(__file__).parents[1] / "examples/look.mplstyle"


def main(results: dict[str, Any], folder: Path) -> list[Path]:
    """Draw what is there; returns the files."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    drawers = {"compare": _speeds, "components": _costs, "scaling": _scaling}
    with plt.style.context(LOOK):
        return [_save(drawers[name](results[name]), folder / f"performance_{name}.png") for name in drawers if name in results]


def _save(figure: Any, path: Path) -> Path:
    """A palette PNG, as the examples write theirs."""
    import matplotlib.pyplot as plt
    from PIL import Image

    buffer = io.BytesIO()
    figure.savefig(buffer)
    plt.close(figure)
    Image.open(buffer).convert("RGB").quantize(128).save(path, optimize=True)
    return path


def _speeds(result: dict[str, Any]) -> Any:
    """Bars of the speeds, one group for each setting."""
    import matplotlib.pyplot as plt

    rows = [row for row in result["settings"] if row["programs"]]
    names = list(dict.fromkeys(name for row in rows for name in row["programs"]))
    figure, axis = plt.subplots(figsize=(9.2, 0.9 + 0.13 * len(rows) * (len(names) + 1)))
    thick = 1.0 / (len(names) + 1)
    for k, name in enumerate(names):
        have = [(i, row["programs"][name]["mps"]) for i, row in enumerate(rows) if name in row["programs"]]
        places, middle = [i + (k + 0.5) * thick for i, _ in have], [mps[0] for _, mps in have]
        around = [[mps[0] - mps[1] for _, mps in have], [mps[2] - mps[0] for _, mps in have]]
        axis.barh(places, middle, height=0.9 * thick, xerr=around, error_kw={"lw": 0.7, "ecolor": "#22262b"}, label=name)
    labels = [f"{r['case']} {r['size']} {r['prec']}, {r['threads']} thread{'s' if r['threads'] > 1 else ''}" for r in rows]
    axis.set_yticks([i + 0.5 * (1.0 - thick) for i in range(len(rows))], labels)
    axis.set(xscale="log", xlabel="million particle-steps per second")
    axis.invert_yaxis()
    axis.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=len(names))
    return figure


def _costs(result: dict[str, Any]) -> Any:
    """Bars of the measured ratios, marks for the expected ones."""
    import matplotlib.pyplot as plt

    rows = result["rows"]
    groups = list(dict.fromkeys(row["group"] for row in rows))
    figure, axis = plt.subplots(figsize=(9.2, 0.8 + 0.2 * len(rows)))
    colours = plt.rcParams["axes.prop_cycle"].by_key()["color"]
    axis.barh(
        range(len(rows)), [r["ratio"] for r in rows], height=0.7, color=[colours[groups.index(r["group"]) % len(colours)] for r in rows]
    )
    axis.plot([r["expected"] for r in rows], range(len(rows)), "|", color="#22262b", ms=9, mew=1.6, label="expected by arithmetic")
    axis.axvline(1.0, color="#9aa1a9", lw=0.8)
    axis.set_yticks(range(len(rows)), [f"{r['name']}" + (f" (beside {r['base']})" if r["base"] != "base" else "") for r in rows])
    axis.set(xlabel="time of a step beside the base step", ylim=(len(rows) - 0.4, -0.6))
    axis.legend(loc="lower right")
    return figure


def _scaling(result: dict[str, Any]) -> Any:
    """Time per particle-step over the number of particles; speed over the number of threads."""
    import matplotlib.pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(9.2, 3.0))
    rows = result.get("particles", [])
    n, times = [r["particles"] for r in rows], [r["ns"] for r in rows]
    left.fill_between(n, [t[1] for t in times], [t[2] for t in times], alpha=0.2, lw=0.0)
    left.plot(n, [t[0] for t in times], "o-")
    left.set(xscale="log", xlabel="particles", ylabel="ns per particle-step", ylim=(0.0, None))
    rows = result.get("threads", [])
    threads = [r["threads"] for r in rows]
    right.plot(threads, threads, color="#9aa1a9", lw=0.8, label="ideal")
    right.plot(threads, [r["ratio"][0] for r in rows], "o-", label="mpmkit")
    right.set(xlabel="threads", ylabel="speed over that of one thread", xticks=threads, ylim=(0.0, None))
    right.legend()
    return figure
