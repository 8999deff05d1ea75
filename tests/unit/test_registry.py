"""The registry: plugins are loaded one by one, and whatever is wrong with one of them is said and harms no other."""

import pytest

import mpmkit as mpm
from mpmkit._core.registry import entry_of, registry
from mpmkit.errors import PluginError


def reasons(found):
    return {b.plugin: b.reason for b in found.broken}


def test_component_with_origin(fakes):
    fakes.material("mpmkit-foam", "foam", "Foam", version="2.3", point="soft")
    entry = fakes.registry().get("Foam", "material")
    assert (entry.name, entry.kind, entry.plugin, entry.distribution, entry.version) == ("Foam", "material", "soft", "mpmkit-foam", "2.3")


@pytest.mark.parametrize(
    ("source", "reason"),
    [
        ("import a_module_that_is_not_there", "ModuleNotFoundError: No module named 'a_module_that_is_not_there'"),
        ("import sys; sys.exit(3)", "SystemExit: 3"),
        ("1 / 0", "ZeroDivisionError"),
        ("def broken(:", "SyntaxError"),
        ("x = 1", "no function mpmkit_components()"),
        ("import mpmkit as mpm\n@mpm.hookimpl\ndef mpmkit_components():\n    return [int]", "is not a component class"),
        ("import mpmkit as mpm\n@mpm.hookimpl\ndef mpmkit_components():\n    raise RuntimeError('later')", "RuntimeError: later"),
    ],
)
def test_broken_plugin_is_kept_with_its_reason_and_harms_no_other(fakes, source, reason):
    fakes.add("mpmkit-bad", "bad", source)
    fakes.material("mpmkit-good", "zz_good", "Foam")  # after the bad one in alphabetical order
    found = fakes.registry()
    assert reason in reasons(found)["bad"]
    assert found.get("Foam").distribution == "mpmkit-good"
    assert not set(reasons(found)) - {"bad"}


def test_missing_module_of_an_entry_point(fakes):
    fakes.material("mpmkit-gone", "gone", "Gone")
    (fakes.folder / "gone.py").unlink()
    assert "ModuleNotFoundError" in reasons(fakes.registry())["gone"]


def test_ctrl_c_while_loading_is_not_swallowed(fakes):
    fakes.add("mpmkit-bad", "bad", "raise KeyboardInterrupt")
    with pytest.raises(KeyboardInterrupt):
        fakes.registry()


def test_unknown_name_lists_what_could_not_be_loaded(fakes):
    fakes.add("mpmkit-bad", "bad", "import a_module_that_is_not_there", version="0.7")
    fakes.material("mpmkit-good", "good", "Foam")
    with pytest.raises(PluginError, match=r"no material named 'Faom'.*did you mean 'Foam'") as error:
        fakes.registry().get("Faom", "material")
    assert "not loaded: bad (mpmkit-bad 0.7): ModuleNotFoundError" in str(error.value)


def test_a_name_of_another_kind_is_unknown(fakes):
    fakes.material("mpmkit-good", "good", "Foam")
    with pytest.raises(PluginError, match="no shape named 'Foam'"):
        fakes.registry().get("Foam", "shape")


def test_two_plugins_with_one_name_are_refused_when_used(fakes):
    fakes.material("mpmkit-a", "first", "Foam")
    fakes.material("mpmkit-b", "second", "Foam", version="2.0")
    fakes.material("mpmkit-c", "third", "Cork")
    found = fakes.registry()
    assert list(found.duplicates) == [("material", "Foam")]
    with pytest.raises(PluginError, match=r"mpmkit-a 1\.0 \(first\) and mpmkit-b 2\.0 \(second\)"):
        found.get("Foam", "material")
    assert found.get("Cork", "material").plugin == "third"


def test_one_class_registered_twice_is_no_duplicate(fakes):
    fakes.material("mpmkit-a", "first", "Foam")
    fakes.add("mpmkit-b", "second", "from first import Foam, mpmkit_components")
    found = fakes.registry()
    assert len(found.entries) == 2
    assert not found.duplicates


def test_disabled_plugin(fakes, monkeypatch):
    fakes.material("mpmkit-a", "first", "Foam")
    fakes.material("mpmkit-b", "second", "Foam")
    monkeypatch.setenv("MPMKIT_DISABLE_PLUGINS", "other, second")
    found = fakes.registry()
    assert [e.plugin for e in found.entries] == ["first"]
    assert found.get("Foam").distribution == "mpmkit-a"


def test_namespace_shows_third_party_components(fakes):
    fakes.material("mpmkit-foam", "foam", "Foam")
    from mpmkit import materials

    assert "Foam" in dir(materials)
    assert materials.Foam is registry().get("Foam", "material").component
    with pytest.raises(AttributeError, match="did you mean 'Foam'"):
        _ = materials.Foma


def test_entry_of_a_class(fakes):
    fakes.material("mpmkit-foam", "foam", "Foam")
    component = registry().get("Foam").component
    assert entry_of(component).plugin == entry_of(component(rho=1.0)).plugin == "foam"

    class Other(mpm.Effect):
        """Not registered."""

    assert entry_of(Other) is None


def test_every_bundled_plugin_loads():
    ours = [b for b in registry().broken if b.distribution == "mpmkit"]
    assert ours == []
    assert {e.kind for e in registry().entries if e.distribution == "mpmkit"} == {
        "shape", "material", "contact", "boundary", "integrator", "transfer", "effect", "discretization",
    }  # fmt: skip
