"""Fixtures of the unit tests."""

from __future__ import annotations

import importlib
import sys
import textwrap
from importlib.metadata import distributions
from pathlib import Path

import pytest

from mpmkit._core.registry import Registry, registry

MATERIAL = '''
    """A plugin."""
    import mpmkit as mpm

    @mpm.kernel
    def no_stress(F):
        """Nothing."""
        return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)

    @mpm.kernel
    def slow():
        return 1.0

    @mpm.define
    class {name}(mpm.ConstitutiveModel):
        """A material without stress."""

        rho: float = mpm.parameter("reference density", unit="kg/m^3", gt=0, example=1.0)
        stress = no_stress
        wave_speed = slow

    @mpm.hookimpl
    def mpmkit_components():
        return [{name}]
'''
"""Source of a plugin with one material."""


class FakeDistributions:
    """Writes plugins with their metadata into a folder, as an installer would."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def add(self, distribution: str, module: str, source: str, *, version: str = "1.0", point: str | None = None) -> None:
        """Install one module with one entry point."""
        (self.folder / f"{module}.py").write_text(textwrap.dedent(source))
        info = self.folder / f"{distribution.replace('-', '_')}-{version}.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: {version}\n")
        (info / "entry_points.txt").write_text(f"[mpmkit]\n{point or module} = {module}\n")

    def material(self, distribution: str, module: str, name: str, **kwargs: str) -> None:
        """Install a plugin with one material called `name`."""
        self.add(distribution, module, MATERIAL.format(name=name), **kwargs)

    def registry(self) -> Registry:
        """A registry of these plugins alone."""
        return Registry([p for d in distributions(path=[str(self.folder)]) for p in d.entry_points if p.group == "mpmkit"])


@pytest.fixture
def fakes(tmp_path, monkeypatch):
    """An empty place for fake plugins; what is installed there is also seen by the registry of this process."""
    folder = tmp_path / "site"
    folder.mkdir()
    before = set(sys.modules)
    monkeypatch.syspath_prepend(str(folder))
    importlib.invalidate_caches()
    registry.cache_clear()
    yield FakeDistributions(folder)
    registry.cache_clear()
    for name in set(sys.modules) - before:
        if getattr(sys.modules[name], "__file__", None) and str(folder) in str(sys.modules[name].__file__):
            del sys.modules[name]


@pytest.fixture
def plain_python(monkeypatch):
    """Composed in this test, the generated step runs as plain Python: small scenes are done before a compiler has started."""
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")
