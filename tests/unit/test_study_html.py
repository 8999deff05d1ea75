from __future__ import annotations

import re
from html.parser import HTMLParser

import pytest
from small_study import ENDS, STRESS, results

import mpmkit as mpm
from mpmkit.studies import html
from mpmkit.studies.results import REPORTS, StudyResults

VOID = {"meta", "br", "img", "input", "link", "hr"}
LOADING = {"src", "href", "xlink:href", "data", "action", "srcset", "poster"}


class Page(HTMLParser):
    """What a page has; mistakes in its nesting."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.ids, self.loads, self.wrong, self.rows, self.text = [], [], [], [], [], [], ""
        self.feed(text)
        self.wrong += self.open

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        found = dict(attrs)
        self.ids += [found["id"]] if "id" in found else []
        self.loads += [found[name] for name in LOADING if name in found]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def handle_data(self, data):
        self.text += data


@pytest.fixture(scope="module")
def text():
    return html.page(results())


@pytest.fixture(scope="module")
def page(text):
    return Page(text)


def test_the_page_is_well_formed_and_loads_nothing(page):
    assert page.wrong == []
    assert len(page.ids) == len(set(page.ids))
    assert all(target.startswith("#") for target in page.loads)
    assert not {"link", "iframe", "object"} & set(page.tags) and page.tags.count("script") == 1
    assert "url(http" not in page.text and "@import" not in page.text


def test_it_has_everything(page):
    for told in (STRESS, ENDS, "For an error of 0.01 Pa the cheapest is GIMP", "blew up", "spacing = 0.1", "made-up processor", "numpy"):
        assert told in page.text
    assert page.tags.count("svg") == 4 and page.tags.count("table") == 3


def test_it_fits_phones_and_darkness(text):
    assert '<meta name="viewport" content="width=device-width, initial-scale=1">' in text
    assert "prefers-color-scheme: dark" in text and 'class="scroll"><table' in text
    assert "default-src 'none'" in text


def test_tables_sort_by_numbers_not_by_their_text(text):
    assert re.search(r'<td class="n" data-value="3.90625\d*e-06">3.91e-6</td>', text)
    assert '<td data-value="0.0125">0.0125</td>' in text


def test_names_and_reasons_are_no_markup():
    rows = [row | {"reason": row["reason"] and "<script>alert(1)</script>", "composition": "<b>&"} for row in results()]
    text = html.page(StudyResults(rows, results().meta | {"name": "</title><b>"}))
    assert "<script>alert" not in text and "<b>" not in text and Page(text).wrong == []


def test_a_notebook_shows_a_fragment():
    text = results()._repr_html_()
    assert Page(text).wrong == [] and "<html" not in text and text.count("<svg") == 4


@pytest.mark.parametrize("ending", REPORTS)
def test_a_report_of_every_kind(tmp_path, ending):
    path = results().report(tmp_path / "sub" / f"study{ending}")
    assert path.stat().st_size > 500


def test_markdown_has_the_sentences(tmp_path):
    text = results().report(tmp_path / "study.md", ["1%"]).read_text()
    assert (
        text.startswith("# made-up bar\n")
        and "- For an error of 0.01 Pa the cheapest is GIMP" in text
        and "| shape | grid.spacing |" in text
    )


def test_other_endings_and_places_are_refused(tmp_path):
    with pytest.raises(mpm.ResultsError, match="it must end in .html, .md"):
        results().report(tmp_path / "study.pdf")
    (tmp_path / "file").write_text("")
    with pytest.raises(mpm.ResultsError, match="choose another place"):
        results().report(tmp_path / "file" / "study.html")


def test_an_empty_study_still_has_a_page():
    assert Page(html.page(StudyResults([], {}))).wrong == []
