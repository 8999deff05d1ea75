"""What must not be in the project's files, and what must."""

from __future__ import annotations

import re
import stat

# the words are put together here so that this file does not contain them
SECRET = {
    "the host of a package index": r"pypi\." + r"(org|python)|files\.python" + r"hosted|index-" + r"url|registry\.npm" + r"js",
    "a path of one machine": r"(?<![\w./])/(home|root|work|Users|tmp|opt)" + r"/[\w.]",
}


def test_no_file_names_a_package_index_or_a_machine_path(root, files):
    found = []
    for path in files:
        text = path.read_text(encoding="utf-8", errors="replace")
        for what, pattern in SECRET.items():
            for line, content in enumerate(text.splitlines(), 1):
                if re.search(pattern, content):
                    found.append(f"{path.relative_to(root)}:{line}: {what}: {content.strip()[:100]}")
    assert found == []


def test_the_house_is_complete(root):
    for name in (
        "README.md",
        "ARCHITECTURE.md",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "CITATION.cff",
        "LICENSE",
        "tests/README.md",
        "docs/index.md",
    ):
        assert (root / name).stat().st_size > 500, name
    assert (root / ".ci/run").stat().st_mode & stat.S_IXUSR


def test_the_license_is_apache_2(root, pyproject):
    text = (root / "LICENSE").read_text()
    assert "Apache License" in text
    assert "END OF TERMS AND CONDITIONS" in text
    assert pyproject["project"]["license"] == "Apache-2.0"
    assert "license: Apache-2.0\n" in (root / "CITATION.cff").read_text()


def test_every_folder_of_tests_is_in_their_map(root):
    text = (root / "tests/README.md").read_text()
    folders = {p.name for p in (root / "tests").iterdir() if p.is_dir() and any(p.rglob("*.py")) and not p.name.startswith("_")}
    assert {f for f in folders if f"`{f}/`" not in text} == set()


def test_examples_say_what_they_show(root):
    for path in (root / "examples").glob("*.py"):
        text = path.read_text(encoding="utf-8")
        if "def main(" in text:
            assert text.startswith('"""'), path.name
            assert "def check(" in text, f"{path.name}: no statement about its end result"
