"""Shapes: exact measures, what is inside, and the algebra of combinations."""

import math
import pickle

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import mpmkit as mpm
from mpmkit.geometry import GEOMETRIES, Geometry, PointCloud
from mpmkit.geometry.measure import subdivided_measure
from mpmkit.parameters import example_arguments, specs

EPS = np.finfo(float).eps
RNG_SEED = 20240605

SQUARE = mpm.Box((0, 0), (1, 1))
CUBE = mpm.Box((0, 0, 0), (1, 1, 1))
TRIANGLE = mpm.Polygon([(0, 0), (1, 0), (0, 1)])
STAR = mpm.Polygon(
    [
        (math.cos(k * math.pi / 5) * (1.0 if k % 2 == 0 else 0.4), math.sin(k * math.pi / 5) * (1.0 if k % 2 == 0 else 0.4))
        for k in range(10)
    ]
)
STAR_AREA = 10 * 0.5 * 1.0 * 0.4 * math.sin(math.pi / 5)

EXACT = [
    (mpm.Box(0.25, 1.0), 0.75),
    (mpm.Box((0, 0), (2, 0.5)), 1.0),
    (mpm.Box((0, 0, 0), (2, 0.5, 3)), 3.0),
    (mpm.Disk((3, 4), 0.5), math.pi / 4),
    (mpm.Sphere((1, 1, 1), 0.5), math.pi / 6),
    (mpm.Cylinder((0, 0, 0), (1, 2, 2), 0.5), 0.75 * math.pi),
    (TRIANGLE, 0.5),
    (mpm.Polygon([(0, 0), (0, 1), (1, 0)]), 0.5),  # the other way round
    (mpm.Polygon([(0, 0), (1, 0), (0, 1), (0, 0)]), 0.5),  # closed explicitly
    (STAR, STAR_AREA),
    (mpm.Polygon(np.array([(1000.0, 1000.0), (1001.0, 1000.0), (1001.0, 1002.0)])), 1.0),
    (mpm.Disk((0, 0), 1.0) - mpm.Disk((0.2, 0), 0.75), math.pi * (1 - 0.75**2)),
    (mpm.Difference(SQUARE, mpm.Disk((0.25, 0.25), 0.2), mpm.Disk((0.75, 0.75), 0.2)), 1 - 2 * math.pi * 0.04),
    (SQUARE - mpm.Box((0.5, -1), (3, 0.5)), 0.75),
    (SQUARE - mpm.Disk((5, 5), 1), 1.0),
    (SQUARE - mpm.Box((-1, -1), (2, 2)), 0.0),
    (mpm.Cylinder((0, 0, 0), (0, 0, 2), 1.0) - mpm.Cylinder((0, 0, 0), (0, 0, 2), 0.5), 1.5 * math.pi),
    (SQUARE | mpm.Box((1, 0), (3, 1)), 3.0),
    (SQUARE | mpm.Box((0.5, 0.5), (1.5, 1.5)), 1.75),
    (SQUARE | mpm.Disk((0.5, 0.5), 0.25), 1.0),
    (mpm.Union(SQUARE, mpm.Disk((3, 0), 1), mpm.Disk((6, 0), 1)), 1 + 2 * math.pi),
    (SQUARE & mpm.Box((0.5, 0.5), (1.5, 1.5)), 0.25),
    (SQUARE & mpm.Disk((0.5, 0.5), 0.25), math.pi / 16),
    (SQUARE & mpm.Disk((5, 5), 1), 0.0),
    (mpm.Transformed(STAR, rotate=33, scale=2, translate=(5, 1)), 4 * STAR_AREA),
    (mpm.Transformed(CUBE, rotate=33, axis=(1, 1, 0), scale=(1, 2, 3)), 6.0),
    (mpm.Transformed(mpm.Box(0, 1), scale=3.0, translate=1.0), 3.0),
]


@pytest.mark.parametrize(("shape", "exact"), EXACT, ids=[str(k) for k in range(len(EXACT))])
def test_closed_forms(shape, exact):
    """Tolerance: rounding, 50 eps times the size of the coordinates' box."""
    assert shape.volume() == pytest.approx(exact, rel=0, abs=50 * EPS * max(1.0, exact))
    assert shape.measure() == shape.volume()


CURVED = [s for s, _ in EXACT if s.volume() > 0]


@pytest.mark.parametrize("shape", CURVED, ids=[type(s).__name__ + str(k) for k, s in enumerate(CURVED)])
def test_subdivision_finds_the_closed_form(shape):
    """An independent computation of the same number; bound: half a sampling distance all over the surface of the box."""
    levels = {1: 20, 2: 7, 3: 4}[shape.dim]
    box = float(np.subtract(*shape.bounds()[::-1]).prod())
    layer = 2.0 * shape.dim * box * 0.5 / 2 ** (levels + 2)
    assert abs(subdivided_measure(shape, levels) - shape.volume()) <= layer


def test_subdivision_converges():
    """Rate: mean error over twelve lenses at four resolutions; first order is what any sampling gives, smooth edges give about 1.5."""
    errors = []
    for levels in (2, 3, 4, 5):
        error = []
        for d in np.linspace(0.3, 1.5, 12):
            lens = 2 * math.acos(d / 2) - 0.5 * d * math.sqrt(4 - d * d)
            shape = mpm.Disk((0, 0), 1) & mpm.Disk((d, 0), 1)
            assert shape.volume() is None
            error.append(abs(shape.measure(levels) - lens))
        errors.append(np.mean(error))
    order = np.polyfit(np.arange(4), -np.log2(errors), 1)[0]
    assert order >= 1.1
    assert errors[-1] < 1e-3


@pytest.mark.parametrize("shape", [s for s, _ in EXACT], ids=[str(k) for k in range(len(EXACT))])
def test_first_moments(shape):
    """Volume and centroid against a regular lattice; bound: surface layer of half a lattice spacing times the lever."""
    n = {1: 4000, 2: 300, 3: 60}[shape.dim]
    lower, upper = (np.array(c) for c in shape.bounds())
    step = (upper - lower) / n
    ticks = [lo + (np.arange(n) + 0.5) * d for lo, d in zip(lower, step, strict=True)]
    x = np.stack(np.meshgrid(*ticks, indexing="ij"), axis=-1).reshape(-1, shape.dim)
    moments = shape.moments()
    inside = x[shape.contains(x)] - lower
    first = inside.sum(axis=0) * step.prod()
    exact = np.array(moments[1]) - moments[0] * lower
    assert (np.abs(first - exact) <= 3.0 / n * (upper - lower).prod() * (upper - lower)).all()


SAMPLES = [
    *[s for s, _ in EXACT],
    mpm.HalfSpace((0.2, 0.3), (1, 2)),
    mpm.HalfSpace((0.2, 0.3, 0.1), (0, 0, -2)),
    mpm.HalfSpace(0.5, 1.0),
    mpm.Transformed(mpm.HalfSpace((0, 0), (0, 1)), rotate=45),
]


@pytest.mark.parametrize("shape", SAMPLES, ids=[type(s).__name__ + str(k) for k, s in enumerate(SAMPLES)])
def test_depth_changes_no_faster_than_the_distance(shape):
    """Tolerance: rounding, 1e-12 times the coordinates' size."""
    rng = np.random.default_rng(RNG_SEED)
    center = np.array([0.5 * (a + b) if math.isfinite(a + b) else 0.0 for a, b in zip(*shape.bounds(), strict=True)])
    x = center + rng.uniform(-2, 2, (400, shape.dim))
    y = x + rng.normal(0, 0.3, x.shape)
    slack = 1e-12 * max(1.0, np.abs(x).max())
    assert (np.abs(shape.depth(x) - shape.depth(y)) <= np.linalg.norm(x - y, axis=1) + slack).all()


@pytest.mark.parametrize("shape", SAMPLES, ids=[type(s).__name__ + str(k) for k, s in enumerate(SAMPLES)])
def test_everything_inside_lies_in_the_bounds(shape):
    rng = np.random.default_rng(RNG_SEED)
    lower, upper = (np.clip(c, -3, 3e3) for c in shape.bounds())
    x = rng.uniform(lower - 1, np.minimum(upper, lower + 10) + 1, (4000, shape.dim))
    inside = x[shape.contains(x)]
    lower, upper = shape.bounds()
    assert (inside >= np.array(lower) - 1e-9).all()
    assert (inside <= np.array(upper) + 1e-9).all()
    if shape.tight_bounds and shape.volume() != 0.0:
        wide = np.array(upper) - np.array(lower)
        assert ((inside.max(axis=0) - inside.min(axis=0)) > 0.5 * wide).all()


def test_surface_belongs_to_the_shape_on_every_side():
    """Tolerance: rounding, 1e-12 of the coordinates' size; no lattice point on a face is lost, on either side."""
    for n in (3, 7, 10, 49):
        ticks = np.arange(n + 1) * (0.3 / n) + 0.1  # the last one is 0.4 only up to rounding
        x = np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2)
        assert mpm.Box((0.1, 0.1), (0.4, 0.4)).contains(x).all()
        assert mpm.Polygon([(0.1, 0.1), (0.4, 0.1), (0.4, 0.4), (0.1, 0.4)]).contains(x).all()
        assert mpm.Transformed(mpm.Box((-0.15, -0.15), (0.15, 0.15)), rotate=90, translate=(0.25, 0.25)).contains(x).all()
        assert (mpm.Box((0, 0), (0.4, 0.4)) - mpm.Box((0, 0), (0.1, 0.4)) - mpm.Box((0, 0), (0.4, 0.1))).contains(x).all()
    just_outside = np.array([(0.4 + 1e-9, 0.2), (0.1 - 1e-9, 0.2)])
    assert not mpm.Box((0.1, 0.1), (0.4, 0.4)).contains(just_outside).any()


def test_one_dimension_takes_plain_numbers():
    bar = mpm.Box(0.0, 1.0)
    np.testing.assert_array_equal(bar.contains([-0.1, 0.0, 0.5, 1.0, 1.1]), [False, True, True, True, False])
    with pytest.raises(mpm.ParameterError, match=r"\(n, 2\)"):
        SQUARE.contains([0.1, 0.2])


def test_polygon_with_a_dent():
    x = np.array(
        [
            (0.9, 0.0),
            (0.41, 0.0),
            (0.35 * math.cos(math.pi / 5), 0.35 * math.sin(math.pi / 5)),
            (0.7 * math.cos(math.pi / 5), 0.7 * math.sin(math.pi / 5)),
        ]
    )
    np.testing.assert_array_equal(STAR.contains(x), [True, True, True, False])


def test_cylinder_is_tight_around_a_slanted_axis():
    """Tolerance: rounding, 10 eps."""
    lower, upper = mpm.Cylinder((0, 0, 0), (1, 1, 0), 1.0).bounds()
    s = math.sqrt(0.5)
    np.testing.assert_allclose(lower, (-s, -s, -1), rtol=0, atol=10 * EPS)
    np.testing.assert_allclose(upper, (1 + s, 1 + s, 1), rtol=0, atol=10 * EPS)


def test_half_space_ends_only_where_its_plane_is():
    assert mpm.HalfSpace((0.5, 2.0), (0, 3)).bounds() == ((-math.inf, -math.inf), (math.inf, 2.0))
    assert mpm.HalfSpace((0.5, 2.0), (-1, 0)).bounds() == ((0.5, -math.inf), (math.inf, math.inf))
    assert mpm.HalfSpace((0.5, 2.0), (1, 1)).bounds() == ((-math.inf,) * 2, (math.inf,) * 2)
    with pytest.raises(mpm.ParameterError, match="no end.*intersect it with a Box"):
        mpm.HalfSpace((0.5, 2.0), (0, 3)).measure()
    assert (mpm.HalfSpace((0.5, 0.5), (1, 1)) & SQUARE).measure() == pytest.approx(0.5, abs=2 * math.sqrt(2) / 2**12)


class TestTransformed:
    def test_order_is_scale_rotate_move(self):
        shape = mpm.Transformed(mpm.Box((0, 0), (1, 1)), scale=(2, 1), rotate=90, translate=(10, 0))
        lower, upper = shape.bounds()  # exact, because quarter turns are
        assert (lower, upper) == ((9.0, 0.0), (10.0, 2.0))

    def test_about_a_point(self):
        """Tolerance: rounding, 10 eps."""
        shape = mpm.Transformed(mpm.Box((0.4, 0.4), (0.6, 0.6)), rotate=45, scale=2, about=(0.5, 0.5))
        lower, upper = shape.bounds()
        reach = 0.2 * math.sqrt(2)
        np.testing.assert_allclose((lower, upper), ((0.5 - reach,) * 2, (0.5 + reach,) * 2), rtol=0, atol=10 * EPS)

    def test_three_dimensions_turn_by_the_right_hand_rule(self):
        shape = mpm.Transformed(mpm.Box((1, 0, 0), (2, 0.1, 0.1)), rotate="90 deg", axis=(0, 0, 5))
        assert shape.contains([(-0.05, 1.5, 0.05)]).all()
        assert not shape.contains([(0.05, -1.5, 0.05)]).any()

    def test_units(self):
        assert mpm.Transformed(SQUARE, rotate=f"{math.pi / 2!r} rad").rotate == pytest.approx(90.0, rel=4 * EPS)

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({"shape": CUBE, "rotate": 10}, "needs an axis in 3D"),
            ({"shape": CUBE, "rotate": 10, "axis": (0, 0, 0)}, "must not be zero"),
            ({"shape": SQUARE, "rotate": 10, "axis": (0, 0, 1)}, "for shapes in 3D"),
            ({"shape": mpm.Box(0, 1), "rotate": 10}, "no meaning in 1D"),
            ({"shape": SQUARE, "scale": 0}, "must be > 0"),
            ({"shape": SQUARE, "scale": (1, 1, 1)}, "1 or 2 numbers"),
            ({"shape": SQUARE, "translate": 1}, "translate must have 2"),
            ({"shape": "Box"}, "must be a Geometry"),
        ],
    )
    def test_refusals(self, arguments, message):
        with pytest.raises(mpm.ParameterError, match=message):
            mpm.Transformed(**arguments)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: mpm.Box((0, 0), (1, 0)), r"Box.upper must be > Box.lower in y, got lower 0 and upper 0"),
        (lambda: mpm.Box((0, 0), (1,)), "Box.upper must have 2 numbers"),
        (lambda: mpm.Box((0, math.inf), (1, 1)), "must be finite|must be >"),
        (lambda: mpm.Disk((0, 0), -1), r"Disk.radius must be > 0, < inf, got -1"),
        (lambda: mpm.Disk((0, 0, 0), 1), "Disk.center must have 2 numbers"),
        (lambda: mpm.Disk((0, 0), "3 s"), "not a quantity in m"),
        (lambda: mpm.Sphere((0, 0), 1), "Sphere.center must have 3"),
        (lambda: mpm.Cylinder((0, 0, 0), (0, 0, 0), 1), "must differ"),
        (lambda: mpm.HalfSpace((0, 0), (0, 0)), "must not be zero"),
        (lambda: mpm.HalfSpace((0, 0), (0, 0, 1)), "must have 2"),
        (lambda: mpm.Polygon([(0, 0), (1, 1)]), "at least 3 points"),
        (lambda: mpm.Polygon([(0, 0), (1, 1), (1, 0), (0, 1)]), "cross each other"),
        (lambda: mpm.Polygon([(0, 0), (1, 0), (1, 0), (0, 1)]), "followed by the same point"),
        (lambda: mpm.Polygon([(0, 0), (1, 0), (0.5, 0), (0.5, 1)]), "straight back"),
        (lambda: mpm.Polygon([(0, 0), (1, 0, 2), (0, 1)]), r"Polygon.points\[1\] must have 2"),
        (lambda: mpm.Union(), "at least one shape"),
        (lambda: mpm.Union(SQUARE, 3), r"Union.shapes\[1\] must be a Geometry"),
        (lambda: SQUARE | CUBE, r"Union.shapes\[1\] \(Box\) has 3 dimensions"),
    ],
)
def test_refusals(make, message):
    with pytest.raises(mpm.ParameterError, match=message):
        make()


def test_operators_refuse_other_things():
    for operation in (lambda: SQUARE | 1, lambda: SQUARE & 1, lambda: SQUARE - 1):
        with pytest.raises(TypeError):
            operation()


@pytest.mark.parametrize("cls", GEOMETRIES.values(), ids=GEOMETRIES)
def test_every_shape_is_declared_and_can_be_made_from_its_examples(cls):
    for name, (attribute, spec) in specs(cls).items():
        assert spec.doc, f"{cls.__name__}.{name} has no doc"
        assert attribute.type is not None
    shape = cls(**example_arguments(cls))
    assert isinstance(shape, Geometry)
    assert shape == cls(**example_arguments(cls))
    assert hash(shape) == hash(cls(**example_arguments(cls)))
    assert pickle.loads(pickle.dumps(shape)) == shape
    assert eval(repr(shape), dict(GEOMETRIES), {"inf": math.inf}) == shape
    assert {**GEOMETRIES}[cls.__name__] is getattr(mpm, cls.__name__)


# --- the algebra of combinations ---------------------------------------------------------------------------------

coordinate = st.floats(-1, 1, allow_nan=False).map(lambda v: round(v, 3))
length = st.floats(0.05, 1).map(lambda v: round(v, 3))
point = st.tuples(coordinate, coordinate)
boxes = st.builds(lambda p, a, b: mpm.Box(p, (p[0] + a, p[1] + b)), point, length, length)
disks = st.builds(mpm.Disk, point, length)
half_spaces = st.builds(lambda p, angle: mpm.HalfSpace(p, (math.cos(angle), math.sin(angle))), point, st.floats(0, 6.28))
triangles = st.builds(lambda p, a, b: mpm.Polygon([p, (p[0] + a, p[1]), (p[0], p[1] + b)]), point, length, length)
simple = st.one_of(boxes, disks, half_spaces, triangles)
turned = st.builds(lambda s, angle, move: mpm.Transformed(s, rotate=angle, translate=move), simple, st.floats(-360, 360), point)
shapes = st.one_of(simple, turned)
GRID = np.stack(np.meshgrid(np.linspace(-2, 2, 23), np.linspace(-2, 2, 23)), axis=-1).reshape(-1, 2) + 1e-4 * math.pi


def clear(*parts):
    """Points that lie on no surface."""
    return np.logical_and.reduce([np.abs(s.depth(GRID)) > 1e-9 for s in parts])


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])  # on a busy machine
@given(shapes, shapes, shapes)
def test_boolean_algebra(a, b, c):
    x = GRID[clear(a, b, c)]
    ina, inb, inc = a.contains(x), b.contains(x), c.contains(x)
    np.testing.assert_array_equal((a | b).contains(x), ina | inb)
    np.testing.assert_array_equal((a & b).contains(x), ina & inb)
    np.testing.assert_array_equal((a - b).contains(x), ina & ~inb)
    np.testing.assert_array_equal(mpm.Union(a, b, c).contains(x), ina | inb | inc)
    np.testing.assert_array_equal(mpm.Difference(a, b, c).contains(x), (a - (b | c)).contains(x))
    np.testing.assert_array_equal((a & (b | c)).contains(x), ((a & b) | (a & c)).contains(x))
    np.testing.assert_array_equal(((a - b) | (a & b)).contains(x), ina)
    for shape in (a | b, a & b, a - b):
        lower, upper = shape.bounds()
        inside = x[shape.contains(x)]
        assert ((inside >= np.array(lower) - 1e-12) & (inside <= np.array(upper) + 1e-12)).all()


@settings(max_examples=60, deadline=None)
@given(st.one_of(boxes, disks), st.one_of(boxes, disks))
def test_known_volumes_of_combinations_agree_with_each_other(a, b):
    """|a | b| + |a & b| = |a| + |b| and |a - b| = |a| - |a & b| where known. Tolerance: rounding, 1e-12 of the sizes."""
    both, cut, joined = (a & b).volume(), (a - b).volume(), (a | b).volume()
    total = a.volume() + b.volume()
    if both is not None and joined is not None:
        assert joined + both == pytest.approx(total, abs=1e-11)
    if both is not None and cut is not None:
        assert cut + both == pytest.approx(a.volume(), abs=1e-11)
    for shape, exact in (((a & b), both), ((a | b), joined), ((a - b), cut)):
        if exact is not None:  # an independent, coarse count
            assert abs(exact - subdivided_measure(shape, 5)) <= 0.08 * max(total, 0.1)


class TestPointCloud:
    def test_keeps_read_only_copies(self):
        x, V = np.array([(0.1, 0.2), (0.3, 0.4)]), np.array([1.0, 2.0])
        cloud = PointCloud(x, V)
        x[0, 0] = V[0] = 9.0
        assert cloud.x[0, 0] == 0.1
        assert cloud.V[0] == 1.0
        with pytest.raises(ValueError, match="read-only"):
            cloud.x[0, 0] = 1.0
        with pytest.raises(AttributeError):
            cloud.V = V

    def test_equality_and_hash(self):
        a, b, c = PointCloud([0.1, 0.2], 1.0), PointCloud([[0.1], [0.2]], [1.0, 1.0]), PointCloud([0.1, 0.3], 1.0)
        assert a == b
        assert hash(a) == hash(b)
        assert a != c
        assert a != PointCloud([0.1, 0.2], 1.0, 0.01)
        assert a != "cloud"

    def test_answers_like_a_shape(self):
        cloud = PointCloud([(0.0, 0.0), (1.0, 0.0)], 0.04)
        np.testing.assert_allclose(cloud.half_edges(), 0.1, rtol=4 * EPS)
        np.testing.assert_array_equal(cloud.contains([(0.05, 0.05), (0.2, 0.0), (1.1, 0.1)]), [True, False, True])
        assert cloud.volume() == 0.08
        assert cloud.bounds() == ((0.0, 0.0), (1.0, 0.0))

    @pytest.mark.parametrize(
        ("x", "V", "size", "message"),
        [
            ([[0.1, math.nan]], 1.0, None, r"x must be finite, got \[0.1, nan\] in row 0"),
            ([0.1, 0.2], [1.0, 0.0], None, r"V must be > 0, got 0 m\^3 in row 1"),
            ([0.1, 0.2], [1.0, -1.0], None, r"V must be > 0, got -1"),
            ([0.1, 0.2], [1.0], None, r"V must have the shape|could not be broadcast|shape"),
            ([], [], None, "n >= 1"),
            (np.zeros((2, 4)), 1.0, None, "must have the shape"),
            (np.zeros((2, 2, 2)), 1.0, None, "must have the shape"),
            ([0.1], 1.0, -1.0, "size must be > 0"),
            (["a"], 1.0, None, "x must be numbers"),
        ],
    )
    def test_refusals(self, x, V, size, message):
        with pytest.raises(mpm.ParameterError, match=message):
            PointCloud(x, V, size)
