from __future__ import annotations

import itertools
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from small_study import STRESS, results

import mpmkit as mpm
from mpmkit._core.drawing import style
from mpmkit.studies import fit, pictures
from mpmkit.studies.results import StudyResults


def texts(figure):
    return [t.get_text() for axes in figure.axes for t in axes.texts]


def test_the_front_is_drawn_where_it_is():
    figure = pictures.draw(results(), STRESS, "work-precision")
    (axes,) = figure.axes
    front = fit.front(results().rows, STRESS)
    thick = next(line for line in axes.lines if line.get_linewidth() == 5.0)
    assert list(thick.get_xdata())[:-1] == [r["seconds"] for r in front]
    assert list(thick.get_ydata())[:-1] == [r["errors"][STRESS] for r in front]
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log") and axes.get_xlabel() == "wall time of stepping [s]"


def test_one_colour_per_composition_and_one_marker_per_resolution():
    figure = pictures.draw(results(), STRESS, "work-precision")
    marks = {}
    for line in figure.axes[0].lines:
        if line.get_marker() in pictures.MARKERS and line.get_transform() != figure.axes[0].transAxes:
            (x,), (y,) = line.get_xdata(), line.get_ydata()
            row = next(r for r in results().done(STRESS) if r["seconds"] == x and r["errors"][STRESS] == y)
            marks[row["label"]] = (line.get_color(), line.get_marker(), row)
    assert len(marks) == 10
    for colour, mark, row in marks.values():
        assert colour == pictures.COLOURS[["Linear", "GIMP", "QuadraticBSpline"].index(row["composition"])]
        assert mark == pictures.MARKERS[[0.1, 0.05, 0.025, 0.0125].index(row["resolution"])]


def test_runs_without_a_result_stand_at_the_edge():
    figure = pictures.draw(results(), STRESS)
    work, convergence = figure.axes
    assert {"unstable", "refused"} <= set(texts(figure))
    assert sum(line.get_marker() == "x" for line in work.lines) == 2
    crosses = {line.get_xdata()[0] for line in convergence.lines if line.get_marker() == "x"}
    assert crosses == {0.0125, 0.1}
    assert work.get_xlim()[1] > 2 * max(r["seconds"] for r in results().done())  # the strip is beyond all times


def test_spreads_are_bars():
    (axes,) = pictures.draw(results(), STRESS, "work-precision").axes
    bars = [segment for collection in axes.collections for segment in collection.get_segments()]
    assert len(bars) == 10
    first = results().rows[0]
    assert [p[0] for p in bars[0]] == pytest.approx([first["seconds_low"], first["seconds_high"]])


def test_fitted_orders_are_in_the_legend_and_slopes_beside_them():
    figure = pictures.draw(results(), STRESS, "convergence")
    labels = [t.get_text() for t in figure.legends[0].get_texts()]
    assert labels[:3] == ["Linear: order 1.00 ± 0.00", "GIMP: order 2.00 ± 0.00", "QuadraticBSpline: order 3.00 ± 0.00"]
    assert [t.strip() for t in texts(figure)] == ["1", "2", "3"]


def test_many_compositions_have_dashes_when_colours_begin_again():
    rows = [row | {"composition": f"{row['composition']} {k}"} for k in range(3) for row in results()]
    looks = pictures.Looks.of(StudyResults(rows, results().meta))
    assert len(looks.colours) == 9 and len(set(looks.colours.values())) == 9


def crossed():
    """The rows of the small study under two integrators, and one composition with a name of its own."""
    rows = [
        row | {"composition": f"{row['composition']}, {how}", "labels": row["labels"] | {"integrator": how}}
        for how in ("MUSL", "USL")
        for row in results()
    ]
    fem = [row | {"composition": "FEM", "labels": {"discretization": "FEM"}} for row in results() if row["composition"] == "Linear"]
    return StudyResults([*rows, *fem], results().meta)


def test_a_product_of_two_axes_has_colours_for_one_and_dashes_for_the_other():
    looks = pictures.Looks.of(crossed()).colours
    shapes = ("Linear", "GIMP", "QuadraticBSpline")
    for k, shape in enumerate(shapes):
        assert [looks[f"{shape}, {how}"] for how in ("MUSL", "USL")] == [(pictures.COLOURS[k], dash) for dash in pictures.DASHES[:2]]
    assert looks["FEM"] == (pictures.COLOURS[len(shapes)], pictures.DASHES[0])


def test_panels_of_one_kind_stand_two_in_a_row():
    both = pictures.draw(results(), kind="convergence")  # two errors
    first, second = (axes.get_position() for axes in both.axes)
    assert first.y0 == pytest.approx(second.y0) and first.x1 < second.x0
    assert both.get_size_inches()[0] == pytest.approx(2 * pictures.WIDTH)


VISION = {
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
    "usual": np.eye(3),
}
"""How linear RGB is seen: Machado, Oliveira and Fernandes, IEEE TVCG 15 (2009) 1291, severity 1."""


def lab(colour, vision):
    """CIELAB of a colour as somebody sees it."""
    c = np.array(to_rgb(colour))
    linear = np.clip(np.array(vision) @ np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4), 0.0, 1.0)
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]) @ linear / (0.9505, 1.0, 1.089)
    f = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("colours", [pictures.COLOURS, pictures.IN_THE_DARK])
@pytest.mark.parametrize("vision", VISION)
def test_colours_are_told_apart_by_everybody(colours, vision):
    seen = [lab(c, VISION[vision]) for c in colours]
    assert (
        min(np.linalg.norm(a - b) for a, b in itertools.combinations(seen, 2)) > 17.0
    )  # pinned: what they have now; 2 is just seen side by side


def test_problems_have_panels_of_their_own():
    rows = [row | {"problem": p, "composition": f"{p}, {row['composition']}"} for p in ("A=1", "A=2") for row in results()]
    figure = pictures.draw(StudyResults(rows, results().meta), STRESS)
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["A=1", "A=1", "A=2", "A=2"]
    assert len(pictures.Looks.of(StudyResults(rows, results().meta)).colours) == 3


@pytest.mark.parametrize("name", ["study.png", "study.svg"])
def test_files_are_written(tmp_path, name):
    figure = results().plot(tmp_path / name)
    assert len(figure.axes) == 4
    data = (tmp_path / name).read_bytes()
    assert data.startswith(b"\x89PNG" if name.endswith("png") else b"<?xml")


def test_an_svg_for_a_page_takes_its_colours_and_has_its_own_names():
    one, two = (pictures.svg(results(), STRESS, kind, prefix) for kind, prefix in (("work-precision", "a"), ("convergence", "b")))
    for text in (one, two):
        ET.fromstring(text)
        assert style.INK not in text and "currentColor" in text and "var(--c0, #2f6db3)" in text
    names = [set(re.findall(r'\bid="([^"]+)"', text)) for text in (one, two)]
    assert not names[0] & names[1]
    assert set(re.findall(r'href="#([^"]+)"', one)) <= names[0]


def test_a_study_without_times_is_drawn_by_its_convergence():
    rows = [row | {"seconds": None, "seconds_low": None, "seconds_high": None} for row in results()]
    figure = StudyResults(rows, results().meta).plot(measure=STRESS)
    assert len(figure.axes) == 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"measure": "stress.xx, L2 [Pa]"}, "the study has no error 'stress.xx, L2 .*; did you mean 'stress.xx, L1"),
        ({"kind": "convergenc"}, "did you mean 'convergence'?"),
        ({"path": "study.pdf"}, "a picture of a study ends in .png or .svg"),
        ({"path": "/dev/null/study.png"}, "cannot write /dev/null/study.png: .*; choose another place"),
    ],
)
def test_what_cannot_be_drawn(arguments, message):
    with pytest.raises(mpm.ResultsError, match=message):
        results().plot(**arguments)


def test_nothing_to_draw_is_said():
    with pytest.raises(mpm.ResultsError, match="there is nothing to draw"):
        StudyResults([], {"errors": [{"label": "e", "unit": "1"}]}).plot()
