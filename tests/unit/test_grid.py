"""The domain: what is accepted, what is refused, and where the nodes are."""

import numpy as np
import pytest

import mpmkit as mpm

EPS = np.finfo(float).eps


def test_scalars_make_a_line():
    grid = mpm.Grid(0.0, 2.0, 0.5)
    assert (grid.dim, grid.cells, grid.nodes, grid.n_nodes, grid.space) == (1, (4,), (5,), 5, "1D")
    assert grid.faces == ("xmin", "xmax")


@pytest.mark.parametrize(
    ("lower", "coordinates", "space"),
    [
        ((0,), "cartesian", "1D"),
        ((0, 0), "cartesian", "plane strain"),
        ((0, 0), "axisymmetric", "axisymmetric"),
        ((0, 0, 0), "cartesian", "3D"),
    ],
)
def test_space_is_one_of_the_four(lower, coordinates, space):
    from mpmkit.interfaces import SPACES

    grid = mpm.Grid(lower, tuple(1 for _ in lower), 0.25, coordinates)
    assert grid.space == space in SPACES
    assert len(grid.faces) == 2 * grid.dim


def test_one_spacing_stands_for_all_axes():
    grid = mpm.Grid((0, 0), (1, 2), 0.25)
    assert grid.spacing == (0.25, 0.25)
    assert grid == mpm.Grid((0, 0), (1, 2), (0.25, 0.25))
    assert hash(grid) == hash(mpm.Grid((0, 0), (1, 2), (0.25, 0.25)))
    assert mpm.Grid((0, 0), (1, 2), (0.25, 0.5)).h == 0.25


def test_nodes_run_with_the_last_axis_fastest():
    grid = mpm.Grid((0, 10), (1, 13), (0.5, 1.0))
    x = grid.node_positions()
    assert x.shape == (grid.n_nodes, 2)
    np.testing.assert_array_equal(x[:5], [(0, 10), (0, 11), (0, 12), (0, 13), (0.5, 10)])
    index = np.arange(grid.n_nodes).reshape(grid.nodes)
    np.testing.assert_array_equal(x[index[2, 3]], (1, 13))


@pytest.mark.parametrize("cells", [3, 7, 20, 333])
def test_inexact_decimals_are_whole_numbers_of_cells(cells):
    assert mpm.Grid(0.1, 0.1 + 0.7, 0.7 / cells).cells == (cells,)
    assert mpm.Grid(0.0, 1.0, 1.0 / cells).cells == (cells,)


def test_quantities_with_units():
    assert mpm.Grid("0 mm", "10 cm", "5 mm").cells == (20,)


def test_proposes_the_nearest_upper_corner():
    with pytest.raises(mpm.ParameterError, match=r"side in y from 0 to 1 m is 3\.333.* set upper in y to 0\.9, or spacing to 0\.333"):
        mpm.Grid((0, 0), (0.9, 1.0), 0.3)
    assert mpm.Grid((0, 0), (0.9, 0.9), 0.3).cells == (3, 3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"lower": (0, 0, 0, 0), "upper": (1, 1, 1, 1), "spacing": 0.5}, "1, 2 or 3 numbers"),
        ({"lower": (), "upper": (), "spacing": 0.5}, "1, 2 or 3 numbers"),
        ({"lower": (0, 0), "upper": (1,), "spacing": 0.5}, "Grid.upper must have 2 numbers"),
        ({"lower": (0, 0), "upper": (1, 1), "spacing": (0.5, 0.5, 0.5)}, "Grid.spacing must be one number or 2"),
        ({"lower": 0, "upper": 0, "spacing": 0.5}, "must be > Grid.lower in x"),
        ({"lower": 0, "upper": 1, "spacing": 0}, "must be > 0"),
        ({"lower": 0, "upper": 1, "spacing": -0.1}, "must be > 0"),
        ({"lower": 0, "upper": 1, "spacing": 1}, "at least 2 are needed: set spacing to at most 0.5"),
        ({"lower": 0, "upper": float("inf"), "spacing": 1}, "must be finite"),
        ({"lower": 0, "upper": float("nan"), "spacing": 1}, "got nan"),
        ({"lower": 0, "upper": 1, "spacing": 1e-30}, "at most 2\\^31"),
        ({"lower": 0, "upper": 1, "spacing": "3 kg"}, "not a quantity in m"),
        ({"lower": 0, "upper": 1, "spacing": 0.5, "coordinates": "axisymmetric"}, "needs 2 numbers"),
        ({"lower": (-1, 0), "upper": (1, 1), "spacing": 0.5, "coordinates": "axisymmetric"}, "radius must be >= 0"),
        ({"lower": (0, 0), "upper": (1, 1), "spacing": 0.5, "lateral": "stress"}, "works in 1D only"),
        ({"lower": (0, 0), "upper": (1, 1), "spacing": 0.5, "coordinates": "axisymetric"}, "did you mean 'axisymmetric'"),
    ],
)
def test_refusals_say_what_and_why(arguments, message):
    with pytest.raises(mpm.ParameterError, match=message):
        mpm.Grid(**arguments)


def test_faces_belong_to_the_domain():
    """Tolerance: rounding, 1e-9 of a cell."""
    grid = mpm.Grid((0, 0), (1, 1), 0.1)
    x = np.array([(0, 0), (1, 1), (1 + 5e-11, 0.5), (1 + 1e-9, 0.5), (-1e-9, 0.5), (0.5, 2)])
    np.testing.assert_array_equal(grid.contains(x), [True, True, True, False, False, False])
    with pytest.raises(mpm.ParameterError, match=r"\(n, 2\), got \(3,\)"):
        grid.contains(np.zeros(3))


def test_grid_is_frozen():
    grid = mpm.Grid(0, 1, 0.5)
    with pytest.raises(AttributeError):
        grid.lower = (1.0,)
