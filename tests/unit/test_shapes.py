"""Weights of the bundled shape functions against their definitions."""

import numpy as np
import pytest
from mpmkit_shapes import GIMP, ContiguousGIMP, CubicBSpline, Linear, QuadraticBSpline

import mpmkit as mpm

EPS = np.finfo(float).eps


def tent_average(xi, half):
    """Average of the tent max(0, 1 - |s|) over [xi - half, xi + half], by the integral of the tent."""

    def integral(s):
        s = np.clip(s, -1.0, 1.0)
        return s - 0.5 * s * np.abs(s)

    return (integral(xi + half) - integral(xi - half)) / (2.0 * half)


def at(shape, f, *half):
    weights, slopes = shape.weights(f, *half)
    return np.array(weights), np.array(slopes)


@pytest.mark.parametrize("half", [0.05, 0.25, 0.5])
def test_gimp_is_the_average_of_the_tent_over_the_particle(half):
    """Rounding: the reference divides a difference of order 1 by 2 half."""
    for f in np.linspace(0.5, 1.5, 41)[:-1]:
        weights, _ = at(GIMP(), f, half)
        assert weights == pytest.approx([tent_average(f - i, half) for i in range(3)], abs=10 * EPS / half)


@pytest.mark.parametrize("reach", [1, 2])
def test_contiguous_gimp_is_the_average_over_particles_of_any_size(reach):
    """Rounding, as above."""
    shape = ContiguousGIMP(reach=reach)
    for half in np.array([0.1, 0.5, 0.75, 1.0]) * reach:
        for f in np.linspace(reach, reach + 1, 41)[:-1]:
            weights, slopes = at(shape, f, half)
            assert weights == pytest.approx([tent_average(f - i, half) for i in range(shape.nodes)], abs=20 * EPS / half)
            ends = [(max(0, 1 - abs(f + half - i)) - max(0, 1 - abs(f - half - i))) / (2 * half) for i in range(shape.nodes)]
            assert slopes == pytest.approx(ends, abs=20 * EPS / half)


def test_gimp_published_values():
    """Bardenhagen and Kober (2004), at a node with the half size l = 1/4: 1 - l / 2 there and l / 4 on both sides. Rounding."""
    weights, slopes = at(GIMP(), 1.0, 0.25)
    assert weights == pytest.approx([0.25 / 4, 1 - 0.25 / 2, 0.25 / 4], abs=4 * EPS)
    assert slopes == pytest.approx([-0.5, 0.0, 0.5], abs=4 * EPS)


def test_contiguous_gimp_with_half_a_cell_is_uniform_gimp():
    """Rounding: both are exact to a few machine epsilons."""
    for f in np.linspace(1.0, 2.0, 33)[:-1]:
        four = at(ContiguousGIMP(), f, 0.5)
        start = 0 if f < 1.5 else 1  # GIMP's first node: floor(f - 1/2)
        three = at(GIMP(), f - start, 0.5)
        for found, wanted in zip(four, three, strict=True):
            assert found[start : start + 3] == pytest.approx(wanted, abs=8 * EPS)
            assert np.delete(found, range(start, start + 3)) == pytest.approx([0.0], abs=8 * EPS)


@pytest.mark.parametrize("half", [1e-3, 1e-8, 1e-15, 0.0])
@pytest.mark.parametrize("shape", [GIMP(), ContiguousGIMP(), ContiguousGIMP(reach=2)], ids=str)
def test_small_particles_are_points(shape, half):
    """A particle of vanishing size has the tent's own weights. Rounding, plus the averaging error half / 2 at the kink."""
    for f in np.linspace(shape.offset, shape.offset + 1, 38)[:-1]:
        weights, slopes = at(shape, f, half)
        assert weights == pytest.approx([max(0.0, 1.0 - abs(f - i)) for i in range(shape.nodes)], abs=4 * EPS + half)
        assert weights.sum() == pytest.approx(1.0, abs=4 * EPS)
        assert weights @ np.arange(shape.nodes) == pytest.approx(f, abs=8 * EPS)
        assert slopes @ np.arange(shape.nodes) == pytest.approx(1.0, abs=8 * EPS)


@pytest.mark.parametrize(("shape", "degree"), [(QuadraticBSpline(), 2), (CubicBSpline(), 3)], ids=str)
def test_splines_are_those_of_scipy(shape, degree):
    """Rounding: 8 machine epsilons."""
    from scipy.interpolate import BSpline

    spline = BSpline.basis_element(np.arange(degree + 2) - (degree + 1) / 2, extrapolate=False)
    for f in np.linspace(shape.offset, shape.offset + 1, 23)[1:-1]:
        weights, slopes = at(shape, f)
        places = f - np.arange(shape.nodes)
        assert weights == pytest.approx(np.nan_to_num(spline(places)), abs=8 * EPS)
        assert slopes == pytest.approx(np.nan_to_num(spline.derivative()(places)), abs=8 * EPS)


def test_linear_weights():
    """Exact numbers."""
    assert Linear().weights(0.25) == ((0.75, 0.25), (-1.0, 1.0))


def test_gimp_kinds_refuse_rings_and_splines_do_not():
    assert "axisymmetric" not in GIMP.spaces
    assert "axisymmetric" not in ContiguousGIMP.spaces
    assert all("axisymmetric" in shape.spaces for shape in (Linear, QuadraticBSpline, CubicBSpline))


def test_reach_sets_the_support_and_is_checked():
    shape = ContiguousGIMP(reach=2)
    assert (shape.nodes, shape.offset, shape.max_half) == (6, 2.0, 2.0)
    with pytest.raises(mpm.ParameterError, match=r"ContiguousGIMP.reach must be one of 1, 2, got 3"):
        ContiguousGIMP(reach=3)
