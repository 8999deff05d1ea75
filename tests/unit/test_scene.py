"""Scene files: the same classes as in scripts, every mistake at once with its path, and text -> simulation -> text."""

import json
import os
import re

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mpmkit as mpm
from mpmkit import scene
from mpmkit._core.registry import registry
from mpmkit.boundaries import PrescribedVelocity, Wall
from mpmkit.contacts import FrictionalContact
from mpmkit.effects import BodyForce, Gravity
from mpmkit.errors import SceneError
from mpmkit.geometry import GEOMETRIES, PointCloud
from mpmkit.integrators import APIC, MUSL
from mpmkit.materials import LinearElastic, NeoHookean
from mpmkit.parameters import example_arguments, specs
from mpmkit.shapes import Linear, QuadraticBSpline

PARTS = ("grid", "shape", "integrator", "discretization", "precision", "until", "bodies", "boundaries", "contacts", "effects", "records")

GOOD = """
until = "3600 ms"
precision = "float32"

[grid]
lower = [0, "0 mm"]
upper = ["100 cm", 1.0]
spacing = "5 cm"

[shape]
kind = "QuadraticBSpline"

[integrator]
kind = "MUSL"
transfer = { kind = "APIC" }
cfl = 0.3

[materials.rubber]
kind = "NeoHookean"
E = "1 kPa"
nu = 0.3
rho = "1 g/cm^3"

[[bodies]]
name = "left"
geometry = { kind = "Disk", center = [0.2, 0.2], radius = 0.2 }
material = "rubber"
v = ["10 cm/s", 0.1]

[[bodies]]
geometry.kind = "Union"
geometry.shapes = [
  { kind = "Disk", center = [0.8, 0.8], radius = 0.1 },
  { kind = "Transformed", shape = { kind = "Box", lower = [0, 0], upper = [0.1, 0.1] }, rotate = "30 deg", translate = [0.6, 0.6] },
]
material = { kind = "LinearElastic", E = 1e6, nu = 0, rho = 1000 }
v = ["-0.1*sin(x)", 0]

[[boundaries]]
kind = "Wall"
faces = "all"
friction = 0.2

[[contacts]]
kind = "FrictionalContact"

[[effects]]
kind = "BodyForce"
value = [0, "9.81*cos(t)"]

[[records]]
path = "disks.vtkhdf"
every = "50 ms"
fields = ["x", "v"]
"""


def same(a, b):
    return all(getattr(a, name) == getattr(b, name) for name in PARTS)


def disks():
    rubber = NeoHookean(E=1000.0, nu=0.3, rho=1000.0)
    left = mpm.Body(mpm.Disk(center=(0.2, 0.2), radius=0.2), rubber, v=(0.1, 0.1))
    right = mpm.Body(mpm.Disk(center=(0.8, 0.8), radius=0.2), rubber, v=(-0.1, -0.1), particles_per_cell=9)
    sim = mpm.Simulation(mpm.Grid((0, 0), (1, 1), 1 / 20), shape=QuadraticBSpline(), integrator=MUSL(APIC(), cfl=0.3), until=3.6)
    sim += left, right, Wall("all"), FrictionalContact(), mpm.Record("disks.vtkhdf", every=0.05)
    return sim


def mistakes(text, **kwargs):
    with pytest.raises(SceneError) as error:
        scene.loads(text, **kwargs)
    assert str(error.value).splitlines()[0].endswith((f"{len(error.value.mistakes)} mistakes", "1 mistake"))
    return list(error.value.mistakes)


def only_mistake(text):
    found = mistakes(text)
    assert len(found) == 1, found
    return found[0]


# --- reading what is right ------------------------------------------------------------------------------------------
def test_a_file_gives_the_objects_of_a_script():
    sim = scene.loads(GOOD)
    rubber = NeoHookean(E=1000.0, nu=0.3, rho=sim.bodies[0].material.rho)
    assert rubber.rho == pytest.approx(1000.0, rel=4 * np.finfo(float).eps)  # rounding of the unit's factor
    assert (sim.until, sim.precision) == (3.6, "float32")
    assert sim.grid == mpm.Grid((0, 0), (1, 1), 0.05)
    assert (sim.shape, sim.integrator) == (QuadraticBSpline(), MUSL(APIC(), cfl=0.3))
    box = mpm.Transformed(mpm.Box((0, 0), (0.1, 0.1)), rotate=30, translate=(0.6, 0.6))
    assert sim.bodies == [
        mpm.Body(mpm.Disk((0.2, 0.2), 0.2), rubber, v=(0.1, 0.1), name="left"),
        mpm.Body(mpm.Union(mpm.Disk((0.8, 0.8), 0.1), box), LinearElastic(E=1e6, nu=0.0, rho=1000.0), v=("-0.1*sin(x)", 0.0)),
    ]
    assert sim.boundaries == [Wall("all", friction=0.2)]
    assert sim.contacts == [FrictionalContact()]
    assert sim.effects == [BodyForce((0.0, "9.81*cos(t)"))]
    assert sim.records == [mpm.Record("disks.vtkhdf", every=0.05, fields=("x", "v"))]


def test_bodies_share_a_named_material():
    text = GOOD + '[[bodies]]\ngeometry = { kind = "Disk", center = [0.5, 0.2], radius = 0.05 }\nmaterial = "rubber"\n'
    sim = scene.loads(text)
    assert sim.bodies[0].material is sim.bodies[2].material


def test_json(tmp_path):
    import tomllib

    path = tmp_path / "disks.json"
    path.write_text(json.dumps({"$schema": "scene.schema.json", **tomllib.loads(GOOD)}))
    assert same(scene.load(path), scene.loads(GOOD))


def test_a_plugin_s_component_is_named_like_ours(fakes):
    fakes.material("mpmkit-foam", "foam", "Foam")
    text = re.sub(r'kind = "NeoHookean"\nE = .*\nnu = .*', 'kind = "Foam"', GOOD)
    assert type(scene.loads(text).bodies[0].material).__module__ == "foam"


# --- mistakes -------------------------------------------------------------------------------------------------------
def test_all_mistakes_at_once_with_path_value_range_unit_and_nearest_name():
    text = """
until = "3 kg"
precision = "flaot64"
colour = 1
[grid]
lower = [0, "1 kg"]
upper = true
spacing = -1
[shape]
kind = "QuadraticSpline"
[integrator]
kind = "MUSL"
transfer = { kind = "APCI" }
[materials.rubber]
kind = "NeoHookean"
E = "200 GPs"
nu = 0.5
roh = 3
[[bodies]]
geometry = { kind = "Dsk", center = [0, 0], radius = 1 }
material = "ruber"
[[bodies]]
geometry = { kind = "Union", shapes = [{ kind = "Disk", center = [0, 0], radius = "x" }, { center = 1 }, 3] }
material = { kind = "QuadraticBSpline" }
v = ["sin(", "4 s"]
lattice = "grdi"
particles_per_cell = "4"
[[boundaries]]
kind = "Wall"
faces = ["xmni"]
[[records]]
path = 3
every = nan
fields = ["x", 1]
"""
    found = mistakes(text)
    expected = {
        "scene.until": "'3 kg' is not a quantity in s",
        "scene.precision": "must be one of 'float64', 'float32', got 'flaot64'; did you mean 'float64'?",
        "scene.colour": "unknown key 'colour'",
        "scene.grid.lower[1]": "'1 kg' is not a quantity in m",
        "scene.grid.upper[0]": "must be a number [m], got True",
        "scene.grid.spacing[0]": "must be > 0, got -1",
        "scene.shape.kind": "no shape named 'QuadraticSpline' is registered; did you mean 'QuadraticBSpline'?",
        "scene.integrator.transfer.kind": "no transfer named 'APCI' is registered; did you mean 'APIC'?",
        "scene.materials.rubber.E": "unknown unit 'GPs'; did you mean 'GPa'?",
        "scene.materials.rubber.nu": "must be > -1, < 0.5, got 0.5 (Poisson's ratio",
        "scene.materials.rubber.roh": "unknown key 'roh'; did you mean 'rho'?",
        "scene.materials.rubber": "required key 'rho' is missing (reference density [kg/m^3], > 0",
        "scene.bodies[0].geometry.kind": "no geometry named 'Dsk'; did you mean 'Disk'?",
        "scene.bodies[0].material": "no material is named 'ruber' in [materials]; did you mean 'rubber'?",
        "scene.bodies[1].geometry.shapes[0].radius": "must be a number with a unit, such as '2.5 m', got 'x'",
        "scene.bodies[1].geometry.shapes[1]": "required key 'kind' is missing; one of Box, ",
        "scene.bodies[1].geometry.shapes[2]": 'must be a table such as { kind = "Box" }, got 3',
        "scene.bodies[1].material.kind": "'QuadraticBSpline' is a component of kind shape, here a material is wanted",
        "scene.bodies[1].v[0]": "sin(",
        "scene.bodies[1].lattice": "must be one of 'grid', 'body', got 'grdi'; did you mean 'grid'?",
        "scene.bodies[1].particles_per_cell": "must be a whole number, got '4'",
        "scene.boundaries[0].faces[0]": "got 'xmni'; did you mean 'xmin'?",
        "scene.records[0].path": "must be text, got 3",
        "scene.records[0].every": "must be a number [s], got nan",
        "scene.records[0].fields[1]": "must be text, got 1",
    }
    for path, words in expected.items():
        assert any(re.match(re.escape(path) + r"[: ]", m) and words in m for m in found), f"{path}: {words}\n" + "\n".join(found)
    assert len(found) == len(expected), "\n".join(found)


@pytest.mark.parametrize("value", ["true", '"1000"', '"1e3"', "[1000.0]", "{ a = 1 }", "1979-05-27", "nan", "-1.0", "0"])
def test_what_is_no_positive_density(value):
    assert only_mistake(GOOD.replace('"1 g/cm^3"', value)).startswith("scene.materials.rubber.rho")


def test_numbers_beyond_floating_point():
    assert "too large" in only_mistake(GOOD.replace("cfl = 0.3", "cfl = 1" + 400 * "0"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (GOOD.replace("[grid]", "[grd]"), ["unknown key 'grd'; did you mean 'grid'", "required table [grid] is missing"]),
        ("", ["required table [grid]", "required table [shape]", "required table [integrator]"]),
        (GOOD.replace("[shape]\nkind", "[shape]\nname"), ["scene.shape: required key 'kind' is missing; one of"]),
        (GOOD.replace('[shape]\nkind = "QuadraticBSpline"', "").replace("[grid]", 'shape = "Linear"\n[grid]'), ["scene.shape: must be a table such as"]),
        (GOOD.replace("[[contacts]]", "[contacts]"), ["must be an array of tables, written [[contacts]]"]),
        (GOOD.replace('material = "rubber"', "material = 3"), ["scene.bodies[0].material: must be a table such as"]),
        (GOOD.replace("[materials.rubber]", "[materials]"), ["scene.materials.kind: must be a table", "no material is named 'rubber'"]),
        (GOOD.replace('kind = "Wall"', "kind = 3"), ["scene.boundaries[0].kind: must be the name of a boundary, got 3"]),
        (GOOD.replace("friction = 0.2", 'friction = 0.2\ncondition = "slip"'), ["scene.boundaries[0]: Wall.friction = 0.2 would be ignored"]),
        (GOOD.replace("radius = 0.1 }", "radius = 0.1, colour = 1 }"), ["scene.bodies[1].geometry.shapes[0].colour: unknown key"]),
        (GOOD.replace('"disks.vtkhdf"', '"disks.h5"'), ["scene.records[0]: Record.path must end in .vtkhdf or .hdf"]),
        (GOOD.replace('[[bodies]]\ngeometry.kind', '[[bodies]]\nname = "left"\ngeometry.kind'), ["two bodies are named 'left'"]),
    ],
)  # fmt: skip
def test_single_mistakes(text, words):
    found = "\n".join(mistakes(text))
    for word in words:
        assert word in found


def test_a_wrong_named_material_is_reported_once():
    assert only_mistake(GOOD.replace("nu = 0.3", "nu = 0.5")).startswith("scene.materials.rubber.nu")


def test_a_check_of_a_third_party_that_crashes_is_a_mistake_of_the_scene(fakes):
    fakes.material("mpmkit-foam", "foam", "Foam")
    foam = registry().get("Foam").component
    foam.check = lambda self: 1 / 0
    text = GOOD.replace('kind = "LinearElastic", E = 1e6, nu = 0', 'kind = "Foam"')
    assert "Foam refuses these values: ZeroDivisionError" in only_mistake(text)


def test_a_broken_plugin_is_named_where_its_component_is_wanted(fakes):
    fakes.add("mpmkit-bad", "bad", "import a_module_that_is_not_there")
    assert "not loaded: bad (mpmkit-bad 1.0)" in only_mistake(GOOD.replace('"NeoHookean"', '"Cork"'))


def test_two_plugins_with_one_name(fakes):
    fakes.material("mpmkit-a", "first", "Foam")
    fakes.material("mpmkit-b", "second", "Foam")
    assert "mpmkit-a 1.0 (first) and mpmkit-b 1.0 (second)" in only_mistake(GOOD.replace('"NeoHookean"', '"Foam"'))


# --- files ----------------------------------------------------------------------------------------------------------
def test_toml_syntax_error_with_line_and_column():
    with pytest.raises(SceneError, match=r"line 2, column 5") as error:
        scene.loads("a = 1\nb = = 2\n")
    assert str(error.value).splitlines()[1:] == ["  b = = 2", "      ^"]


@pytest.mark.parametrize("text", ["a = 1\na = 2", "[grid]\n[grid]", 'x = "\\q"', "a = .5", "[[bodies]]\n[bodies]", "\x00"])
def test_other_syntax_errors(text):
    with pytest.raises(SceneError, match="not valid TOML"):
        scene.loads(text)


@pytest.mark.parametrize(
    ("text", "words"),
    [('{"a": 1,}', "line 1, column"), ('{"a": 1, "a": 2}', "'a' appears twice"), ("[1]", "JSON object"), ('{"grid": NaN}', "grid")],
)
def test_json_errors(text, words):
    with pytest.raises(SceneError, match=words):
        scene.loads(text, format="json")


@pytest.mark.parametrize("text", ["a = " + 5000 * "[" + 5000 * "]", "x = " + 3000 * "{a=" + "1" + 3000 * "}"])
def test_deep_nesting_is_refused(text):
    with pytest.raises(SceneError):
        scene.loads(text)


def test_files_that_are_none(tmp_path):
    (tmp_path / "disks.toml").write_text(GOOD)
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "latin.toml").write_bytes("# Größe".encode("latin-1"))
    for name, words in {
        "dsks.toml": "did you mean 'disks.toml'",
        "folder.toml": "is a folder",
        "latin.toml": "UTF-8",
        "disks.yaml": "ends in .toml or .json",
        "nowhere/disks.toml": "no scene file",
    }.items():
        with pytest.raises(SceneError, match=words):
            scene.load(tmp_path / name)
    with pytest.raises(SceneError, match="cannot write"):
        scene.save(disks(), tmp_path / "nowhere" / "disks.toml")
    with pytest.raises(SceneError, match="must be 'toml' or 'json'"):
        scene.dumps(disks(), format="yaml")


def test_byte_order_mark_is_accepted(tmp_path):
    path = tmp_path / "disks.toml"
    path.write_text(GOOD, encoding="utf-8-sig")
    assert same(scene.load(path), scene.loads(GOOD))


# --- safety ---------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    "attack",
    [
        "__import__('os').mkdir('owned')",
        "().__class__.__bases__",
        "open('owned','w')",
        "exec('x')",
        "x.__class__",
        "[c for c in ()]",
        "lambda: 1",
        "9**9**9**9",
    ],
)
def test_loading_never_executes_what_a_file_says(tmp_path, monkeypatch, attack):
    monkeypatch.chdir(tmp_path)
    text = json.dumps(attack)
    for place in (
        GOOD.replace('"9.81*cos(t)"', text),
        GOOD.replace('"1 kPa"', text),
        GOOD.replace('"-0.1*sin(x)"', text),
        GOOD.replace('"Wall"', text),
    ):
        try:
            scene.loads(place)
        except SceneError:
            pass
        else:
            assert attack == "9**9**9**9"  # a formula of numbers, which is only worked out when it is used
    assert os.listdir(tmp_path) == []


def test_quantities_are_not_worked_out():
    assert "must be a number with a unit" in only_mistake(GOOD.replace('"1 kPa"', '"9**9**9 Pa"'))
    assert "must be a number with a unit" in only_mistake(GOOD.replace('"1 kPa"', '"1 Pa**9**9**9"'))


# --- writing --------------------------------------------------------------------------------------------------------
def test_script_to_toml_to_simulation_to_script():
    sim = disks()
    text = scene.dumps(sim)
    again = scene.loads(text)
    assert same(sim, again)
    assert scene.dumps(again) == text
    script = scene.to_script(again)
    names = {"__name__": "composed"}
    exec(script, names)
    assert same(names["sim"], sim)
    assert scene.to_script(names["sim"]) == script == scene.to_script(sim)


def test_round_trip_of_a_file_with_everything(tmp_path):
    sim = scene.loads(GOOD)
    for name in ("everything.toml", "everything.json"):
        scene.save(sim, tmp_path / name)
        assert same(scene.load(tmp_path / name), sim)
    names = {"__name__": "composed"}
    exec(scene.to_script(sim), names)
    assert same(names["sim"], sim)


def test_defaults_are_left_out_and_units_noted():
    text = scene.dumps(disks())
    assert "precision" not in text
    assert "lattice" not in text
    assert text.count('kind = "NeoHookean"') == 1
    assert "E = 1000.0  # Pa" in text
    assert "until = 3.6  # s" in text


@pytest.mark.parametrize("text", ['quote " and \\ back', "\u00e9\u4e16\U0001f600", "'", '"""', "a.b"])
def test_any_text_survives(text):
    sim = disks()
    sim += mpm.Body(mpm.Disk((0.5, 0.1), 0.05), LinearElastic(1.0, 0.0, 1.0), name=text)
    assert scene.loads(scene.dumps(sim)).bodies[2].name == text
    assert scene.loads(scene.dumps(sim, format="json"), format="json").bodies[2].name == text
    names = {"__name__": "composed"}
    exec(scene.to_script(sim), names)
    assert names["sim"].bodies[2].name == text


@given(st.floats(min_value=1e-300, max_value=1e300), st.floats(allow_nan=False, allow_infinity=False))
@settings(max_examples=50, deadline=None)
def test_every_number_survives_exactly(density, speed):
    sim = mpm.Simulation(mpm.Grid(0.0, 1.0, 0.1), shape=Linear(), integrator=MUSL())
    sim += mpm.Body(mpm.Box(0.0, 0.5), LinearElastic(1.0, 0.0, density), v=speed)
    again = scene.loads(scene.dumps(sim))
    assert again.bodies[0].material.rho == density
    assert again.bodies[0] == sim.bodies[0]


def test_things_a_file_cannot_hold_are_named_all_at_once():
    class Own(mpm.Effect):
        """Of a script."""

    own = mpm.define(Own)
    sim = disks()
    sim += Gravity((0.0, -9.81))
    sim += mpm.Body(mpm.Disk((0.5, 0.5), 0.05), LinearElastic(1.0, 0.0, 1.0), v=lambda x: 0.0 * x)
    sim += mpm.Body(PointCloud([[0.5, 0.9]], 0.01), LinearElastic(1.0, 0.0, 1.0))
    sim += own()
    sim += BodyForce(lambda X, t: (np.sin(t) * X[1], 0.0))
    for write in (scene.dumps, scene.to_script):
        with pytest.raises(SceneError) as error:
            write(sim)
        found = dict(re.match(r"(\S+?): (.*)", m).groups() for m in error.value.mistakes)
        assert "is a Python function; give a formula as text" in found["scene.bodies[2].v"]
        assert "PointCloud" in found["scene.bodies[3].geometry"]
        assert "Own" in found["scene.effects[1]"]
        assert found["scene.effects[2].value"].endswith('perhaps ["sin(t) * Y", "0.0"]')
        assert len(found) == 4


def test_proposed_formula_is_the_function():
    force = BodyForce(("sin(t) * Y", "0.0"))
    sim = disks()
    sim += force
    assert scene.loads(scene.dumps(sim)).effects == [force]


def examples(cls):
    """Components of a class built from its examples, with one parameter after the other away from its default."""
    optional = {
        n: spec.example
        for n, (attribute, spec) in specs(cls).items()
        if attribute.default is not attrs.NOTHING and spec.example is not None
    }
    made = []
    for more in [{}, *({name: value} for name, value in optional.items())]:
        try:
            made.append(cls(**example_arguments(cls) | more))
        except mpm.ParameterError:
            continue  # parameters that need each other
    assert made, f"no example of {cls.__name__} works"
    return made


def placed(part):
    """A simulation that holds a component or geometry."""
    kind = getattr(part, "kind", "geometry")
    sections = {"shape": Linear(), "integrator": MUSL()}
    dim = part.dim if kind == "geometry" else 2
    if kind == "transfer":
        sections["integrator"] = MUSL(part)
    elif kind in ("shape", "integrator", "discretization"):
        sections[kind] = part
    sim = mpm.Simulation(mpm.Grid(dim * (0,), dim * (1,), 0.1), **sections)
    if kind == "geometry":
        sim += mpm.Body(part, LinearElastic(1.0, 0.0, 1.0))
    elif kind == "material":
        sim += mpm.Body(mpm.Disk((0.5, 0.5), 0.2), part)
    elif kind not in (*sections, "transfer"):
        sim += part
    return sim


@pytest.mark.parametrize("cls", [e.component for e in registry().entries] + list(GEOMETRIES.values()), ids=lambda cls: cls.__name__)
def test_every_component_and_geometry_round_trips(cls):
    for part in examples(cls):
        sim = placed(part)
        assert same(scene.loads(scene.dumps(sim)), sim)
        names = {"__name__": "composed"}
        exec(scene.to_script(sim), names)
        assert same(names["sim"], sim)


def test_nested_geometry_in_a_boundary():
    sim = disks()
    sim += PrescribedVelocity(velocity=("t", 0.0), region=mpm.Box((0, 0), (0.1, 1)) | mpm.Disk((0.5, 0.5), 0.1))
    assert same(scene.loads(scene.dumps(sim)), sim)


# --- fuzz -----------------------------------------------------------------------------------------------------------
junk = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=8)
    | st.sampled_from(["Disk", "rubber", "1 m", "Wall", "x*t", "3 m/s"]),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(["kind", "E", "shapes", "center", "rho", "a b"]), inner, max_size=3)
    ),
    max_leaves=6,
)


@given(st.data())
@settings(max_examples=150, deadline=None)
def test_junk_anywhere_is_a_scene_error_or_a_scene(data):
    import tomllib

    tree = tomllib.loads(GOOD)
    here = tree
    for _ in range(data.draw(st.integers(1, 4))):
        keys = list(here) if isinstance(here, dict) else list(range(len(here)))
        if not keys:
            break
        key = data.draw(st.sampled_from(keys))
        if not isinstance(here[key], (dict, list)) or data.draw(st.booleans()):
            here[key] = data.draw(junk)
            break
        here = here[key]
    try:
        sim = scene.loads(json.dumps(tree), format="json")
    except SceneError as error:
        assert "Traceback" not in str(error)  # noqa: PT017  (either outcome is allowed, this one must be readable)
    else:
        assert same(scene.loads(scene.dumps(sim)), sim)
