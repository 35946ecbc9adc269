"""The page: valid, and complete in itself."""

from __future__ import annotations

import re
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

from hgs_core.base.progress import silent
from hgs_core.report.write import write_report
from tests.hgs_core.report.finished_run import write_finished_run

VOID = {"meta", "link", "img", "input"}


class Page(HTMLParser):
    """Elements that open and close in order, with their references."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        assert len(dict(attributes)) == len(attributes), f"<{tag}> has an attribute twice"
        self.tags.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attributes)))

    def handle_endtag(self, tag: str) -> None:
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    def values(self, attribute: str) -> list[str]:
        return [value for _, attributes in self.tags if (value := attributes.get(attribute)) is not None]


def test_elements_nest_and_references_resolve(report: Path) -> None:
    page = Page(report.read_text())
    assert page.open == []
    ids = Counter(page.values("id"))
    assert set(ids.values()) == {1}
    assert {value.removeprefix("#") for value in page.values("href") if value.startswith("#")} <= set(ids)
    assert set(page.values("aria-labelledby")) <= set(ids)


def test_pictures_charts_and_sliders_have_names(report: Path) -> None:
    page = Page(report.read_text())
    for tag, attribute in (("img", "alt"), ("svg", "aria-label"), ("input", "aria-label")):
        named = [attributes.get(attribute) for found, attributes in page.tags if found == tag]
        assert named, tag
        assert all(named), tag


def test_charts_are_well_formed_svg(report: Path) -> None:
    charts = re.findall(r"<svg.*?</svg>", report.read_text(), re.DOTALL)
    assert len(charts) >= 10
    for chart in charts:
        assert "nan" not in " ".join(re.findall(r'"[^"]*"', chart)).split()
        ElementTree.fromstring(chart)


def test_the_page_refers_to_nothing_outside_itself(report: Path) -> None:
    page = Page(report.read_text())
    for attribute in ("src", "href", "srcset", "action", "data", "poster"):
        assert all(value.startswith(("data:", "#")) for value in page.values(attribute))
    assert "url(" not in report.read_text()
    assert "@import" not in report.read_text()


def test_settings_that_differ_from_the_preset_are_listed(report: Path) -> None:
    assert '<tr><th scope="row">train.iterations</th><td>3200</td><td>40</td></tr>' in report.read_text()


def test_the_page_says_that_no_lens_was_learned(report: Path, tmp_path: Path) -> None:
    words = "Training learned no lens falloff"
    assert words in report.read_text()
    run = write_finished_run(tmp_path, lens_falloff=[-0.1, 0.0])
    write_report(run, tmp_path / "page.html", (), silent)
    assert words not in (tmp_path / "page.html").read_text()


def test_the_page_names_the_machine_that_trained_the_run(tmp_path: Path) -> None:
    machine = {"hgs": "1.2.3", "cpu": "a <processor>", "cores": 4}
    write_report(write_finished_run(tmp_path, machine=machine), tmp_path / "page.html", (), silent)
    page = (tmp_path / "page.html").read_text()
    assert "Trained by HGS 1.2.3 on a &lt;processor&gt;, 4 cores." in page
