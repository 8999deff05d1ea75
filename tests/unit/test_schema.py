"""The JSON Schema: valid itself, true to the declarations, and of one mind with the reader of scene files."""

import importlib.metadata
import json
import tomllib

import pytest

from mpmkit import scene
from mpmkit._core.registry import registry
from mpmkit.errors import SceneError
from mpmkit.geometry import GEOMETRIES
from mpmkit.parameters import specs
from mpmkit.scene.parts import LISTS, SECTIONS
from mpmkit.schema import schema

GOOD = """
until = "3.6 s"
[grid]
lower = [0, 0]
upper = [1, "100 cm"]
spacing = 0.05
[shape]
kind = "QuadraticBSpline"
[integrator]
kind = "MUSL"
transfer = { kind = "FLIP", blend = 0.9 }
dt = "1 us"
[materials.rubber]
kind = "NeoHookean"
E = "1 kPa"
nu = 0.3
rho = "1 g/cm^3"
[[bodies]]
geometry = { kind = "Union", shapes = [{ kind = "Disk", center = [0.2, 0.2], radius = 0.2 }] }
material = "rubber"
v = ["0.1*sin(x)", "10 cm/s"]
[[bodies]]
geometry = { kind = "Polygon", points = [[0.5, 0.5], [0.9, 0.5], [0.7, 0.9]] }
material = { kind = "VonMises", E = 1e6, nu = 0.3, rho = 1000, yield_stress = "10 kPa" }
particles_per_cell = 9
[[boundaries]]
kind = "Wall"
faces = "all"
[[effects]]
kind = "Gravity"
g = [0, "-9.81 m/s^2"]
[[records]]
path = "disks.vtkhdf"
every = "5 ms"
fields = ["x", "stress"]
"""


@pytest.fixture(scope="module")
def jsonschema():
    # Asked from the metadata: older versions, which some tools still require, cannot check draft 2020-12.
    if int(importlib.metadata.version("jsonschema").split(".")[0]) < 4:
        pytest.skip("draft 2020-12 needs jsonschema 4.23, which the extra 'test' installs")
    return importlib.import_module("jsonschema")


@pytest.fixture
def errors(jsonschema):
    """Function: text of a scene -> errors of the schema."""
    validator = jsonschema.Draft202012Validator(schema())
    return lambda text: [f"{e.json_path}: {e.message}" for e in validator.iter_errors(tomllib.loads(text))]


def test_the_schema_is_a_schema(jsonschema):
    jsonschema.Draft202012Validator.check_schema(schema())


def test_it_is_plain_json():
    assert json.loads(json.dumps(schema(), allow_nan=False)) == schema()


def test_good_scenes_are_valid(errors):
    scene.loads(GOOD)
    assert errors(GOOD) == []


def test_what_is_saved_is_valid(errors):
    assert errors(scene.dumps(scene.loads(GOOD))) == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("nu = 0.3\nrho", "nu = 0.5\nrho"),
        ("nu = 0.3\nrho", "nu = true\nrho"),
        ("nu = 0.3\nrho", 'nu = "0.3"\nrho'),
        ('rho = "1 g/cm^3"', ""),
        ('rho = "1 g/cm^3"', 'rho = "much"'),
        ('rho = "1 g/cm^3"', "rho = -1"),
        ('rho = "1 g/cm^3"', "rho = 1\nroh = 1"),
        ('"NeoHookean"', '"NeoHokean"'),
        ('kind = "Disk", ', ""),
        ("radius = 0.2", "radius = 0"),
        ("[grid]", "[grdi]"),
        ('until = "3.6 s"', "until = 0"),
        ('until = "3.6 s"', "colour = 1"),
        ('until = "3.6 s"', 'precision = "double"'),
        ("particles_per_cell = 9", "particles_per_cell = 2.5"),
        ("particles_per_cell = 9", 'lattice = "grdi"'),
        ("[[records]]", "[records]"),
        ('path = "disks.vtkhdf"', "path = 3"),
        ('transfer = { kind = "FLIP", blend = 0.9 }', 'transfer = { kind = "MUSL" }'),
        ('transfer = { kind = "FLIP", blend = 0.9 }', 'transfer = "FLIP"'),
        ('[shape]\nkind = "QuadraticBSpline"', ""),
        ('faces = "all"', 'faces = ["xmni"]'),
    ],
)
def test_bad_scenes_are_not_valid_and_cannot_be_loaded(errors, old, new):
    assert old in GOOD
    text = GOOD.replace(old, new, 1)
    assert errors(text)
    with pytest.raises(SceneError):
        scene.loads(text)


def test_every_component_and_parameter_is_there_with_its_unit():
    definitions = schema()["$defs"]
    for key, cls in {f"{e.kind}.{e.name}": e.component for e in registry().entries}.items() | {
        f"geometry.{n}": c for n, c in GEOMETRIES.items()
    }.items():
        entry = definitions[key]
        assert entry["properties"]["kind"]["const"] == cls.__name__
        for name, (_, spec) in specs(cls).items():
            assert entry["properties"][name]["description"].startswith(spec.doc)
            assert spec.unit == "1" or f"[{spec.unit}]" in entry["properties"][name]["description"]
    assert set(SECTIONS) | set(LISTS) < set(schema()["properties"])


def test_bounds_and_defaults():
    entry = schema()["$defs"]["material.NeoHookean"]["properties"]
    assert entry["nu"]["anyOf"][0] == {"type": "number", "exclusiveMinimum": -1, "exclusiveMaximum": 0.5}
    assert entry["form"]["enum"] == ["quadratic", "log"]
    assert entry["form"]["default"] == "quadratic"


def test_third_party_components_are_in_it(fakes):
    fakes.material("mpmkit-foam", "foam", "Foam")
    made = schema()
    assert "mpmkit-foam 1.0" in made["$defs"]["material.Foam"]["description"]
    assert "Foam" in made["$defs"]["material"]["properties"]["kind"]["enum"]
