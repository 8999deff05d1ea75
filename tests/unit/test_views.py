"""Pictures: the right numbers at the right places, with names and units; odd requests are answered in words."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

import mpmkit as mpm
from mpmkit._core.drawing import style
from mpmkit._core.drawing.floor import Floor
from mpmkit._core.drawing.light import Shadow, blur
from mpmkit._core.drawing.quantity import quantity, von_mises
from mpmkit._core.drawing.render import render
from mpmkit._core.drawing.sizes import half_edges
from mpmkit._core.drawing.splat import EMPTY, Camera, Raster, splat

EPS = np.finfo(float).eps


def lattice(dim, n=6, h=0.1):
    return np.stack(np.meshgrid(*[(np.arange(n) + 0.5) * h] * dim, indexing="ij"), axis=-1).reshape(-1, dim)


def made(dim, count=3, meta=None, **extra):
    x = lattice(dim)
    stress = np.zeros((len(x), 6))
    stress[:, 0], stress[:, 1], stress[:, 3] = 3e6 * x[:, 0], -1e6, 2e5
    body = (x[:, 0] > 0.3).astype(int)
    frames = [
        (1e-3 * k, 10 * k, {"x": x + 0.01 * k, "v": np.ones((len(x), dim)) * x, "stress": stress, "body": body, **extra})
        for k in range(count)
    ]
    history = {
        "step": np.arange(20),
        "t": np.linspace(0, 2e-3, 20),
        "kinetic": np.linspace(2e3, 1e3, 20),
        "dissipated": np.linspace(0, 1e3, 20),
        "dt": np.full(20, 1e-4),
    }
    space = {1: "1D", 2: "plane strain", 3: "3D"}[dim]
    return mpm.Results.in_memory(frames, history, ["left", "right"], meta={"space": space, "units": {"dt": "s"}, **(meta or {})})


def test_von_mises_of_known_states():
    uniaxial, shear, hydrostatic = [5.0, 0, 0, 0, 0, 0], [0, 0, 0, 2.0, 0, 0], [7.0, 7.0, 7.0, 0, 0, 0]
    # rounding: a few eps times the stress
    np.testing.assert_allclose(von_mises(np.array([uniaxial, shear, hydrostatic])), [5.0, 2.0 * np.sqrt(3), 0.0], atol=8 * EPS * 7)
    full = np.array([[1.0, 2, 3, 2, 4, 5, 3, 5, 6]])
    np.testing.assert_allclose(von_mises(full), von_mises(np.array([[1.0, 4, 6, 2, 5, 3]])), rtol=4 * EPS)


def test_what_names_mean():
    results = made(2, X=lattice(2) - [0.3, 0.4])
    frame = results.frames[0]
    stress = frame["stress"]
    cases = {
        "v": np.hypot(*frame["v"].T),
        "v.y": frame["v"][:, 1],
        "stress": von_mises(stress),
        "stress.xy": stress[:, 3],
        "pressure": -stress[:, :3].mean(axis=1),
        "mises": von_mises(stress),
        "displacement": np.full(36, 0.5),
        "body": frame["body"],
    }
    for name, expected in cases.items():
        # rounding: sums of a few numbers of the size of the result
        np.testing.assert_allclose(
            quantity(results, frame, name).values(frame), expected, rtol=8 * EPS, atol=8 * EPS * np.abs(expected).max()
        )
    assert (quantity(results, frame, "stress").label, quantity(results, frame, "stress").unit) == ("von Mises stress", "Pa")
    bar = made(1)
    np.testing.assert_array_equal(quantity(bar, bar.frames[0], "stress").values(bar.frames[0]), bar.frames[0]["stress"][:, 0])


@pytest.mark.parametrize(
    ("field", "options", "message"),
    [
        ("stres", {}, r"no field 'stres'; did you mean 'stress'\? \(it has "),
        ("stress.xxy", {}, r"no component 'xxy'; did you mean .* \(it has xx, yy, zz, xy, yz, xz\)"),
        ("body", {"component": "x"}, r"no component 'x' \(it is one number\)"),
        ("pressure.xx", {}, "'pressure' has no components"),
        ("displacement", {}, "computed from 'X', which this run did not keep"),
        ("v", {"cmap": "viridos"}, r"no colour map 'viridos'; did you mean 'viridis'"),
        ("v", {"window": [(0, 1)]}, "window must be 2 pairs"),
        ("v", {"marker": "cross"}, "marker must be one of square, disc, deformed, got 'cross'"),
        ("v", {"time": []}, "the list of times is empty"),
    ],
)
def test_odd_requests(field, options, message):
    with pytest.raises(mpm.ResultsError, match=message):
        made(2).plot(field, **options)


def test_unwritable_pictures_are_refused_before_drawing(tmp_path):
    with pytest.raises(mpm.ResultsError, match=r"a picture file ends in one of \.png"):
        made(2).plot("v", path=tmp_path / "a.bmpx")
    with pytest.raises(mpm.ResultsError, match="there is no folder"):
        made(2).plot("v", path=tmp_path / "none" / "a.png")


def test_squares_have_the_particles_size_and_place():
    results = made(2, V=np.full(36, 0.1**2))
    figure = results.plot("stress.xx", time=1e-3)
    panel, bar = figure.axes
    squares = panel.collections[0]
    corners = np.array([p.vertices[:4] for p in squares.get_paths()])
    # rounding: coordinates of size 1
    np.testing.assert_allclose(np.ptp(corners, axis=1), 0.1, atol=8 * EPS)
    np.testing.assert_allclose(corners.mean(axis=1), results.frames[1]["x"], atol=8 * EPS)
    # colours are in the unit that the bar names: MPa
    np.testing.assert_allclose(squares.get_array(), results.frames[1]["stress"][:, 0] / 1e6, rtol=4 * EPS)
    assert bar.get_ylabel() == r"stress $\sigma_{xx}$ [MPa]"
    assert (panel.get_xlabel(), panel.get_ylabel(), panel.get_title()) == ("x [m]", "y [m]", "t = 1 ms")
    assert panel.get_aspect() == 1.0


def test_sizes_come_from_the_best_there_is():
    plain = made(2)
    np.testing.assert_allclose(half_edges(plain, plain.frames[2]), 0.05, rtol=1e3 * EPS)  # rounding: differences of coordinates
    sized = made(2, size=np.full((36, 2), 0.02), J=np.full(36, 4.0))
    np.testing.assert_allclose(half_edges(sized, sized.frames[0]), 0.04, rtol=8 * EPS)
    ring = made(2, meta={"space": "axisymmetric"}, V=np.full(36, 99.0), size=np.full((36, 2), 0.02))
    np.testing.assert_allclose(half_edges(ring, ring.frames[0]), 0.02, rtol=8 * EPS)
    ball = made(3, V=np.full(216, 1e-3))
    np.testing.assert_allclose(half_edges(ball, ball.frames[0]), 0.05, rtol=8 * EPS)


def test_deformed_particles_are_parallelograms():
    shear = np.tile(np.array([[1.0, 0.5, 0], [0, 1, 0], [0, 0, 1]]), (36, 1, 1))
    results = made(2, size=np.full((36, 2), 0.05), F=shear)
    corners = np.array([p.vertices[:4] for p in results.plot("v", 0.0, marker="deformed").axes[0].collections[0].get_paths()])
    first = corners[0] - results.frames[0]["x"][0]
    np.testing.assert_allclose(first, [(-0.075, -0.05), (0.025, -0.05), (0.075, 0.05), (-0.025, 0.05)], atol=8 * EPS)


def test_several_times_share_one_scale_and_one_bar():
    figure = made(2).plot("v", time=[0.0, 1e-3, "2 ms"])
    panels = [a for a in figure.axes if a.get_title()]
    assert [p.get_title() for p in panels] == ["t = 0 ms", "t = 1 ms", "t = 2 ms"]
    assert len({p.collections[0].norm.vmax for p in panels}) == 1
    assert len(figure.axes) == 4


def test_bodies_get_names_instead_of_a_bar():
    for dim in (2, 3):
        figure = made(dim).plot("body", dpi=40)
        assert [t.get_text() for t in figure.legends[0].get_texts()] == ["left", "right"]


def test_the_whole_grid_is_shown_when_the_particles_fill_it():
    assert made(2, meta={"grid": {"lower": [0, 0], "upper": [1, 1]}}).plot("v").axes[0].get_xlim() == (0.0, 1.0)
    low, high = made(2, meta={"grid": {"lower": [0, -50], "upper": [1, 50]}}).plot("v").axes[0].get_ylim()
    assert -1 < low < 0.07 and 0.57 < high < 1
    assert made(2).plot("v", window=[(0, 2), (0.1, 0.2)]).axes[0].get_ylim() == (0.1, 0.2)


def test_profile_lines_and_the_exact_solution():
    results = made(1)
    axes = results.plot("stress", time=0.0, exact=lambda x, t: 3e6 * x + t).axes[0]
    left, right, exact = axes.lines[0], axes.lines[1], axes.lines[2]
    np.testing.assert_allclose(np.r_[left.get_ydata(), right.get_ydata()], results.frames[0]["stress"][:, 0] / 1e6, rtol=4 * EPS)
    np.testing.assert_allclose(exact.get_ydata(), 3 * exact.get_xdata(), rtol=8 * EPS, atol=8 * EPS)
    assert axes.get_ylabel() == r"stress $\sigma_{xx}$ [MPa]"
    assert [t.get_text() for t in axes.figure.legends[0].get_texts()] == ["left", "right", "exact"]
    assert len(results.plot("v", time=[0.0, 1e-3]).legends[0].get_texts()) == 2


def test_history_lines():
    figure = made(2).plot("energies")
    (axes,) = figure.axes
    assert [t.get_text() for t in figure.legends[0].get_texts()] == ["kinetic", "dissipated"]
    assert (axes.get_ylabel(), axes.get_xlabel()) == ("energy [kJ]", "t [ms]")
    np.testing.assert_allclose(axes.lines[0].get_ydata()[[0, -1]], [2.0, 1.0], rtol=4 * EPS)
    assert made(2).plot("dt").axes[0].get_ylabel() == "dt [µs]"


def test_the_ledgers_columns_have_units_and_the_total_its_name():
    columns = {
        "step": np.arange(3),
        "t": np.arange(3.0),
        "kinetic": np.ones(3),
        "external_work": np.zeros(3),
        "energy": np.ones(3),
        "momentum_x": np.ones(3),
    }
    results = mpm.Results.in_memory([], columns, [])
    figure = results.plot("energies")
    assert [t.get_text() for t in figure.legends[0].get_texts()] == ["kinetic", "total"], "works that stayed zero are left out"
    assert results.plot("momentum_x").axes[0].get_ylabel() == "momentum x [N s]"


def test_picture_files(tmp_path):
    for dim in (1, 2, 3):
        for ending in ("png", "pdf", "svg") if dim == 2 else ("png",):
            path = tmp_path / f"{dim}.{ending}"
            made(dim).plot("stress", path=path, dpi=60)
            start = path.read_bytes()[:8]
            assert start.startswith({"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}[ending])


def test_drawing_leaves_the_settings_of_others_alone():
    import matplotlib as mpl

    before = dict(mpl.rcParams)
    made(2).plot("v")
    assert dict(mpl.rcParams) == before


def test_no_particles_and_one_particle():
    for dim in (1, 2, 3):
        for n in (0, 1):
            frame = {"x": np.full((n, dim), 0.3), "v": np.ones((n, dim)), "stress": np.zeros((n, 6))}
            for field in ("v", "stress", "pressure"):
                mpm.Results.in_memory([(0.0, 0, frame)], {}, ["a"], meta={"space": "3D"}).plot(field)


def test_nan_does_not_spoil_the_colours():
    values = np.r_[np.nan, np.inf, np.linspace(0, 1, 100)]
    assert style.colour_scale([values], False, None)[:2] == (0.0, 1.0)


def test_colour_scale():
    assert style.colour_scale([np.linspace(-1, 3, 100)], True, None)[:2] == (-3.0, 3.0)
    low, high, extend = style.colour_scale([np.r_[np.linspace(0, 1, 1000), 50.0]], False, None)
    assert (low, extend) == (0.0, "max") and high < 1.01
    assert style.colour_scale([np.full(5, 2.0)], False, None) == (1.0, 3.0, "neither")
    assert style.colour_scale([np.linspace(0, 1, 9)], False, (0.2, 2.0)) == (0.2, 2.0, "min")


def test_units_get_prefixes():
    assert style.scaled_unit(2.5e6, "Pa") == (1e-6, "MPa")
    assert style.scaled_unit(0.004, "m") == (1 / 1e-3, "mm")
    assert style.scaled_unit(0.4, "m") == (1.0, "m")
    assert style.scaled_unit(5e3, "kg/m^3") == (1.0, "kg/m^3")
    assert style.with_unit("density", "kg/m^3") == "density [kg/m³]"
    assert style.with_unit("J", "1") == "J"


def test_cameras_are_right_handed():
    for camera in (
        Camera.orbit(-58, 22),
        Camera.orbit(10, 80),
        Camera.along(np.array([1.0, 2.0, 3.0])),
        Camera.along(np.array([0, 0, 1.0])),
    ):
        axes = np.stack([camera.right, camera.up, camera.toward])
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=8 * EPS)
        assert np.linalg.det(axes) > 0
    np.testing.assert_allclose(Camera.orbit(-90, 0).project(np.eye(3)), [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=4 * EPS)


def test_the_nearest_sphere_is_seen():
    raster = Raster((40, 40), 0.05, (-1.0, -1.0))
    points = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 2.0], [5.0, 0.0, 9.0]])
    owner, depth = splat(points, np.array([0.8, 0.3, 0.3]), raster)
    across, up = raster.centres()
    r0 = np.hypot(across[None] - 0.0, up[:, None])
    r1 = np.hypot(across[None] - 0.3, up[:, None])
    assert (owner[r1 < 0.3] == 1).all(), "the sphere in front"
    assert (owner[(r0 < 0.8) & (r1 >= 0.3)] == 0).all()
    assert (owner[(r0 >= 0.8) & (r1 >= 0.3)] == EMPTY).all()
    # rounding: float32 depth of size 2, and the slope of the sphere away from its rim
    inside = r1 < 0.25
    np.testing.assert_allclose(depth[inside], 2.0 + np.sqrt(0.3**2 - r1[inside] ** 2), atol=16 * np.finfo("f4").eps)


def test_shadow_and_contact_fall_below_a_sphere():
    x, radius = np.array([[0.5, 0.5, 0.4]]), np.array([0.2])
    ground = np.array([[0.5, 0.5, 0.0], [0.05, 0.05, 0.0]])
    lit = Shadow(x, radius, np.array([0.0, 0.0, 1.0])).lit(ground)
    assert lit[0] < 0.5 and lit[1] == 1.0
    near = Floor(np.zeros(3), np.ones(3)).contact(x - [0, 0, 0.19], radius, ground)
    far = Floor(np.zeros(3), np.ones(3)).contact(x, radius, ground)
    assert near[0] > far[0] > far[1]


def test_a_wide_blur_keeps_the_sum():
    image = np.zeros((301, 203))
    image[120:170, 60:130] = 1.0
    for width in (2.0, 25.0):
        # rate of the coarse image: its edges are sampled to a few per mille
        assert blur(image, width).sum() == pytest.approx(image.sum(), rel=5e-3)
    assert np.abs(blur(image, 9.0) - gaussian_filter(image, 9.0)).max() < 0.06


def test_a_rendered_ball_is_lit_from_the_upper_left():
    camera = Camera.orbit(-60, 20)
    raster = Raster((60, 60), 0.05, (-1.5, -1.5))
    picture = render(np.zeros((1, 3)), np.array([1.0]), np.array([[0.2, 0.5, 0.8]]), camera, raster)
    assert picture.shape == (60, 60, 4) and picture[30, 30, 3] == 1.0 and picture[0, 0, 3] == 0.0
    brightness = picture[..., :3].sum(axis=-1)
    assert brightness[20, 24] > brightness[42, 38] > 0
    assert picture[30, 30, 2] > picture[30, 30, 1] > picture[30, 30, 0], "its colour stays recognisable"
