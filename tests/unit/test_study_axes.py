from __future__ import annotations

import pytest
from small_study import EXACT, bar

import mpmkit as mpm
from mpmkit.materials import NeoHookean
from mpmkit.shapes import GIMP, Linear
from mpmkit.studies import Study, axes
from mpmkit.studies.paths import put


@pytest.mark.parametrize(
    ("path", "value", "where", "expected"),
    [
        ("grid.spacing", 0.25, ("grid", "spacing"), 0.25),
        ("shape", "GIMP", ("shape",), {"kind": "GIMP"}),
        ("integrator", "USL", ("integrator",), {"kind": "USL", "cfl": 0.5}),
        ("integrator", {"kind": "USL"}, ("integrator",), {"kind": "USL"}),
        ("integrator.transfer", "APIC", ("integrator", "transfer"), {"kind": "APIC"}),
        ("precision", "float32", ("precision",), "float32"),
        ("bodies.*.particles_per_cell", 4, ("bodies", 0, "particles_per_cell"), 4),
        ("bodies[0].particles_per_cell", 4, ("bodies", 0, "particles_per_cell"), 4),
        ("bodies.bar.geometry.upper[0]", 0.5, ("bodies", 0, "geometry", "upper"), [0.5]),
        ("bodies.bar.material.E", 2.0, ("bodies", 0, "material", "E"), 2.0),
        ("materials.elastic.E", 2.0, ("materials", "elastic", "E"), 2.0),
        ("boundaries.Wall.condition", "slip", ("boundaries", 0, "condition"), "slip"),
        ("contacts", "FrictionalContact", ("contacts",), [{"kind": "FrictionalContact"}]),
        ("boundaries", "none", ("boundaries",), []),
        ("discretization", "FEM", ("discretization",), {"kind": "FEM"}),
    ],
)
def test_a_path_sets_one_field(path, value, where, expected):
    data = bar()
    put(data, path, value)
    found = data
    for step in where:
        found = found[step]
    assert found == expected


def test_other_bodies_keep_their_material():
    data = bar()
    put(data, "bodies[0].material.E", 2.0)
    assert data["materials"]["elastic"]["E"] == 1.0


def test_another_discretization_needs_neither_shape_nor_integrator():
    data = bar()
    put(data, "discretization", "FEM")
    assert "shape" not in data and "integrator" not in data
    data = bar()
    put(data, "discretization", "MPM")
    assert data == bar()


def test_a_default_component_can_be_changed_inside():
    data = bar()
    put(data, "integrator.transfer", "XPIC")
    put(data, "integrator.transfer.order", 3)
    assert data["integrator"]["transfer"] == {"kind": "XPIC", "order": 3}


@pytest.mark.parametrize(
    ("path", "value", "message"),
    [
        ("gird.spacing", 0.1, "a scene has no 'gird'; did you mean 'grid'?"),
        ("grid.spacng", 0.1, "Grid has no field 'spacng'; did you mean 'spacing'?"),
        ("integrator.cf", 0.1, "MUSL has no field 'cf'; did you mean 'cfl'?"),
        ("bodies.bra.v", 0.1, r"no bodies\[bra\]; did you mean 'bar'?"),
        ("bodies[3].v", 0.1, r"no bodies\[3\]"),
        ("bodies[0].material.Ee", 0.1, "LinearElastic has no field 'Ee'; did you mean 'E'?"),
        ("materials.elastc.E", 0.1, "did you mean 'elastic'?"),
        ("shape", "Liner", "no shape named 'Liner' is registered; did you mean 'Linear'?"),
        ("until.x", 1.0, "'until' is a single value"),
        ("grid.spacing.x", 1.0, "Grid.spacing is a single value"),
        ("effects.Gravity.g", 1.0, r"no effects\[Gravity\] \(it has no effects\)"),
        ("grid..spacing", 1.0, "is no path into a scene"),
    ],
)
def test_unknown_fields_are_named_with_the_nearest_one(path, value, message):
    with pytest.raises(mpm.MpmkitError, match=message):
        put(bar(), path, value)
    with pytest.raises(mpm.MpmkitError, match=message):
        Study(bar(), {path: [value]}, errors=EXACT).plan()


def test_an_axis_is_wrong_only_if_it_fits_no_combination():
    study = Study(bar(), {"integrator.transfer": ["PIC", "XPIC"], "integrator.transfer.order": [2, 3]}, errors=EXACT)
    assert [run.status for run in study.plan()] == ["refused", "refused", "planned", "planned"]
    assert "PIC has no field 'order'" in study.plan()[0].reason


def test_fields_that_vary_together_are_one_axis():
    found = axes.read({"size": {"grid.spacing": [0.1, 0.05], "integrator.dt": [0.01, 0.005]}})
    assert found[0].paths == ("grid.spacing", "integrator.dt")
    assert found[0].values == ((0.1, 0.01), (0.05, 0.005))
    assert found[0].labels == ("0.1", "0.05")
    named = axes.read({"size": {"grid.spacing": [0.1, 0.05], "labels": ["coarse", "fine"]}})
    assert named[0].labels == ("coarse", "fine")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"shape": []}, "axis 'shape' is empty, so there is nothing to run"),
        ({"shape": "Linear"}, "axis 'shape' must be a list of values"),
        ({"shape": ["Linear", "Linear"]}, "axis 'shape' has the value Linear twice"),
        ({"size": {"a": [1, 2], "b": [1]}}, "must have equal lengths, got a: 2, b: 1"),
        ({"size": {}}, "must have equal lengths, got no lists"),
        ({"a": [1], "b": {"a": [2]}}, "'a' is varied by two axes"),
    ],
)
def test_axes_that_cannot_be(given, message):
    with pytest.raises(mpm.ParameterError, match=message):
        axes.read(given)


def test_components_may_be_objects_names_and_tables():
    found = axes.read({"shape": [Linear(), GIMP(), "QuadraticBSpline"], "material": [NeoHookean(E=1.0, nu=0.3, rho=1.0)]})
    assert found[0].labels == ("Linear", "GIMP", "QuadraticBSpline")
    assert found[1].values[0][0] == {"kind": "NeoHookean", "E": 1.0, "nu": 0.3, "rho": 1.0}


def test_equal_kinds_are_told_apart_by_their_parameters():
    (axis,) = axes.read({"t": [{"kind": "XPIC", "order": 2}, {"kind": "XPIC", "order": 3}]})
    assert axis.labels == ("XPIC(order=2)", "XPIC(order=3)")


def test_labels_of_runs_and_compositions():
    study = Study(bar(), {"shape": ["Linear", "GIMP"], "grid.spacing": [0.25, 0.125], "integrator.cfl": [0.5]}, errors=EXACT)
    runs = study.plan()
    assert runs[1].label == "Linear, spacing=0.125, cfl=0.5"
    assert runs[1].composition == "Linear, cfl=0.5"
    assert [run.resolution for run in runs] == [0.25, 0.125] * 2
    assert [run.particles for run in runs] == [4, 8] * 2
