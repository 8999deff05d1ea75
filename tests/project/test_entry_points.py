"""The lists in pyproject.toml against the folders in plugins/, and each entry point by itself."""

from __future__ import annotations

import importlib
import pkgutil
from importlib.metadata import entry_points

import pytest

import mpmkit
from mpmkit._core.registry import registry
from mpmkit.interfaces import KINDS

OURS = [p for p in entry_points(group="mpmkit") if p.dist is not None and p.dist.name == "mpmkit"]


@pytest.mark.parametrize("point", OURS, ids=[p.name for p in OURS])
def test_each_entry_point_loads_and_returns_components(point):
    module = point.load()
    assert list(module.mpmkit_components())


def test_nothing_of_ours_is_broken_or_double():
    assert [b for b in registry().broken if b.distribution == "mpmkit"] == []
    assert registry().duplicates == {}


def test_every_kind_has_a_component_and_a_namespace():
    for kind in KINDS:
        assert registry().of(kind), kind
    for module in ("boundaries", "contacts", "discretizations", "effects", "integrators", "materials", "shapes"):
        namespace = importlib.import_module(f"mpmkit.{module}")
        assert dir(namespace)
        for name in dir(namespace):
            assert getattr(namespace, name).__name__ == name


def test_the_lists_of_pyproject_are_the_folders_of_plugins(root, pyproject):
    folders = {p.parent.name for p in (root / "plugins").glob("*/__init__.py")}
    assert set(pyproject["project"]["entry-points"]["mpmkit"].values()) == folders
    linter = pyproject["tool"]["importlinter"]
    assert set(linter["root_packages"]) == folders | {"mpmkit"}
    contracts = {c["id"]: c for c in linter["contracts"]}
    assert set(contracts["core-without-plugins"]["forbidden_modules"]) == folders
    assert set(contracts["plugins-apart"]["modules"]) == folders
    assert set(contracts["plugins-public"]["source_modules"]) == folders


def test_installed_entry_points_are_those_of_pyproject(pyproject):
    # a checkout whose pyproject changed must be installed again
    assert {p.name: p.value for p in OURS} == pyproject["project"]["entry-points"]["mpmkit"]


def test_the_wheel_takes_both_source_roots(root, pyproject):
    wheel = pyproject["tool"]["hatch"]["build"]["targets"]["wheel"]
    assert wheel["only-include"] == wheel["sources"] == ["src", "plugins"]
    assert pyproject["tool"]["hatch"]["build"]["dev-mode-dirs"] == ["src", "plugins"]
    for folder in wheel["sources"]:
        assert (root / folder).is_dir()


def test_every_module_of_the_core_stands_on_a_floor(pyproject):
    floors = next(c for c in pyproject["tool"]["importlinter"]["contracts"] if c["id"] == "floors")
    placed = {name.strip() for layer in floors["layers"] for name in layer.replace("|", ":").split(":")}
    namespaces = {f"mpmkit.{n}" for n in ("boundaries", "contacts", "discretizations", "effects", "integrators", "materials", "shapes")}
    there = {m.name for m in pkgutil.iter_modules(mpmkit.__path__, "mpmkit.")}
    import mpmkit._core as core

    there |= {m.name for m in pkgutil.iter_modules(core.__path__, "mpmkit._core.")}
    assert there - placed - namespaces - {"mpmkit.__main__", "mpmkit._core"} == set()


def test_version_is_said_the_same_everywhere(root, pyproject):
    assert pyproject["project"]["version"] == mpmkit.__version__
    assert f"version: {mpmkit.__version__}\n" in (root / "CITATION.cff").read_text()
    assert f"## [{mpmkit.__version__}]" in (root / "CHANGELOG.md").read_text()
