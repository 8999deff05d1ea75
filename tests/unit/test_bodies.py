"""Filling shapes with particles, and the state they start in."""

import math
import pickle

import numpy as np
import pytest

import mpmkit as mpm
from mpmkit.bodies import Points, overlapping
from mpmkit.interfaces import ConstitutiveModel

EPS = np.finfo(float).eps
IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@mpm.define
class Stuff(ConstitutiveModel):
    """A material that only has a density."""

    rho: float = mpm.parameter("density", unit="kg/m^3", gt=0, example=1000.0)


STUFF = Stuff(1000.0)
LINE, PLANE, SPACE = mpm.Grid(0, 1, 0.1), mpm.Grid((0, 0), (1, 1), 0.1), mpm.Grid((0, 0, 0), (1, 1, 1), 0.25)
RINGS = mpm.Grid((0, 0), (1, 1), 0.1, "axisymmetric")


class TestLattice:
    @pytest.mark.parametrize(("grid", "side"), [(LINE, 1), (LINE, 3), (PLANE, 1), (PLANE, 2), (PLANE, 4), (SPACE, 2), (SPACE, 3)])
    def test_full_cells_hold_the_number_asked_for(self, grid, side):
        """Tolerance: rounding, 4 n eps of the volume for a sum of n terms."""
        box = mpm.Box((0.0,) * grid.dim, (0.5,) * grid.dim)
        points = mpm.Body(box, STUFF, particles_per_cell=side**grid.dim).sample(grid)
        cells = round(0.5 / grid.h) ** grid.dim
        assert points.n == cells * side**grid.dim
        assert points.V0.sum() == pytest.approx(0.5**grid.dim, rel=4 * points.n * EPS)
        assert (points.size == 0.5 * grid.h / side).all()

    def test_default_is_two_in_each_direction(self):
        box = mpm.Box((0, 0), (0.2, 0.1))
        points = mpm.Body(box, STUFF).sample(PLANE)
        expected = [(x, y) for x in (0.025, 0.075, 0.125, 0.175) for y in (0.025, 0.075)]
        np.testing.assert_allclose(points.x, expected, rtol=0, atol=2 * EPS)

    def test_grid_lattice_divides_cells_wherever_the_body_lies(self):
        grid = mpm.Grid((-0.35, 0.1), (0.65, 1.1), 0.1)
        points = mpm.Body(mpm.Disk((0.1, 0.6), 0.3), STUFF, particles_per_cell=9).sample(grid)
        part = (points.x - grid.lower) / (0.1 / 3) - 0.5
        assert np.abs(part - np.round(part)).max() < 1e-12  # rounding, in lattice spacings
        assert ((points.x - (0.1, 0.6)) ** 2).sum(axis=1).max() <= 0.09 * (1 + 1e-12)

    def test_body_lattice_fits_a_whole_number(self):
        """Tolerance: rounding, 10 eps."""
        points = mpm.Body(mpm.Box((0.13, 0.2), (0.36, 0.5)), STUFF, lattice="body").sample(PLANE)
        np.testing.assert_allclose(2 * points.size[0], (0.23 / 5, 0.05), rtol=10 * EPS)
        np.testing.assert_allclose(points.x.min(axis=0) - points.size[0], (0.13, 0.2), rtol=10 * EPS)
        np.testing.assert_allclose(points.x.max(axis=0) + points.size[0], (0.36, 0.5), rtol=10 * EPS)
        assert points.V0.sum() == pytest.approx(0.23 * 0.3, rel=4 * points.n * EPS)

    def test_no_point_is_lost_or_doubled_between_touching_bodies(self):
        for n in (7, 10, 30):
            grid = mpm.Grid((0, 0), (0.7, 0.7), 0.7 / n)
            cut = 0.7 / n * (n // 2)
            left = mpm.Body(mpm.Box((0, 0), (cut, 0.7)), STUFF).sample(grid)
            right = mpm.Body(mpm.Box((cut, 0), (0.7, 0.7)), STUFF).sample(grid)
            assert left.n + right.n == 4 * n * n

    def test_half_space_ends_at_the_domain(self):
        points = mpm.Body(mpm.HalfSpace((0, 0.35), (0, 1)), STUFF).sample(PLANE)
        assert points.n == 20 * 7
        assert points.x[:, 1].max() < 0.35

    def test_many_points_are_made_slab_by_slab(self, monkeypatch):
        from mpmkit._core import sampling

        whole = mpm.Body(mpm.Sphere((0.5, 0.5, 0.5), 0.4), STUFF).sample(SPACE)
        monkeypatch.setattr(sampling, "_CHUNK", 10)
        np.testing.assert_array_equal(mpm.Body(mpm.Sphere((0.5, 0.5, 0.5), 0.4), STUFF).sample(SPACE).x, whole.x)

    def test_sampled_volume_converges(self):
        """Rate: root mean square error over thirty positions of a disk at four spacings; theory says h^1.5."""
        centers = np.random.default_rng(7).uniform(0.4, 0.6, (30, 2))
        errors = []
        for n in (10, 20, 40, 80):
            grid = mpm.Grid((0, 0), (1, 1), 1 / n)
            volumes = [mpm.Body(mpm.Disk(c, 0.3), STUFF).sample(grid).V0.sum() for c in centers]
            errors.append(np.sqrt(np.mean((np.array(volumes) - 0.09 * math.pi) ** 2)))
        order = np.polyfit(np.log([10, 20, 40, 80]), -np.log(errors), 1)[0]
        assert 1.3 < order < 1.7

    @pytest.mark.parametrize(
        ("dim", "given", "near"), [(1, 0, "must be >= 1"), (2, 3, "1 and 4"), (2, 5, "4 and 9"), (3, 9, "8 and 27"), (3, 20, "8 and 27")]
    )
    def test_wrong_number_names_the_nearest(self, dim, given, near):
        with pytest.raises(mpm.ParameterError, match=near):
            mpm.Body(mpm.Box((0,) * dim, (1,) * dim), STUFF, particles_per_cell=given)


class TestVolumes:
    def test_ring_volumes_are_exact(self):
        """Rings of rectangular section: pi (r1^2 - r0^2) dz each. Tolerance: rounding, 10 eps each, n eps for the sum."""
        points = mpm.Body(mpm.Box((0, 0.2), (0.5, 0.6)), STUFF).sample(RINGS)
        r, (a, b) = points.x[:, 0], points.size[0]
        np.testing.assert_allclose(points.V0, math.pi * ((r + a) ** 2 - (r - a) ** 2) * 2 * b, rtol=10 * EPS)
        assert points.V0.sum() == pytest.approx(math.pi * 0.25 * 0.4, rel=points.n * EPS)

    @pytest.mark.parametrize(
        ("shape", "grid", "exact"),
        [
            (mpm.Box(0.03, 0.77), LINE, 0.74),
            (mpm.Disk((0.5, 0.5), 0.33), PLANE, math.pi * 0.33**2),
            (mpm.Sphere((0.5, 0.5, 0.5), 0.4), SPACE, 4 / 3 * math.pi * 0.4**3),
            (mpm.Disk((0.5, 0.5), 0.2), RINGS, 2 * math.pi**2 * 0.5 * 0.2**2),  # a torus
            (mpm.Box((0.15, 0.15), (0.62, 0.62)), RINGS, math.pi * (0.62**2 - 0.15**2) * 0.47),
            (mpm.Disk((0.5, 0.5), 0.4) - mpm.Disk((0.5, 0.5), 0.3), PLANE, math.pi * 0.07),
        ],
    )
    @pytest.mark.parametrize("lattice", ["grid", "body"])
    def test_exact_volume_on_request(self, shape, grid, exact, lattice):
        """Tolerance: rounding, n eps for a sum of n terms."""
        points = mpm.Body(shape, STUFF, lattice=lattice, conserve="volume").sample(grid)
        assert points.V0.sum() == pytest.approx(exact, rel=max(points.n, 20) * EPS)
        plain = mpm.Body(shape, STUFF, lattice=lattice).sample(grid)
        np.testing.assert_array_equal(points.x, plain.x)
        np.testing.assert_allclose(points.V0 / plain.V0, exact / plain.V0.sum(), rtol=points.n * EPS)

    def test_shape_of_unknown_volume_is_refused(self):
        body = mpm.Body(mpm.Disk((0.4, 0.5), 0.2) & mpm.Disk((0.6, 0.5), 0.2), STUFF, conserve="volume", name="lens")
        with pytest.raises(mpm.ParameterError, match="body 'lens': conserve='volume' needs a shape whose exact volume is known"):
            body.sample(PLANE)


class TestPlace:
    @pytest.mark.parametrize("lattice", ["grid", "body"])
    def test_outside_the_domain(self, lattice):
        body = mpm.Body(mpm.Disk((0.9, 0.5), 0.2), STUFF, lattice=lattice, name="ball")
        with pytest.raises(
            mpm.CompositionError,
            match=r"body 'ball' reaches from \(0.7, 0.3\) to \(1.1, 0.7\) m, outside the domain from \(0, 0\) to \(1, 1\)",
        ):
            body.sample(PLANE)

    def test_turned_shape_is_judged_by_its_particles(self):
        inside = mpm.Transformed(mpm.Disk((0.5, 0.5), 0.45), rotate=45, about=(0.5, 0.5))  # whose bounds are too wide
        assert mpm.Body(inside, STUFF).sample(PLANE).n > 200
        outside = mpm.Transformed(mpm.Box((0.1, 0.4), (1.2, 0.6)), rotate=5)
        with pytest.raises(mpm.CompositionError, match=r"\d+ of \d+ particles lie outside the domain.*for example at \(1\.0"):
            mpm.Body(outside, STUFF).sample(PLANE)

    def test_faces_of_the_domain_are_inside(self):
        assert mpm.Body(mpm.Box((0, 0), (1, 1)), STUFF).sample(PLANE).n == 400

    def test_too_small_for_a_particle(self):
        body = mpm.Body(mpm.Disk((0.5, 0.5), 0.01), STUFF)
        with pytest.raises(
            mpm.CompositionError,
            match=r"body of Disk and Stuff: no particle.*\(0.49, 0.49\) to \(0.51, 0.51\).*spacing of \(0.05, 0.05\).*lattice='body'",
        ):
            body.sample(PLANE)
        assert mpm.Body(mpm.Disk((0.5, 0.5), 0.01), STUFF, lattice="body").sample(PLANE).n == 1

    def test_empty_shape(self):
        for lattice in ("grid", "body"):
            with pytest.raises(mpm.CompositionError, match="no particle"):
                mpm.Body(mpm.Box((0, 0), (0.2, 0.2)) & mpm.Disk((0.8, 0.8), 0.1), STUFF, lattice=lattice).sample(PLANE)

    def test_wrong_dimension(self):
        with pytest.raises(mpm.CompositionError, match="has 2 dimensions, the grid has 3"):
            mpm.Body(mpm.Disk((0.5, 0.5), 0.1), STUFF).sample(SPACE)


class TestState:
    BOX = mpm.Box((0, 0), (0.2, 0.2))

    def test_at_rest_without_a_word(self):
        points = mpm.Body(self.BOX, STUFF).sample(PLANE)
        assert (points.v == 0.0).all()
        assert points.v.shape == points.x.shape
        assert points.F is None
        assert points.stress is None

    @pytest.mark.parametrize(
        "v",
        [
            (1, -2),
            [1, -2],
            np.array([1.0, -2.0]),
            ("1 m/s", "-200 cm/s"),
            ("0.5*2", -2),
            lambda x: (1, -2),
            lambda x: np.tile((1.0, -2.0), (len(x), 1)),
        ],
    )
    def test_ways_to_say_a_constant_velocity(self, v):
        np.testing.assert_allclose(mpm.Body(self.BOX, STUFF, v).sample(PLANE).v, np.tile((1.0, -2.0), (16, 1)), rtol=4 * EPS)

    def test_velocity_as_a_function_is_called_once(self):
        calls = []

        def spin(x):
            calls.append(x.shape)
            return np.stack((-x[:, 1], x[:, 0]), axis=1)

        points = mpm.Body(self.BOX, STUFF, spin).sample(PLANE)
        assert calls == [(16, 2)]
        formula = mpm.Body(self.BOX, STUFF, ("-y", "X")).sample(PLANE)
        np.testing.assert_array_equal(points.v, formula.v)
        np.testing.assert_array_equal(points.v, np.stack((-points.x[:, 1], points.x[:, 0]), axis=1))

    def test_one_dimension(self):
        bar = mpm.Box(0, 1)
        for v in (0.1, (0.1,), "0.1", "10 cm/s", lambda x: 0.1, lambda x: np.full(len(x), 0.1), lambda x: np.full((len(x), 1), 0.1)):
            np.testing.assert_allclose(mpm.Body(bar, STUFF, v).sample(LINE).v, np.full((20, 1), 0.1), rtol=4 * EPS)
        points = mpm.Body(bar, STUFF, "sin(pi*x)").sample(LINE)
        np.testing.assert_allclose(points.v, np.sin(np.pi * points.x), rtol=4 * EPS)

    def test_initial_stress_and_deformation(self):
        points = mpm.Body(self.BOX, STUFF, stress=("1 kPa", 0, 0, "x*1e3", 0, 0), F=((1.1, 0, 0), (0, 1, 0), (0, 0, 1))).sample(PLANE)
        assert points.stress.shape == (16, 6)
        np.testing.assert_array_equal(points.stress[:, 0], 1000.0)
        np.testing.assert_array_equal(points.stress[:, 3], points.x[:, 0] * 1e3)
        np.testing.assert_array_equal(points.F, np.tile(np.diag((1.1, 1.0, 1.0)), (16, 1, 1)))
        by_function = mpm.Body(self.BOX, STUFF, F=lambda x: np.diag((1.1, 1, 1)), stress=lambda x: np.zeros((len(x), 6))).sample(PLANE)
        np.testing.assert_array_equal(by_function.F, points.F)
        flat = mpm.Body(self.BOX, STUFF, F=(1.1, 0, 0, 0, 1, 0, 0, 0, 1))
        np.testing.assert_array_equal(flat.sample(PLANE).F, points.F)
        assert flat.F == ((1.1, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))

    @pytest.mark.parametrize(
        ("state", "message"),
        [
            ({"v": (1, 2, 3)}, r"Body.v must be 2 numbers for a body in 2D, got \(1.0, 2.0, 3.0\)"),
            ({"v": 1.0}, "Body.v must be 2 numbers"),
            ({"v": ("x",)}, "must be 2 formulas or numbers"),
            ({"v": ("x", "z")}, "unknown name 'z'"),
            ({"v": ("x", "t")}, "unknown name 't'"),
            ({"v": (1, "2 kg")}, "not a quantity in m/s"),
            ({"v": (1, float("nan"))}, "got nan"),
            ({"v": np.zeros((3, 3))}, "Body.v must be 2 numbers"),
            ({"F": (1, 2)}, "Body.F must be 3 x 3 numbers"),
            ({"F": np.full((3, 3), math.nan)}, "Body.F must be finite"),
            ({"stress": (1, 2, 3)}, "Body.stress must be 6 numbers"),
            ({"stress": "1 kPa"}, "Body.stress must be"),
            ({"stress": ("1 kg", 0, 0, 0, 0, 0)}, "not a quantity in Pa"),
            ({"name": " "}, "Body.name must not be empty"),
            ({"lattice": "hexagonal"}, "one of 'grid', 'body'"),
            ({"conserve": "mass"}, "one of 'none', 'volume'"),
            ({"particles_per_cell": 4.0}, "whole number"),
        ],
    )
    def test_mistakes_are_found_when_the_body_is_made(self, state, message):
        with pytest.raises(mpm.ParameterError, match=message):
            mpm.Body(self.BOX, STUFF, **state)

    @pytest.mark.parametrize(
        ("state", "message"),
        [
            ({"v": lambda x: np.zeros((len(x), 3))}, r"the function returned the shape \(16, 3\); it must return \(16, 2\) or \(2,\)"),
            ({"v": lambda x: np.where(x > 0.1, np.nan, x)}, "v must be finite, got .* at x = .*particles"),
            ({"v": ("1/(x - 0.025)", 0)}, "v must be finite"),
            ({"F": -np.eye(3)}, "determinant > 0, got -1 at particle 0"),
            ({"F": np.zeros((5, 3, 3))}, "5 rows were given for 16 particles"),
        ],
    )
    def test_mistakes_that_need_the_positions(self, state, message):
        with pytest.raises(mpm.ParameterError, match=f"body 'wheel'.*{message}"):
            mpm.Body(self.BOX, STUFF, name="wheel", **state).sample(PLANE)

    def test_wrong_kinds(self):
        with pytest.raises(mpm.ParameterError, match="Body.material must be a ConstitutiveModel"):
            mpm.Body(self.BOX, 1000.0)
        with pytest.raises(mpm.ParameterError, match="Body.geometry must be a Geometry"):
            mpm.Body("disk", STUFF)


class TestFromArrays:
    def test_positions_volumes_and_sizes(self):
        x = np.array([(0.1, 0.2), (0.3, 0.4)])
        points = mpm.Body.from_arrays(x, [0.01, 0.04], STUFF, v=[(1, 2), (3, 4)], name="dust").sample(PLANE)
        np.testing.assert_array_equal(points.x, x)
        np.testing.assert_array_equal(points.V0, [0.01, 0.04])
        np.testing.assert_array_equal(points.v, [(1, 2), (3, 4)])
        np.testing.assert_allclose(points.size, [(0.05, 0.05), (0.1, 0.1)], rtol=4 * EPS)
        given = mpm.Body.from_arrays(x, 0.01, STUFF, size=(0.02, 0.125)).sample(PLANE)
        np.testing.assert_array_equal(given.size, [(0.02, 0.125)] * 2)

    def test_one_dimension(self):
        points = mpm.Body.from_arrays([0.1, 0.2, 0.3], 0.1, STUFF, v=[1, 2, 3]).sample(LINE)
        np.testing.assert_array_equal(points.v, [[1], [2], [3]])
        np.testing.assert_array_equal(points.x, [[0.1], [0.2], [0.3]])

    def test_rings(self):
        """Tolerance: rounding, 10 eps."""
        points = mpm.Body.from_arrays([(0.5, 0.5)], 2 * math.pi * 0.5 * 0.01, STUFF).sample(RINGS)
        np.testing.assert_allclose(points.size, 0.05, rtol=10 * EPS)
        with pytest.raises(mpm.CompositionError, match="particle 0 lies on the axis"):
            mpm.Body.from_arrays([(0.0, 0.5)], 1.0, STUFF).sample(RINGS)

    def test_a_sampled_body_can_be_made_again(self):
        first = mpm.Body(mpm.Disk((0.5, 0.5), 0.3), STUFF, ("y", "x"), stress=("x", 0, 0, 0, 0, 0)).sample(PLANE)
        again = mpm.Body.from_arrays(first.x, first.V0, STUFF, first.v, stress=first.stress, size=first.size).sample(PLANE)
        for field in ("x", "V0", "v", "size", "stress"):
            np.testing.assert_array_equal(getattr(again, field), getattr(first, field))

    def test_equality_does_not_choke_on_arrays(self):
        def make(last):
            return mpm.Body.from_arrays([0.1, last], 0.1, STUFF, v=[1, 2], stress=np.zeros((2, 6)))

        assert make(0.2) == make(0.2)
        assert hash(make(0.2)) == hash(make(0.2))
        assert make(0.2) != make(0.3)
        assert make(0.2) != mpm.Body(mpm.Box(0, 1), STUFF)
        assert make(0.2) != 3
        assert pickle.loads(pickle.dumps(make(0.2))) == make(0.2)

    def test_arrays_are_copies_that_cannot_be_written(self):
        x, v = np.array([[0.1], [0.2]]), np.array([[1.0], [2.0]])
        body = mpm.Body.from_arrays(x, 0.1, STUFF, v=v)
        x[:], v[:] = 9.0, 9.0
        points = body.sample(LINE)
        assert points.x.max() == 0.2
        assert points.v.max() == 2.0
        for array in (body.v, body.geometry.x):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1.0

    @pytest.mark.parametrize(
        ("arguments", "message"),
        [
            ({"x": [0.1, math.inf], "V": 1.0}, "x must be finite.*row 1"),
            ({"x": [0.1, 0.2], "V": [1.0, 0.0]}, "V must be > 0, got 0 m.*row 1"),
            ({"x": [0.1, 0.2], "V": [1.0, -2.0]}, "V must be > 0, got -2"),
            ({"x": [0.1, 0.2], "V": [1.0, 2.0, 3.0]}, "V must have the shape"),
            ({"x": [0.1, 0.2], "V": 1.0, "v": [1.0, 2.0, 3.0]}, "Body.v must be 1 number, or 2 rows"),
            ({"x": [0.1, 0.2], "V": 1.0, "stress": np.zeros((3, 6))}, "Body.stress must be 6 numbers, or 2 rows"),
        ],
    )
    def test_refusals(self, arguments, message):
        with pytest.raises(mpm.ParameterError, match=message):
            mpm.Body.from_arrays(material=STUFF, **arguments)

    def test_outside_the_domain(self):
        body = mpm.Body.from_arrays([0.5, 1.5], 0.1, STUFF, name="dust")
        with pytest.raises(mpm.CompositionError, match=r"body 'dust': 1 of 2 particles lie outside the domain.*particle 1 at \(1.5,\)"):
            body.sample(LINE)

    def test_options_of_a_lattice_have_no_meaning(self):
        from mpmkit.geometry import PointCloud

        for option in ({"particles_per_cell": 2}, {"lattice": "body"}, {"conserve": "volume"}):
            with pytest.raises(mpm.ParameterError, match=f"Body.{next(iter(option))} has no meaning"):
                mpm.Body(PointCloud([0.1], 1.0), STUFF, **option)


class TestOverlapping:
    def sample(self, shape, grid=PLANE, **options) -> Points:
        return mpm.Body(shape, STUFF, **options).sample(grid)

    def test_touching_bodies_do_not_overlap(self):
        left, right = self.sample(mpm.Box((0, 0), (0.5, 1))), self.sample(mpm.Box((0.5, 0), (1, 1)))
        assert len(overlapping(left, right)) == 0
        fine = self.sample(mpm.Box((0.5, 0), (1, 1)), particles_per_cell=25)
        assert len(overlapping(left, fine)) == len(overlapping(fine, left)) == 0
        one, two = self.sample(mpm.Disk((0.3, 0.5), 0.2)), self.sample(mpm.Disk((0.7, 0.5), 0.2))
        assert len(overlapping(one, two)) == 0

    def test_overlapping_bodies_are_found(self):
        left, right = self.sample(mpm.Box((0, 0), (0.6, 1))), self.sample(mpm.Box((0.5, 0), (1, 1)))
        found = overlapping(left, right)
        np.testing.assert_array_equal(found, np.flatnonzero(left.x[:, 0] > 0.5))

    @pytest.mark.parametrize("shift", [0.0, 0.0125, 0.025, 0.04])
    def test_lattices_need_not_match(self, shift):
        left = self.sample(mpm.Box((0, 0), (0.6, 1)))
        right = self.sample(mpm.Box((0.45 + shift, 0.025), (0.95 + shift, 0.925)), lattice="body")
        found = left.x[overlapping(left, right)]
        assert len(found) >= 10
        assert (found[:, 0] > 0.45 + shift - 0.05).all()

    def test_sizes_may_differ_within_a_body(self):
        a = mpm.Body.from_arrays([0.58], 0.02, STUFF).sample(LINE)
        b = mpm.Body.from_arrays([0.56, 0.3, 0.65], [0.01, 0.01, 0.3], STUFF).sample(LINE)
        assert len(overlapping(a, b)) == 1  # not with the nearest, which is small, but with the large one
        assert len(overlapping(a, mpm.Body.from_arrays([0.56], 0.01, STUFF).sample(LINE))) == 0
