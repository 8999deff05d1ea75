"""Sphinx configuration; pages that can be known from the code are written first."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

import generate  # noqa: E402

import mpmkit  # noqa: E402

generate.main(HERE)

project = "mpmkit"
author = "The mpmkit developers"
version = release = mpmkit.__version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.mathjax", "sphinx.ext.napoleon"]
exclude_patterns = ["_build", "figures", "reference/fields-table.md", "performance-tables.md", "stability-tables.md"]
default_role = "code"
html_theme = "furo"
html_title = f"mpmkit {release}"
myst_heading_anchors = 3
napoleon_google_docstring = False
napoleon_use_rtype = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"
