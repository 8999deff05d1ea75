"""What a fresh process imports: nothing heavy before it is used, no plugin before it is asked for."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = ("numba", "llvmlite", "h5py", "matplotlib", "scipy", "pint", "cattrs", "vtk")


def loaded(code: str) -> set[str]:
    """Top-level modules in ``sys.modules`` after `code` has run in a fresh process."""
    program = f"import sys\ntry:\n    exec({code!r})\nexcept SystemExit as end:\n    assert not end.code, end\nprint()\nprint(*sys.modules)"
    out = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert out.returncode == 0, out.stderr
    return {name.split(".")[0] for name in out.stdout.splitlines()[-1].split()}


def test_import_loads_no_plugin_and_nothing_heavy():
    names = loaded("import mpmkit")
    assert not {n for n in names if n.startswith("mpmkit_")}
    assert not names & {*HEAVY, "numpy", "rich", "click", "pluggy"}


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"], ["study", "--help"], ["--version"]], ids=" ".join)
def test_help_loads_no_plugin_and_nothing_heavy(arguments):
    names = loaded(f"from mpmkit.cli import main; main({arguments!r})")
    assert not {n for n in names if n.startswith("mpmkit_")}
    assert not names & {*HEAVY, "numpy"}


@pytest.mark.parametrize("arguments", [["list-plugins"], ["list-plugins", "--json"], ["describe", "NeoHookean"]], ids=" ".join)
def test_lists_load_plugins_but_neither_compiler_nor_files(arguments):
    names = loaded(f"from mpmkit.cli import main; main({arguments!r})")
    assert "mpmkit_materials" in names
    assert not names & set(HEAVY)


def test_registering_everything_needs_no_numpy():
    names = loaded("from mpmkit._core.registry import registry; assert registry().entries and not registry().broken")
    assert not names & {*HEAVY, "numpy"}
